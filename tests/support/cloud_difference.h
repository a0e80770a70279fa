// How much of two clouds, resampled from one mesh with the same parameters, is not in both.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <tuple>

#include "common/mesh/operations.h"
#include "common/points/resample.h"

namespace lodestream::testing {

// Points by their positions in steps of a 64th of a pixel. Where faces lie on each other, several.
using Place = std::tuple<long, long, long>;
inline std::multimap<Place, std::size_t> places_of(const points::PointCloud& cloud, double px_per_unit) {
    std::multimap<Place, std::size_t> places;
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
        const Vec3d at = 64.0 * px_per_unit * Vec3d(cloud.positions[i]);
        places.emplace(Place{std::lround(at.x), std::lround(at.y), std::lround(at.z)}, i);
    }
    return places;
}

inline bool alike(const points::PointCloud& a, std::size_t i, const points::PointCloud& b, std::size_t j) {
    if (!(std::abs(dot(a.normals[i], b.normals[j])) > 0.999f)) return false;
    if (a.colors.empty()) return true;
    const Vec4f difference = abs(Vec4f(a.colors[i]) - Vec4f(b.colors[j]));  // the weights' rounding
    return std::max({difference.r, difference.g, difference.b, difference.a}) <= 1.0f;
}

inline std::size_t alone(const points::PointCloud& a, const std::multimap<Place, std::size_t>& in_a,
                         const points::PointCloud& b, const std::multimap<Place, std::size_t>& in_b) {
    std::size_t count = 0;
    for (const auto& [place, i] : in_a) {
        const auto [first, last] = in_b.equal_range(place);
        count +=
            std::any_of(first, last, [&, i = i](const auto& other) { return alike(a, i, b, other.second); }) ? 0 : 1;
    }
    return count;
}

// The share of both clouds' points that the other one does not have, with its normal and colour.
inline double differing_share(const mesh::Mesh& mesh, const points::Parameters& parameters, const points::PointCloud& a,
                              const points::PointCloud& b) {
    const Vec3d extent = mesh::bounds(mesh).extent();
    const double px_per_unit = parameters.side / std::max({extent.x, extent.y, extent.z});
    const auto in_a = places_of(a, px_per_unit), in_b = places_of(b, px_per_unit);
    return static_cast<double>(alone(a, in_a, b, in_b) + alone(b, in_b, a, in_a)) /
           static_cast<double>(std::max<std::size_t>(in_a.size() + in_b.size(), 1));
}

}  // namespace lodestream::testing
