// Directions spread evenly over the sphere.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/base/math.h"

namespace lodestream {

// The i-th of `count` on a golden-angle spiral from +y downwards, unit length. pre: i < count
inline Vec3d spread_direction(std::size_t i, std::size_t count) {
    const double golden_angle = pi * (3.0 - std::sqrt(5.0));
    const double height = 1.0 - 2.0 * static_cast<double>(i) / static_cast<double>(count);
    const double around = std::sqrt(std::max(0.0, 1.0 - height * height));
    const double turn = golden_angle * static_cast<double>(i);
    return {around * std::cos(turn), height, around * std::sin(turn)};
}

}  // namespace lodestream
