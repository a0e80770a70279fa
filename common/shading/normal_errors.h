// What flat and what Gouraud shading show of a level, measured: their normals beside those of a finer surface.
#pragma once

#include <vector>

#include "common/mesh/mesh.h"
#include "common/metric/triangle_tree.h"

namespace lodestream::shading {

// A surface that levels are compared with: the full model, or a level of several times the triangles. Immutable; may be
// asked from any thread.
class ReferenceSurface {
  public:
    explicit ReferenceSurface(mesh::Mesh mesh);

    // The unit normal at the place nearest to a finite point: of the corners' normals, of the triangle where they have
    // none. (0,0,0) where that has none either, and without triangles.
    Vec3d normal_near(const Vec3d& point) const;

  private:
    mesh::Mesh mesh_;
    metric::TriangleTree tree_;
};

// One a triangle of a level: the mean over it of the squared difference between the shown unit normal and the
// reference's. Both 0 where nothing can be said: places that face apart are two sides of a thin part, and triangles
// without an area show nothing.
struct NormalErrors {
    std::vector<double> flat;     // in [0, 2]
    std::vector<double> gouraud;  // in [0, 4]; as flat where a corner has no normal
};

// Four places a triangle, each about 1 µs. Finite for any input.
NormalErrors normal_errors(const mesh::Mesh& level, const ReferenceSurface& reference);

}  // namespace lodestream::shading
