// Vectors, matrices and boxes: glm under this project's names. Free functions (dot, cross, length, normalize, …) are
// found by argument-dependent lookup, so no other header names glm.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>

namespace lodestream {

using Vec2f = glm::vec2;
using Vec3f = glm::vec3;
using Vec4f = glm::vec4;
using Vec3d = glm::dvec3;
using Vec4d = glm::dvec4;
using Mat3d = glm::dmat3;
using Mat4d = glm::dmat4;
using Mat3f = glm::mat3;
using Mat4f = glm::mat4;
using Rgba8 = glm::u8vec4;

inline constexpr double pi = 3.14159265358979323846;

inline double radians(double degrees) {
    return degrees * pi / 180.0;
}

inline bool all_finite(const Vec3f& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool all_finite(const Vec3d& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// An axis-aligned box; empty when it holds no point.
struct Box {
    Vec3d min{std::numeric_limits<double>::infinity()};
    Vec3d max{-std::numeric_limits<double>::infinity()};

    bool empty() const { return !(min.x <= max.x); }
    void add(const Vec3d& p) {
        min = glm::min(min, p);
        max = glm::max(max, p);
    }
    Vec3d center() const { return empty() ? Vec3d{0} : min + (max - min) * 0.5; }
    Vec3d extent() const { return empty() ? Vec3d{0} : max - min; }
    double diagonal() const { return glm::length(extent()); }
    double radius() const { return 0.5 * diagonal(); }  // of the sphere through the corners
};

}  // namespace lodestream
