// What every format's reader fills: vertices in double precision, triangles, materials and counted defects.
// finish() makes the Model of it, so that all formats treat far-away coordinates, junk and missing normals alike.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "server/importer/importer.h"

namespace lodestream::importer {

// An object that shows a shape of the soup.
struct SoupInstance {
    std::uint32_t object = 0, shape = 0;
    Mat4d to_world{1.0};
};

class Soup {
  public:
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;              // empty or as far as set; zero: none
    std::vector<Vec2f> texture_coordinates;  // empty or as far as set
    std::vector<Rgba8> colors;               // empty or as far as set; linear
    std::vector<mesh::Triangle> triangles;   // indices < positions.size()
    std::vector<std::uint32_t> triangle_materials;
    std::vector<std::uint32_t> triangle_objects;
    std::uint32_t object = 0;  // of the triangles that are added from now on
    std::uint32_t shapes = 0;  // whose triangles are those of objects from first_shape on, in coordinates of their own
    std::vector<SoupInstance> instances;
    std::vector<mesh::Material> materials;
    std::vector<mesh::Image> images;
    std::uint64_t image_bytes = 0;
    mesh::Kind kind = mesh::Kind::mesh;
    bool may_be_cloud = false;  // the file means its vertices as points where it has no face
    std::uint64_t objects = 1;  // with triangles
    mesh::SceneGraph graph;     // where there is none, objects are 0 … objects - 1
    std::vector<std::string> warnings;

    std::uint64_t unreadable_faces = 0;    // of fewer than three corners or with words for numbers
    std::uint64_t out_of_range_faces = 0;  // naming vertices that are not there
    std::uint64_t other_primitives = 0;    // points and lines

    static constexpr std::uint32_t first_shape = 1u << 31;
    // What is added from now on is a shape: this one. pre: `objects` are fewer than first_shape
    std::uint32_t begin_shape() {
        object = first_shape + shapes;
        return shapes++;
    }

    std::uint32_t add_vertex(const Vec3d& position);
    std::uint32_t copy_vertex(std::uint32_t vertex);
    void set_normal(std::uint32_t vertex, const Vec3f& normal);
    void set_texture_coordinate(std::uint32_t vertex, const Vec2f& coordinate);
    void set_color(std::uint32_t vertex, const Rgba8& color);

    // Triangulates a simple polygon, concave or not, of vertices of this soup. pre: corners < positions.size()
    void add_polygon(std::span<const std::uint32_t> corners, std::uint32_t material = 0);
    void add_triangle(const mesh::Triangle& triangle, std::uint32_t material = 0) {
        triangles.push_back(triangle);
        triangle_materials.push_back(material);
        triangle_objects.push_back(object);
    }

    // Kept once each, and no more than a report can show.
    void warn(const std::string& text);

  private:
    std::vector<std::uint32_t> polygon_;
    std::vector<mesh::Triangle> cut_;
    std::uint64_t clipping_work_ = 0;
};

// limit_exceeded where a file says that it holds more than `limits` allow.
Status admit(std::uint64_t vertices, std::uint64_t triangles, const Limits& limits);

// 8-bit or [0,1] display colours (sRGB) to the linear ones of mesh::Mesh.
float linear_from_srgb(float srgb);
Rgba8 linear_from_srgb(const Vec4f& srgb);
Rgba8 quantized(const Vec4f& linear);

Result<mesh::Model> finish(Soup soup, const Limits& limits);

}  // namespace lodestream::importer
