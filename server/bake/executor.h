// Work side by side on this machine's cores.
#pragma once

#include "common/simplify/history.h"

namespace lodestream::bake {

// Runs tasks on this thread and on as many more as there are cores. A task that throws ends the run: the first
// exception is thrown again when all threads have stopped.
simplify::Executor all_cores();

}  // namespace lodestream::bake
