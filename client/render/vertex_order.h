// Triangle order for the GPU's caches, by meshoptimizer; private to this folder.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::render {

// Rearranges triangles among themselves so that neighbours follow each other: for each place, which of `triangles`
// stands there. A permutation; O(n log n).
std::vector<std::uint32_t> cache_order(std::span<const mesh::Triangle> triangles);

// Vertices that a cache of 16 entries, as small as is found, transforms for each triangle: 0.5 at best, 3 at worst.
double transforms_per_triangle(const mesh::Mesh& mesh);

}  // namespace lodestream::render
