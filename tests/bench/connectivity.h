// Which corners of a triangle mesh face each other. Corner c is corner c % 3 of triangle c / 3; its edge leads from its
// vertex to that of next_corner(c).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::bench {

inline constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

inline std::uint32_t next_corner(std::uint32_t corner) {
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}
inline std::uint32_t vertex_of(const std::vector<mesh::Triangle>& triangles, std::uint32_t corner) {
    return triangles[corner / 3][corner % 3];
}

// For every corner the one whose edge is the same in the other direction; `none` on an open boundary.
// pre: no directed edge belongs to two triangles
std::vector<std::uint32_t> opposite_corners(const std::vector<mesh::Triangle>& triangles);

struct Repairs {
    std::uint64_t dropped_triangles = 0;  // an edge of theirs was taken already in that direction
    std::uint64_t split_vertices = 0;     // copies made so that every vertex has a single fan of triangles
};

// What every method here accepts: positions and triangles alone, equal positions welded, then oriented and manifold.
mesh::Mesh make_manifold(const mesh::Mesh& mesh, Repairs& repairs);

// Edges between positions that one triangle alone has: where a surface is open, or torn. As pairs of vertices.
std::vector<std::array<std::uint32_t, 2>> open_edges(const mesh::Mesh& mesh);

}  // namespace lodestream::bench
