// The baseline that looks back only: an accepted error that moves by 5 % a frame, as Nexus does.
#pragma once

#include <span>

#include "common/control/control.h"

namespace lodestream::control {

inline constexpr double reactive_step = 1.05;

struct Reactive {
    double error_px = 0.0;  // that is accepted; kept within what the ladder can show
    std::uint32_t level = 0;
};

// Longer than the deadline by more than 5 %: 5 % more error; shorter by more than 5 %: 5 % less; the level is the
// coarsest with no more error than that. `frame_ms` below 0: not known, nothing changes.
Reactive react(double error_px, double frame_ms, double deadline_ms, std::span<const Level> ladder);

}  // namespace lodestream::control
