// Between light and what an 8-bit display is told of it (IEC 61966-2-1).
#pragma once

#include <cmath>

namespace lodestream {

// [0, 1] to [0, 1].
inline double srgb_of_light(double light) {
    return light <= 0.0031308 ? light * 12.92 : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
}

// The other way round.
inline double light_of_srgb(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

}  // namespace lodestream
