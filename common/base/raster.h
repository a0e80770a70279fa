// Which pixels a triangle covers: those whose centres (x + 0.5, y + 0.5) lie in it or on its edge.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/base/math.h"

namespace lodestream {

// From `first` to before `last`.
struct PixelRange {
    std::uint32_t first = 0, last = 0;
    bool empty() const { return first == last; }
};

// The pixels of [0, size) whose centres lie in a stretch. None where it is NaN or turned around.
inline PixelRange pixels_between(double low, double high, std::uint32_t size) {
    const double first = std::ceil(low - 0.5), last = std::floor(high - 0.5) + 1.0;
    const auto bounded = [&](double x) {
        return static_cast<std::uint32_t>(std::clamp(x, 0.0, static_cast<double>(size)));
    };
    return last > first ? PixelRange{bounded(first), bounded(last)} : PixelRange{};
}

// Of the row whose centre line is at y: where the triangle covers it. Corners: x and y in pixels, the third is not
// read.
inline PixelRange pixels_of_row(const std::array<Vec3d, 3>& corners, double y, std::uint32_t width) {
    double left = std::numeric_limits<double>::infinity(), right = -left;
    const auto add = [&](double x) {
        left = std::min(left, x);
        right = std::max(right, x);
    };
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d &a = corners[k], &b = corners[(k + 1) % 3];
        if (std::min(a.y, b.y) > y || std::max(a.y, b.y) < y) continue;
        if (a.y == b.y) {
            add(a.x);
            add(b.x);
        } else {
            add(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
        }
    }
    return pixels_between(left, right, width);
}

// Calls emit(x, y) for every pixel of width x height that the triangle covers.
template <class Emit>
void for_each_pixel(const std::array<Vec3d, 3>& corners, std::uint32_t width, std::uint32_t height, const Emit& emit) {
    const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    const PixelRange rows = pixels_between(low, high, height);
    for (std::uint32_t y = rows.first; y < rows.last; ++y) {
        const PixelRange row = pixels_of_row(corners, y + 0.5, width);
        for (std::uint32_t x = row.first; x < row.last; ++x) emit(x, y);
    }
}

}  // namespace lodestream
