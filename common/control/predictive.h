// The controller that looks ahead: the finest level that the model of frame time predicts to keep the deadline, now and
// along the motion, with hysteresis and a bounded number of switches.
#pragma once

#include <span>

#include "common/control/control.h"

namespace lodestream::control {

struct Prediction {
    PredictiveState state;
    std::uint32_t level = 0;
    double predicted_ms = 0.0;
};

// pre: every value in `now` is finite and in range, but frame_ms (not a number: not known) and budget_triangles
// (infinite: none); `level` is that of the frame before; `acceleration_deg_s2` is finite
Prediction predict(PredictiveState state, std::uint32_t level, const Measurement& now, double acceleration_deg_s2,
                   std::span<const Level> ladder, const Options& options);

}  // namespace lodestream::control
