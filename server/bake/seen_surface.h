// What of a scene, or of a part of it, is seen from outside, as the surfaces that its coarse levels may be cut from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"

namespace lodestream::bake {

// A bare one has positions alone: the rest comes from the scene once a level of it is made (scene_colors.h).
struct Surface {
    mesh::Mesh mesh;
    bool is_bare = false;
};

mesh::Mesh bare(const mesh::Mesh& mesh);

// Sharper edges of coarse levels are hard where their normals are made anew.
inline constexpr double level_crease_degrees = 40.0;
// A normal of theirs that is farther off its triangle's is a mean over pieces that a merge has joined.
inline constexpr double max_normal_degrees = 60.0;

// The level with other normals instead of those; one without normals as it is.
mesh::Mesh with_plausible_normals(mesh::Mesh level);

// Whether an image shows all that these materials do: all are opaque and none glows.
bool can_be_painted(const std::vector<mesh::Material>& materials);

// How many samples (metric/surface_distance.h) serve a mesh of small triangles of about one size.
std::size_t samples_of(const mesh::Mesh& mesh);

struct SeenSurface {
    // The triangles that can be seen from outside; behind it, if allowed, the closed surface wrapped around them
    // (scene/surroundings.h), bare.
    std::vector<Surface> surfaces;
    std::vector<std::uint32_t> triangles;  // the first one's, of what was looked at
    metric::SurfaceIndex original;         // of the first one, with samples only where it is seen
};
// `triangles`: of the finest level wanted, from which follows how fine the surface wrapped around is. pre: `whole` has
// triangles
SeenSurface seen_from_outside(const Surface& whole, std::uint64_t triangles, bool may_wrap);

}  // namespace lodestream::bake
