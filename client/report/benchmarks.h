// What benchmarks found (tests/bench): this project beside its peers, on several models.
#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "proto/benchmark_runs.h"

namespace lodestream::report {

inline constexpr std::uintmax_t max_benchmark_file_bytes = 16u << 20;

// Read what `lodestream_bench_simplify --json`, `lodestream_bench_codec --sweep`, `lodestream_bench_points --json` and
// `lodestream_bench_hlod --growth … --json` wrote. Errors: io (cannot be read), limit_exceeded (too large),
// invalid_input (with the place where it is not that).
Result<proto::MethodRun> read_methods(const std::filesystem::path& file);
Result<proto::CodecRun> read_codecs(const std::filesystem::path& file);
Result<proto::PointsRun> read_points(const std::filesystem::path& file);
Result<proto::SceneRun> read_scenes(const std::filesystem::path& file);

}  // namespace lodestream::report
