// A tree of boxes over triangles, for nearest-point queries. Four children a node, whose boxes are measured at once
// (Dammertz, Hanika, Keller 2008, "Shallow bounding volume hierarchies for fast SIMD ray tracing of incoherent rays").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/math.h"
#include "common/mesh/mesh.h"

namespace lodestream::metric {

// Distances are computed in double on the mesh's own coordinates: even the fourth powers of the largest and smallest
// float lengths are well inside its range. Boxes are compared in float, never to the loss of a nearer triangle but
// where both are nearer than 1e-18 of the mesh's largest coordinate.
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

    struct Crossing {
        double distance;         // in lengths of the direction
        std::uint32_t triangle;  // as in Hit
        Vec3d weights;           // of its corners there
    };
    // The first triangle of those that the ray meets at distances in [from, to). What lies in its own plane it does not
    // meet. pre: the origin is no more than some sizes of the mesh away; the direction is a unit vector
    Crossing first_along(const Vec3d& origin, const Vec3d& direction, double from, double to) const;

    // Squared distance to the nearest triangle, or `bound` (squared) if none is nearer.
    double squared_distance(const Vec3d& point, double bound) const { return nearest(point, bound).squared_distance; }

    // The triangles in the order of the tree: neighbours in space are near in the list.
    const std::vector<Corners>& triangles() const { return triangles_; }
    // Which triangle of the mesh each of them is.
    const std::vector<std::uint32_t>& order() const { return order_; }

  private:
    struct FloatBox {
        Vec3f min, max;

        void add(const FloatBox& other);
        double area() const;  // half of its surface's
    };
    // Items and the box around them; without items the box says nothing.
    struct Side {
        FloatBox box{};
        std::uint32_t count = 0;

        void add(const Side& other);
        double cost() const { return count > 0 ? count * box.area() : 0.0; }
    };
    struct Item {
        FloatBox box;
        Vec3f center;
        std::uint32_t triangle;
    };
    // A run of items.
    struct Range {
        std::uint32_t first, count;
    };
    static constexpr std::size_t width = 4;
    // One float of each child of a node, reckoned with at once.
    using Lanes = float __attribute__((vector_size(width * sizeof(float))));
    // Boxes are scaled. A child of no triangles is a node, `first` its index; the root stands for none.
    struct Node {
        std::array<Lanes, 3> min, max;
        std::array<Range, width> children;
    };
    // A point and lengths as the boxes have them.
    struct Query;

    void build(std::vector<Item>& items);
    static std::uint32_t split(std::span<Item> items);
    static FloatBox box_of(std::span<const Item> items);
    void set_box(Node& node, std::size_t child, const FloatBox& box) const;
    static Lanes squared_distances(const Node& node, const Query& query);
    // A ray as the boxes have it.
    struct Ray;
    static Lanes entries(const Node& node, const Ray& ray, float to);

    std::vector<Node> nodes_;
    // A power of two that brings the largest coordinate near one: lengths that floats cannot square, however large or
    // small the mesh is, are then below anything that matters.
    double scale_ = 1.0;
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
