// Points on a surface, each with what it needs to be drawn as a small disc.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/math.h"

namespace lodestream::points {

inline constexpr std::uint64_t max_points = 1u << 24;  // of one cloud

// Every attribute vector is either empty (the cloud does not have it) or as long as `positions`.
struct PointCloud {
    std::vector<Vec3f> positions;  // model units, relative to the model's origin; finite
    std::vector<Vec3f> normals;    // unit length
    std::vector<Rgba8> colors;     // linear RGBA
};

// The points before `count`, or all where there are fewer.
PointCloud prefix(const PointCloud& cloud, std::uint64_t count);

}  // namespace lodestream::points
