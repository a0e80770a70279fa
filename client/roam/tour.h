// A way past a scene, for where no motion is given.
#pragma once

#include "common/base/math.h"
#include "common/motion/motion.h"

namespace lodestream::roam {

inline constexpr double tour_s = 12.0;

// From where all of it is in view close up to one end of its longer side, along that side, and away again. Of an empty
// box or one point: stands still.
motion::Trace tour(const Box& bounds);

}  // namespace lodestream::roam
