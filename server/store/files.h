// Files written so that a crash leaves all of them or nothing, and the store's lock. Private to the store.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "common/base/result.h"

namespace lodestream::store {

class FileDescriptor {
  public:
    explicit FileDescriptor(int descriptor = -1) : descriptor_(descriptor) {}
    FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept {
        std::swap(descriptor_, other.descriptor_);
        return *this;
    }
    ~FileDescriptor();
    int get() const { return descriptor_; }

  private:
    int descriptor_;
};

std::string sha256_hex(std::span<const std::byte> bytes);

Status make_folder(const std::filesystem::path& folder);   // one level, flushed into its parent; there already is fine
Status flush_folder(const std::filesystem::path& folder);  // names in it survive a power cut
Status write_file(const std::filesystem::path& file, std::span<const std::byte> bytes);       // a new one, not flushed
Status write_and_flush(const std::filesystem::path& file, std::span<const std::byte> bytes);  // a new file
Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to);
bool is_regular_file(const std::filesystem::path& file, std::uint64_t& bytes);  // not through a symbolic link

// An open, unlocked lock file; the lock goes when it is closed, also by a crash.
Result<FileDescriptor> open_lock(const std::filesystem::path& file);
bool try_lock_alone(const FileDescriptor& lock);
Status lock_shared(const FileDescriptor& lock);  // waits for whoever is alone

Error file_error(const std::filesystem::path& file, const char* what);  // from errno

}  // namespace lodestream::store
