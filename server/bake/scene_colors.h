// A scene's colours put on a surface that stands for it: an image over an atlas of the surface (scene/atlas.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/metric/triangle_tree.h"
#include "common/scene/atlas.h"
#include "server/bake/surface_colors.h"

namespace lodestream::bake {

// Of a painted surface's image, on average. With 16, 24 and 32 the ship's 1,920 triangles are 36.9, 36.1 and 36.0 off
// in lodestream_bench_hlod and take 40, 44 and 50 kB.
inline constexpr std::uint64_t texels_per_triangle = 24;
// Likewise where texels show what is seen from around. With 24, 48 and 64 the ship's tile of 1,920 triangles
// is 34.3, 33.3 and 33.0 off and takes 49, 65 and 76 kB.
inline constexpr std::uint64_t seen_texels_per_triangle = 48;
// Above, a surface is so close to the scene that both ways show nearly the same.
inline constexpr std::size_t max_seen_triangles = 2'048;

inline constexpr const char* painted_name = "painted";  // of a painted surface's material

class SceneColors {
  public:
    // `model`: its materials and images, which must outlive this; `seen`: what of its mesh is seen from outside.
    SceneColors(const mesh::Model& model, mesh::Mesh seen);
    SceneColors(const SceneColors&) = delete;  // its parts name each other
    SceneColors& operator=(const SceneColors&) = delete;

    // The surface as a model of one material: an image, or one colour where the scene has but one. A texel shows the
    // places of the scene that are nearest to its own. Normals are new (level_crease_degrees). pre: `surface` has
    // triangles. Errors: those of the image's encoder.
    Result<mesh::Model> paint(const mesh::Mesh& surface) const;
    // Likewise, but a texel shows what is seen of the scene in its place: of the colours met from those directions
    // around it from which the surface does not hide it, the one nearest to their mean. It takes about six microseconds
    // a texel more. Surfaces of more than max_seen_triangles are painted as above.
    Result<mesh::Model> paint_as_seen(const mesh::Mesh& surface) const;

  private:
    using Texels = std::vector<std::optional<Rgba8>>;  // as scene::Atlas has them; without a colour where is nothing

    Texels nearest_colors(const scene::Atlas& atlas) const;
    void take_seen_colors(const scene::Atlas& atlas, Texels& texels) const;
    template <class Colors>
    Result<mesh::Model> paint(const mesh::Mesh& surface, std::uint64_t texels_a_triangle, Colors colors) const;

    mesh::Mesh seen_;
    SurfaceColors colors_;
    metric::TriangleTree tree_;
};

}  // namespace lodestream::bake
