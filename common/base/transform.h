// A transform from its parts, as glTF 2.0 (3.5.3) puts them together.
#pragma once

#include <cmath>

#include "common/base/math.h"

namespace lodestream {

// Scales, then rotates, then translates. `rotation`: a quaternion (x, y, z, w) of any length; none where that is 0 or
// not finite.
inline Mat4d matrix_of(const Vec3d& translation, Vec4d rotation, const Vec3d& scale) {
    const double size = length(rotation);
    rotation = size > 0 && std::isfinite(size) ? rotation / size : Vec4d{0, 0, 0, 1};
    const double x = rotation.x, y = rotation.y, z = rotation.z, w = rotation.w;
    return {Vec4d{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0} * scale.x,
            Vec4d{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0} * scale.y,
            Vec4d{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0} * scale.z,
            Vec4d{translation, 1}};
}

inline Mat4d translation(const Vec3d& offset) {
    return {Vec4d{1, 0, 0, 0}, Vec4d{0, 1, 0, 0}, Vec4d{0, 0, 1, 0}, Vec4d{offset, 1}};
}

}  // namespace lodestream
