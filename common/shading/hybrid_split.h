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

// Picks `gouraud` triangles that follow `order` but stay together: the mesh is grown into at most `regions` connected
// regions, taken by the mean rank of their triangles; the last one taken is filled from its seed so that the count is exact.
// 1 in the result: Gouraud. regions = 0: no coherence, the first `gouraud` of the order exactly (the paper's own split).
std::vector<std::uint8_t> coherent_split(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& order,
                                         std::uint64_t gouraud, std::uint32_t regions);

}  // namespace lodestream::shading
