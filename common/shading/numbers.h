// Numbers that may come from broken meshes, made safe.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::shading {

inline double finite_or_zero(double x) {
    return std::isfinite(x) ? x : 0.0;
}

// Without overflow on the way.
inline Vec3d unit_or_zero(const Vec3d& v) {
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (!std::isfinite(largest) || largest == 0.0) return Vec3d(0.0);
    return glm::normalize(v / largest);
}

// White where the material is missing.
inline Vec3d base_color(const std::vector<mesh::Material>& materials, std::uint32_t material) {
    return material < materials.size() ? Vec3d(materials[material].base_color) : Vec3d(1.0);
}

}  // namespace lodestream::shading
