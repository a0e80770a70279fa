// The speed-based controllers as the papers give them. Levels are 0 … last; S_min, α and LOD_est as in seeds-digest §2.
#pragma once

#include <cstdint>

#include "common/control/control.h"

namespace lodestream::control {

// The level that a speed asks for, at once, whenever the speed changes; where isblc() would arrive in the end: still:
// 0, else ⌈speed * α⌉.
std::uint32_t sblc(std::uint32_t level, double speed_deg_s, double last_speed_deg_s, std::uint32_t last,
                   const SpeedOptions& options);

// Still: one step finer. Else, where LOD_est = speed * α exceeds the level: one step coarser. Else: held.
std::uint32_t isblc(std::uint32_t level, double speed_deg_s, std::uint32_t last, const SpeedOptions& options);

// As isblc() with LOD_est = acceleration * levels_per_deg_s2: coarser before the speed is there, held while the speed
// is even or falls, finer when still. Acceleration counts only where it makes the view faster.
std::uint32_t acceleration(std::uint32_t level, double speed_deg_s, double acceleration_deg_s2, std::uint32_t last,
                           const SpeedOptions& options);

}  // namespace lodestream::control
