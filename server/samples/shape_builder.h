// Boxes, prisms, lathed shapes, rods, pipes and lofts, gathered into one mesh. Everything faces outwards.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/math.h"
#include "common/mesh/mesh.h"

namespace lodestream::samples {

using Vec2d = glm::dvec2;

// A right-handed orthonormal frame: y up unless a builder is told otherwise.
struct Frame {
    Vec3d origin{0};
    Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

    Vec3d direction(const Vec3d& v) const { return x * v.x + y * v.y + z * v.z; }
    Vec3d point(const Vec3d& v) const { return origin + direction(v); }
};

Frame turned_at(const Vec3d& origin, double yaw);  // about y
Frame along(const Vec3d& from, const Vec3d& to);   // y points from `from` to `to`
Frame moved(const Frame& frame, const Vec3d& local_offset);

class ShapeBuilder {
  public:
    // Rods, pipes and lathed shapes get so many times the sides that they are asked for.
    explicit ShapeBuilder(int roundness = 1) : roundness_(roundness) {}

    void use_material(std::uint32_t material) { material_ = material; }
    void begin_object() { ++objects_; }  // of what is added from now on
    std::uint32_t objects() const { return objects_; }

    // A box with its middle at the frame's origin.
    void box(const Frame& frame, const Vec3d& size);

    // The outline between two chains of points in the frame's xz plane, from y = 0 to `height`. Both chains have as
    // many points, >= 2, and run along +x, `right` at larger z.
    void prism(const Frame& frame, std::span<const Vec2d> left, std::span<const Vec2d> right, double height);

    // A profile of (radius, y) turned about the frame's y axis, upwards on its outside; smooth around, sharp along.
    void lathe(const Frame& frame, std::span<const Vec2d> profile, int sides);

    // A closed cylinder of constant radius.
    void rod(const Vec3d& from, const Vec3d& to, double radius, int sides);

    // A smooth closed tube through the points, mitred at each; no two neighbours equal, no turn back.
    void pipe(std::span<const Vec3d> path, double radius, int sides);

    // A smooth sheet through rows of equally many points; seen from outside, the next row is to the right of the one
    // before and a row runs upwards. Points may coincide.
    void sheet(const std::vector<std::vector<Vec3d>>& rows);

    // A fan between corresponding points of two chains, flat-shaded, seen from the side where `a` runs with `b` to its
    // left.
    void ladder(std::span<const Vec3d> a, std::span<const Vec3d> b);

    mesh::Mesh take();  // without vertices that no triangle uses; triangle_objects where an object was begun

  private:
    std::uint32_t vertex(const Vec3d& position, const Vec3d& normal);
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);  // dropped where it has no area
    std::vector<std::uint32_t> ring_around(const Frame& frame, double radius, int sides);
    void disc(const std::vector<std::uint32_t>& ring, const Vec3d& normal);
    void flat_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c);
    void flat_quad(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

    mesh::Mesh mesh_;
    const int roundness_;
    std::uint32_t material_ = 0;
    std::uint32_t objects_ = 0;
};

}  // namespace lodestream::samples
