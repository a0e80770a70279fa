// What bakes of growing scenes took, as `lodestream-client report --scenes` reads it (proto::parse_scene_run).
#pragma once

#include <string>

#include "proto/benchmark_runs.h"

namespace lodestream::bench {

// Of one scene. The run's origin is this program's, called with `command_line`. Throws std::runtime_error where it
// cannot be written.
void write_scene_run(const std::string& file, const std::string& command_line, const proto::SceneRun& run);

}  // namespace lodestream::bench
