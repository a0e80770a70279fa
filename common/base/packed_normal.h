// Unit vectors in four bytes: octahedral coordinates (Meyer et al. 2010) of 16 bits each. The direction is kept to
// 0.004 degrees.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/base/math.h"

namespace lodestream {

// `v`: of any length; (0, 0, 0) and what is not finite become +y.
inline std::uint32_t pack_normal(const Vec3f& v) {
    const double x = v.x, y = v.y, z = v.z, sum = std::abs(x) + std::abs(y) + std::abs(z);
    double u = 0.0, w = 1.0;
    if (sum > 0 && std::isfinite(sum)) {
        u = x / sum;
        w = y / sum;
        if (z < 0) {
            const double folded = std::copysign(1 - std::abs(w), u);
            w = std::copysign(1 - std::abs(u), w);
            u = folded;
        }
    }
    const auto steps = [](double t) {
        return static_cast<std::uint32_t>(static_cast<std::uint16_t>(std::lround(std::clamp(t, -1.0, 1.0) * 32767)));
    };
    return steps(u) | steps(w) << 16;
}

inline Vec3f unpack_normal(std::uint32_t packed) {
    const auto coordinate = [](std::uint32_t bits) {
        return std::max(-1.0f, static_cast<float>(static_cast<std::int16_t>(bits & 0xffffu)) / 32767.0f);
    };
    Vec3f n{coordinate(packed), coordinate(packed >> 16), 0.0f};
    n.z = 1 - std::abs(n.x) - std::abs(n.y);
    if (n.z < 0) {
        const float folded = std::copysign(1 - std::abs(n.y), n.x);
        n.y = std::copysign(1 - std::abs(n.x), n.y);
        n.x = folded;
    }
    return n / length(n);
}

}  // namespace lodestream
