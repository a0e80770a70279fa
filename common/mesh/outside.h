// Which places of a surface a way from outside leads to, on a grid of cells.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/math.h"

namespace lodestream::mesh {

class Outside {
  public:
    using Cell = std::array<std::uint32_t, 3>;

    // For points with coordinates in [0, extent[axis]]. A layer of cells that are outside lies all around.
    // pre: cell_size > 0, few enough cells for the memory
    Outside(const Vec3d& extent, double cell_size);

    // 1. A point of the surface. Two marked points are joined where they are at most half a cell apart.
    void mark(const Vec3d& point) { mark(cell_of(point)); }
    void mark(const Cell& cell) { cells_[index(cell)] = State::surface; }
    // 2. Finds what is outside: all cells that are joined to the layer around by cells without a mark.
    void flood();

    // Whether a cell at or beside this point is outside.
    bool reaches(const Vec3d& point) const { return reaches(cell_of(point)); }
    bool reaches(const Cell& cell) const;
    bool is_outside(const Cell& cell) const { return cells_[index(cell)] == State::outside; }
    // Between two points of one cell all are of that cell.
    Cell cell_of(const Vec3d& point) const;
    // Cells along each axis, the layer around included: cell k spans [k - 1, k] times the cell's size.
    const Cell& size() const { return size_; }

  private:
    enum class State : std::uint8_t { empty, surface, outside };

    std::size_t index(const Cell& cell) const {
        return (std::size_t{cell[2]} * size_[1] + cell[1]) * size_[0] + cell[0];
    }

    double cell_size_;
    Cell size_{};
    std::vector<State> cells_;
};

}  // namespace lodestream::mesh
