// Hybrid shading: from an order of merit (paper_criterion.h, importance.h) to the triangles that are Gouraud shaded.
// Source: hybrid-rendering paper §2.2 (seeds-digest §1): distance sets how many, the criterion which.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::shading {

// The most Gouraud triangles at distance d: round((1-d) * n).
std::uint64_t gouraud_count(std::uint64_t triangles, double d);

// Picks `gouraud` triangles that follow `order` but stay together: the mesh is grown into about `regions` connected
// regions (a connected piece of the mesh smaller than a region stays whole), taken by the mean rank of their triangles
// less a credit for the border that they share with regions already taken. The last one is cut along a plane so that
// the count is exact, and the border is smoothed. O(n log n). 1 in the result: Gouraud. regions = 0: no coherence, the
// first `gouraud` of the order exactly (the paper's own split). pre: `order` is a permutation of the triangles.
std::vector<std::uint8_t> coherent_split(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& order,
                                         std::uint64_t gouraud, std::uint32_t regions);

// Region counts worth trying on a mesh of `triangles`, from the closest to the paper's order to the shortest border: of
// 256, 64, 16, 4, 1 those whose regions hold min_region_triangles or more. Smaller ones are all border, which costs
// more bytes than the normals that it saves.
inline constexpr std::uint64_t min_region_triangles = 64;
std::vector<std::uint32_t> region_counts_to_try(std::uint64_t triangles);

}  // namespace lodestream::shading
