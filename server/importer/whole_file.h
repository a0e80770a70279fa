#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/base/result.h"

namespace lodestream::importer {

// Errors: not_found, invalid_input (not a regular file), limit_exceeded, io.
Result<std::vector<std::byte>> read_whole_file(const std::filesystem::path& file, std::uint64_t max_bytes);

}  // namespace lodestream::importer
