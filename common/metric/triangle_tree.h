// A tree of boxes over triangles, for nearest-point queries.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/math.h"
#include "common/mesh/mesh.h"

namespace lodestream::metric {

// Distances are computed in double on the mesh's own coordinates: even the fourth powers of the largest and smallest
// float lengths are well inside its range.
class TriangleTree {
  public:
    using Corners = std::array<Vec3f, 3>;

    explicit TriangleTree(const mesh::Mesh& mesh);

    struct Hit {
        double squared_distance;
        std::uint32_t triangle;  // of triangles(); no_triangle: none is nearer than the bound
    };
    static constexpr std::uint32_t no_triangle = 0xffffffffu;
    // The nearest triangle, if it is nearer than `bound` (squared).
    Hit nearest(const Vec3d& point, double bound) const;

    // Squared distance to the nearest triangle, or `bound` (squared) if none is nearer.
    double squared_distance(const Vec3d& point, double bound) const { return nearest(point, bound).squared_distance; }

    // The triangles in the order of the tree: neighbours in space are near in the list.
    const std::vector<Corners>& triangles() const { return triangles_; }
    // Which triangle of the mesh each of them is.
    const std::vector<std::uint32_t>& order() const { return order_; }

  private:
    struct FloatBox {
        Vec3f min, max;
    };
    // Inner node: two children. Leaf: triangles [first, first + count).
    struct Node {
        FloatBox box;
        std::uint32_t first;  // the left child (the right one follows it) or the first triangle
        std::uint32_t count;  // 0: inner
    };
    struct Item {
        FloatBox box;
        Vec3f center;
        std::uint32_t triangle;
    };

    void build(std::vector<Item>& items);
    static double squared_distance(const FloatBox& box, const Vec3d& point);

    std::vector<Node> nodes_;
    std::vector<Corners> triangles_;
    std::vector<std::uint32_t> order_;
};

// A place of a mesh's surface.
struct SurfacePlace {
    mesh::Triangle triangle{};
    Vec3d weights{1.0, 0.0, 0.0};  // of its corners, in [0, 1], of sum 1
};

// The place of `mesh` nearest to a finite point. pre: `tree` was built from `mesh`, which has triangles
SurfacePlace nearest_place(const TriangleTree& tree, const mesh::Mesh& mesh, const Vec3d& point);

// Squared distance from a point to a triangle, to its sides where it has no area.
double squared_distance(const TriangleTree::Corners& triangle, const Vec3d& point);

}  // namespace lodestream::metric
