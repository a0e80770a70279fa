// Hybrid shading: which triangles of a level are Gouraud shaded and which flat.
// Source: hybrid-rendering paper §2.2 (seeds-digest §1): distance sets how many, vertex intensity and perimeter which.
#pragma once

#include <cstdint>
#include <vector>

#include "common/budget/budget.h"
#include "common/mesh/mesh.h"
#include "common/shading/view.h"

namespace lodestream::shading {

// One light, Phong's model, summed over R, G and B.
struct Phong {
    double ambient = 0.25;
    double diffuse = 0.75;
    double specular = 0.25;
    double shininess = 16.0;
};

// Intensities below this difference, of a sum over R, G and B in [0, 3], are "barely different": one 8-bit step each.
inline constexpr double barely_different = 3.0 / 255.0;

// The most Gouraud triangles at distance d: round((1-d) * n).
std::uint64_t gouraud_count(std::uint64_t triangles, double d);

// The paper's order: triangles that deserve Gouraud shading first. Those whose vertex intensities differ by more than
// barely_different come before the rest, by falling perimeter; the rest by falling perimeter too. Ties: lower index.
// `mesh` must have normals. Any input gives a permutation of 0 … n-1; non-finite intermediate values count as zero.
std::vector<std::uint32_t> paper_order(const mesh::Mesh& mesh, const std::vector<mesh::Material>& materials,
                                       const View& view, const Vec3d& origin, const Phong& phong = {});

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
