// What the points benchmark found, as `lodestream-client report --points` reads it (proto::parse_points_run).
#pragma once

#include <string>

#include "proto/benchmark_runs.h"

namespace lodestream::bench {

// The run's origin is this program's, called with `command_line`. Throws std::runtime_error where it cannot be written.
void write_points_run(const std::string& file, const std::string& command_line, const proto::PointsRun& run);

}  // namespace lodestream::bench
