// Private to the codec: which grid point each vertex goes to.
// A vertex may slide along its surface unseen, but not leave it. So of the grid points around it the one is taken that
// is least off the planes of its triangles: at the same error that saves a bit or more of each coordinate.
#pragma once

#include <cstdint>
#include <vector>

#include "common/codec/level_codec.h"

namespace lodestream::codec {

// The whole number of steps from the origin that is nearest, where `range` has 2^bits - 1 of them.
double nearest_step(double value, double origin, double range, int bits);
// Grid coordinates, whole numbers.
Vec3d nearest_grid_point(const Vec3f& position, const QuantizationGrid& grid);

struct Rounded {
    std::vector<Vec3d> points;     // grid coordinates, whole numbers, one a vertex; equal positions have equal ones
    double off_surface_rms = 0.0;  // how far vertices went off their triangles' planes, weighted by area
};

// One surface, to be rounded to any grid.
class SurfaceRounding {
  public:
    // Both must outlive it. pre: finite
    SurfaceRounding(const std::vector<Vec3f>& positions, const std::vector<mesh::Triangle>& triangles);
    ~SurfaceRounding();

    // Each vertex at most one and a half steps away on each axis. To the nearest point, by its position alone, go the
    // vertices beside an edge that not exactly two triangles share (a border, which other content may have too) and
    // those of triangles that would turn around.
    Rounded round(const QuantizationGrid& grid) const;

  private:
    class Planes;

    void hold_borders();
    Vec3d best(std::uint32_t v, const QuantizationGrid& grid) const;
    void undo_folds(const QuantizationGrid& grid, std::vector<Vec3d>& points) const;

    const std::vector<Vec3f>& positions_;
    const std::vector<mesh::Triangle>& triangles_;
    const std::vector<std::uint32_t> first_;  // of each vertex, the first one at its place; the rest is kept of these
    std::vector<Planes> planes_;
    std::vector<std::uint8_t> held_;
};

}  // namespace lodestream::codec
