// The paper's own criterion, polygon by polygon as it describes it, with Table 3's operations counted where they are
// done. Source: hybrid-rendering paper §2.2 and Table 3 (seeds-digest §1).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.h"
#include "common/shading/operation_counts.h"
#include "common/shading/phong.h"
#include "common/shading/view.h"

namespace lodestream::shading {

// Intensities below this difference, of a sum over R, G and B in [0, 3], are "barely different": one 8-bit step each.
inline constexpr double barely_different = 3.0 / 255.0;

struct PaperCriterion {
    std::vector<std::uint32_t> order;  // triangles, those that deserve Gouraud shading first
    std::uint64_t differing = 0;       // how many of them have corners that are more than barely different
    OperationCounts operations;
};

// Triangles whose corner intensities (ambient + diffuse + specular, over R, G and B, under the view's one light) differ
// by more than barely_different come before the rest, by falling perimeter; the rest by falling perimeter too. Ties:
// lower index. A vertex without a normal is lit by the ambient part alone. Any input gives a permutation of 0 … n-1;
// values that are not finite count as zero. `origin` is where the mesh's (0,0,0) lies in the view's world.
PaperCriterion paper_criterion(const mesh::Mesh& mesh, const std::vector<mesh::Material>& materials, const View& view,
                               const Vec3d& origin, const Phong& phong = {});

// What the two shadings need, as the paper prepares it.
struct PaperNormals {
    std::vector<Vec3f> faces;     // one a triangle, unit length; (0,0,0) without area
    std::vector<Vec3f> vertices;  // one a vertex, average over the Gouraud triangles at it; (0,0,0) at none
    OperationCounts operations;
};

// gouraud[t] != 0: triangle t is Gouraud shaded. Triangles from gouraud.size() on are not shaded at all.
PaperNormals paper_normals(const mesh::Mesh& mesh, std::span<const std::uint8_t> gouraud);

}  // namespace lodestream::shading
