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

    // Squared distance to the nearest triangle, or `bound` (squared) if none is nearer.
    double squared_distance(const Vec3d& point, double bound) const;

    // The triangles in the order of the tree: neighbours in space are near in the list.
    const std::vector<Corners>& triangles() const { return triangles_; }

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
};

// Squared distance from a point to a triangle, to its sides where it has no area.
double squared_distance(const TriangleTree::Corners& triangle, const Vec3d& point);

}  // namespace lodestream::metric
