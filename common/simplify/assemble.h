// Turns what was recorded, fine to coarse, into a history, coarse to fine.
#pragma once

#include <vector>

#include "common/simplify/history.h"
#include "common/simplify/log.h"
#include "common/simplify/surface.h"

namespace lodestream::simplify {

// `logs`: of all workers; a log's steps build on earlier ones and on those of earlier logs.
History assemble(const Surface& surface, std::vector<Log> logs, const Executor& executor);

}  // namespace lodestream::simplify
