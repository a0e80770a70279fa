// A stored file as memory: pages are read when they are used and given back when memory is short.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <utility>

#include "common/base/result.h"

namespace lodestream::store {

class MappedFile {
  public:
    // Errors: io; limit_exceeded (larger than max_bytes).
    static Result<MappedFile> open(const std::filesystem::path& file, std::uint64_t max_bytes);
    MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
    MappedFile& operator=(MappedFile&& other) noexcept {
        std::swap(bytes_, other.bytes_);
        return *this;
    }
    ~MappedFile();

    std::span<const std::byte> bytes() const { return bytes_; }  // begins at a page; valid as long as this lives

  private:
    explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}
    std::span<const std::byte> bytes_;
};

}  // namespace lodestream::store
