// A tileset as one file: a 3D Tiles archive (.3tz 1.3), which is a ZIP file of stored entries whose last one is an
// index from the MD5 of a path to the entry's place, so that a reader finds any tile with one search.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"

namespace lodestream::store {

inline constexpr const char* archive_extension = ".3tz";
inline constexpr const char* archive_index_name = "@3dtilesIndex1@";
inline constexpr std::uint64_t max_archived_bytes = 0xffff'fffe;  // of one entry: its header has 32 bits for them

class TileArchive {
  public:
    // Written beside `file` and put in its place by finish(); without that, nothing is left. Errors: io.
    static Result<TileArchive> create(const std::filesystem::path& file);
    TileArchive(TileArchive&&) noexcept;
    TileArchive& operator=(TileArchive&&) noexcept;
    ~TileArchive();

    // `path` as the tileset names it, in ASCII, no two alike. Errors: io, limit_exceeded (max_archived_bytes).
    Status add(const std::string& path, std::span<const std::byte> bytes);
    // Nothing can be added afterwards. Errors: io.
    Status finish();

  private:
    struct Impl;
    explicit TileArchive(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace lodestream::store
