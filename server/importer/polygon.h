// Cuts a polygon in space into triangles by ear clipping.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::importer {

// Appends corners.size() - 2 triangles, as indices into `corners`, that keep the polygon's direction. Concave polygons
// are cut inside their outline as seen along their average normal; self-crossing ones get some triangulation.
// Counts the corner tests made into `work` and falls back to a fan when that passes `max_work` (hostile outlines take
// cubic time). pre: at least three corners
void triangulate(std::span<const Vec3d> corners, std::vector<mesh::Triangle>& out, std::uint64_t& work,
                 std::uint64_t max_work);

}  // namespace lodestream::importer
