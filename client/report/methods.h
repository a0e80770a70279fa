// What the simplification benchmark found (tests/bench): this project's engine beside its peers, on several models.
#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "proto/method_run.h"

namespace lodestream::report {

inline constexpr std::uintmax_t max_methods_file_bytes = 16u << 20;

// Reads what `lodestream_bench_simplify --json` wrote. Errors: io (cannot be read), limit_exceeded (too large),
// invalid_input (with the place where it is not that).
Result<proto::MethodRun> read_methods(const std::filesystem::path& file);

}  // namespace lodestream::report
