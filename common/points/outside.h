// Private to the folder: which places of a surface a way from outside leads to.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/math.h"

namespace lodestream::points {

class Outside {
  public:
    static constexpr double cells_along_extent = 128.0;

    // `surface`: points with coordinates in [0, extent[axis]], at most `spacing` apart where they are one surface.
    Outside(std::span<const Vec3f> surface, const Vec3d& extent, double spacing);

    // Whether a cell at or beside this point of the surface is empty and joined to the space around.
    bool reaches(const Vec3f& point) const;

  private:
    enum class Cell : std::uint8_t { empty, surface, outside };

    std::array<std::uint32_t, 3> cell_of(const Vec3f& point) const;
    std::size_t index(const std::array<std::uint32_t, 3>& cell) const;
    void flood();

    double cell_size_ = 1.0;
    std::array<std::uint32_t, 3> size_{};  // with one layer of empty cells all around
    std::vector<Cell> cells_;
};

}  // namespace lodestream::points
