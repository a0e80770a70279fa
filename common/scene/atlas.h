// Room in one image for a whole surface: charts of it lie side by side, so that what is painted on it is as fine as the
// image's texels, not as its triangles.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::scene {

inline constexpr std::uint32_t max_atlas_side = 2'048;  // texels; of a chart, and about that of the image

// A place of the surface that is shown in a texel's middle.
struct Texel {
    static constexpr std::uint32_t nothing = std::numeric_limits<std::uint32_t>::max();
    std::uint32_t triangle = nothing;
    Vec3f weights{1.0f, 0.0f, 0.0f};  // of its corners
};

struct Atlas {
    // The surface's triangles in their order; texture coordinates in [0, 1], vertices that are in several charts once
    // in each. No colours or materials.
    mesh::Mesh mesh;
    std::uint32_t width = 0, height = 0;  // texels, >= 1
    std::vector<Texel> texels;            // width * height, the upper row first; every chart has some
};

// Lays out a surface in about so many texels, all of one size. A chart shows what faces along one axis (most of it so
// that a texel covers at most 1.73 times its own area) and does not lie over itself: a picture of all of that side, or
// a connected part. Around it lies a texel of nothing.
// pre: `surface` has triangles; texels > 0
Atlas unfold(const mesh::Mesh& surface, std::uint64_t texels);

}  // namespace lodestream::scene
