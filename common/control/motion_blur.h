// Motion blur in steps by speed (ISBLC paper, future work; seeds-digest §2): a frame is the mean of several exposures,
// pictures of the moments since the frame before. What moves fast is blurred and hides a coarse level; what is still is
// drawn once and stays sharp. Every exposure costs a drawing of the scene.
#pragma once

#include <cstdint>

namespace lodestream::control {

inline constexpr std::uint32_t max_exposures = 4;

struct BlurOptions {
    bool enabled = true;
    double two_above_deg_s = 10.0;   // two exposures above this speed; 1/6 degree a frame at 60 frames/s
    double four_above_deg_s = 90.0;  // four above this one
};

// 1, 2 or 4; 1 where blur is off or the speed is not a number.
std::uint32_t exposures(double speed_deg_s, const BlurOptions& options);

}  // namespace lodestream::control
