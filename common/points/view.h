// Private to the folder: one axis' view of the mesh, in pixels.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/math.h"
#include "common/base/raster.h"
#include "common/points/resample.h"

namespace lodestream::points {

// What a pixel shows of a triangle. In `triangle` the highest bit is set where it fell between all pixel centres and is
// drawn as a point at its centre.
struct Hit {
    std::uint32_t pixel = 0;  // y * width + x
    float depth = 0.0f;       // px
    std::uint32_t triangle = 0;
};
inline constexpr std::uint32_t drawn_as_point = 1u << 31;

// A view along `axis` sees the two others as x and y.
inline constexpr std::array<std::array<int, 3>, 3> view_axes{{{1, 2, 0}, {2, 0, 1}, {0, 1, 2}}};  // x, y, depth

// Weights of the corners at a point of the view's plane, each in [0, 1], summing to 1. False: seen edge-on.
bool weights_at(const std::array<Vec3d, 3>& corners, double x, double y, Vec3d& weights);

// A point that a view gives.
struct Sample {
    Hit hit;
    bool is_outermost = false;  // first or last of its pixel: seen from outside
    bool fills_a_hole = false;  // lies at the pixel and depth, beside the triangle
};

// The hits that some slice shows to one of the two directions, and the holes that the filter closes; in the order of
// pixels and depths.
std::vector<Sample> sampled(std::vector<Hit> hits, const ViewSize& size, HoleFilter filter);

}  // namespace lodestream::points
