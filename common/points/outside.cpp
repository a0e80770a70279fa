#include "common/points/outside.h"

#include <algorithm>

namespace lodestream::points {

Outside::Outside(std::span<const Vec3f> surface, const Vec3d& extent, double spacing) {
    constexpr double spacings_per_cell = 2.0;  // so that a surface leaves no gap between its cells
    const double longest = std::max({extent.x, extent.y, extent.z});
    cell_size_ = std::max(longest / cells_along_extent, spacings_per_cell * spacing);
    for (int axis = 0; axis < 3; ++axis)
        size_[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(extent[axis] / cell_size_) + 3;
    cells_.assign(std::size_t{size_[0]} * size_[1] * size_[2], Cell::empty);
    for (const Vec3f& p : surface) cells_[index(cell_of(p))] = Cell::surface;
    flood();
}

std::array<std::uint32_t, 3> Outside::cell_of(const Vec3f& point) const {
    std::array<std::uint32_t, 3> cell{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(axis);
        const double place = std::clamp(point[axis] / cell_size_, 0.0, static_cast<double>(size_[k] - 3));
        cell[k] = static_cast<std::uint32_t>(place) + 1;
    }
    return cell;
}

std::size_t Outside::index(const std::array<std::uint32_t, 3>& cell) const {
    return (std::size_t{cell[2]} * size_[1] + cell[1]) * size_[0] + cell[0];
}

void Outside::flood() {
    std::vector<std::array<std::uint32_t, 3>> open{{0, 0, 0}};
    cells_[0] = Cell::outside;
    while (!open.empty()) {
        const std::array<std::uint32_t, 3> cell = open.back();
        open.pop_back();
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const int step : {-1, 1}) {
                auto next = cell;
                next[axis] += static_cast<std::uint32_t>(step);  // below zero it wraps to more than any size
                if (next[axis] >= size_[axis] || cells_[index(next)] != Cell::empty) continue;
                cells_[index(next)] = Cell::outside;
                open.push_back(next);
            }
    }
}

bool Outside::reaches(const Vec3f& point) const {
    const std::array<std::uint32_t, 3> cell = cell_of(point);
    for (std::uint32_t z = cell[2] - 1; z <= cell[2] + 1; ++z)
        for (std::uint32_t y = cell[1] - 1; y <= cell[1] + 1; ++y)
            for (std::uint32_t x = cell[0] - 1; x <= cell[0] + 1; ++x)
                if (cells_[index({x, y, z})] == Cell::outside) return true;
    return false;
}

}  // namespace lodestream::points
