// A scene's colours put on a surface that stands for it: an image over an atlas of the surface (scene/atlas.h).
#pragma once

#include <cstdint>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/metric/triangle_tree.h"
#include "server/bake/surface_colors.h"

namespace lodestream::bake {

// Of a painted surface's image, on average. With 16, 24 and 32 the ship's 1,920 triangles are 36.9, 36.1 and 36.0 off
// in lodestream_bench_hlod and take 40, 44 and 50 kB.
inline constexpr std::uint64_t texels_per_triangle = 24;

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

  private:
    mesh::Mesh seen_;
    SurfaceColors colors_;
    metric::TriangleTree tree_;
};

}  // namespace lodestream::bake
