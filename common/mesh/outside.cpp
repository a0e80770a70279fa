#include "common/mesh/outside.h"

#include <algorithm>

namespace lodestream::mesh {

Outside::Outside(const Vec3d& extent, double cell_size) : cell_size_(cell_size) {
    for (int axis = 0; axis < 3; ++axis)
        size_[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(extent[axis] / cell_size_) + 3;
    cells_.assign(std::size_t{size_[0]} * size_[1] * size_[2], State::empty);
}

Outside::Cell Outside::cell_of(const Vec3d& point) const {
    Cell cell{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(axis);
        const double place = std::clamp(point[axis] / cell_size_, 0.0, static_cast<double>(size_[k] - 3));
        cell[k] = static_cast<std::uint32_t>(place) + 1;
    }
    return cell;
}

void Outside::flood() {
    std::vector<Cell> open{{0, 0, 0}};
    cells_[0] = State::outside;
    while (!open.empty()) {
        const Cell cell = open.back();
        open.pop_back();
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const int step : {-1, 1}) {
                Cell next = cell;
                next[axis] += static_cast<std::uint32_t>(step);  // below zero it wraps to more than any size
                if (next[axis] >= size_[axis] || cells_[index(next)] != State::empty) continue;
                cells_[index(next)] = State::outside;
                open.push_back(next);
            }
    }
}

bool Outside::reaches(const Cell& cell) const {
    for (std::uint32_t z = cell[2] - 1; z <= cell[2] + 1; ++z)
        for (std::uint32_t y = cell[1] - 1; y <= cell[1] + 1; ++y)
            for (std::uint32_t x = cell[0] - 1; x <= cell[0] + 1; ++x)
                if (is_outside({x, y, z})) return true;
    return false;
}

}  // namespace lodestream::mesh
