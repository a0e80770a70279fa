// Private to the folder: one axis' view of the mesh, in pixels.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "common/base/math.h"
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

// The pixels of [0, size) whose centres lie in a stretch: from `first` to before `last`.
struct PixelRange {
    std::uint32_t first = 0, last = 0;
};
PixelRange pixels_between(double low, double high, std::uint32_t size);
// Of the row whose centre line is at y: where the triangle covers it, its edge included.
PixelRange pixels_of_row(const std::array<Vec3d, 3>& corners, double y, std::uint32_t width);

// Calls emit(x, y) for every pixel whose centre (x + 0.5, y + 0.5) lies in the triangle or on its edge.
template <class Emit>
void for_each_pixel(const std::array<Vec3d, 3>& corners, std::uint32_t width, std::uint32_t height, const Emit& emit) {
    const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    const PixelRange rows = pixels_between(low, high, height);
    for (std::uint32_t y = rows.first; y < rows.last; ++y) {
        const PixelRange row = pixels_of_row(corners, y + 0.5, width);
        for (std::uint32_t x = row.first; x < row.last; ++x) emit(x, y);
    }
}

// Weights of the corners at a point of the view's plane, each in [0, 1], summing to 1. False: seen edge-on.
bool weights_at(const std::array<Vec3d, 3>& corners, double x, double y, Vec3d& weights);

// A point that a view gives.
struct Sample {
    Hit hit;
    bool is_outermost = false;  // first or last of its pixel: seen from outside
    bool fills_a_hole = false;  // lies at the pixel and depth, beside the triangle
};

struct ViewSize {
    std::uint32_t width = 1, height = 1;  // px
    double slice_px = 1.0;                // thickness of a slice
    std::uint32_t slices = 1;             // along the longest side
};

// The hits that some slice shows to one of the two directions, and the holes that the filter closes; in the order of
// pixels and depths.
std::vector<Sample> sampled(std::vector<Hit> hits, const ViewSize& size, HoleFilter filter);

}  // namespace lodestream::points
