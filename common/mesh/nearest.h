// The place of a triangle that is nearest to a point.
#pragma once

#include <algorithm>

#include "common/base/math.h"

namespace lodestream::mesh {

// The weights of the corners, each in [0,1], of sum 1 (Ericson, Real-Time Collision Detection, 5.1.5); of a triangle
// without area one corner or a place on a side. Finite for finite corners.
inline Vec3d nearest_weights(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
                 d6 = dot(ac, cp);
    const auto share = [](double part, double rest) {
        return part + rest > 0 ? std::clamp(part / (part + rest), 0.0, 1.0) : 0.0;
    };
    if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
    if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
    if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
    const double of_c = d1 * d4 - d3 * d2, of_b = d5 * d2 - d1 * d6, of_a = d3 * d6 - d5 * d4;
    if (of_c <= 0 && d1 >= 0 && d3 <= 0) {
        const double t = share(d1, -d3);
        return {1 - t, t, 0};
    }
    if (of_b <= 0 && d2 >= 0 && d6 <= 0) {
        const double t = share(d2, -d6);
        return {1 - t, 0, t};
    }
    if (of_a <= 0 && d4 >= d3 && d5 >= d6) {
        const double t = share(d4 - d3, d5 - d6);
        return {0, 1 - t, t};
    }
    const double sum = of_a + of_b + of_c;
    if (!(sum > 0)) return {1, 0, 0};
    return {of_a / sum, of_b / sum, of_c / sum};
}

}  // namespace lodestream::mesh
