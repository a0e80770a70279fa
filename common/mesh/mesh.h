// The one mesh type that every stage reads and writes, and the model around it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "common/base/math.h"

namespace lodestream::mesh {

using Triangle = std::array<std::uint32_t, 3>;  // counter-clockwise seen from outside

// An indexed triangle mesh. A *vertex* carries all its attributes, so vertices at one position that differ in normal,
// texture coordinate, colour or material are several (the field's "wedges"); they share the bit pattern of the
// position. Every attribute vector is either empty (the mesh does not have it) or as long as `positions`.
struct Mesh {
    std::vector<Vec3f> positions;                   // model units, relative to Model::origin; finite
    std::vector<Vec3f> normals;                     // unit length
    std::vector<Vec2f> texture_coordinates;         // glTF convention: (0,0) is the image's upper left
    std::vector<Rgba8> colors;                      // linear RGBA
    std::vector<Triangle> triangles;                // indices < positions.size(), three different positions each
    std::vector<std::uint32_t> triangle_materials;  // into Model::materials, one a triangle; empty: all are material 0
    std::vector<std::uint32_t> triangle_objects;    // into Model::graph's objects, one a triangle; empty: one object
};

inline std::uint32_t material_of(const Mesh& mesh, std::size_t triangle) {
    return mesh.triangle_materials.empty() ? 0u : mesh.triangle_materials[triangle];
}

enum class Wrap { repeat, clamp_to_edge, mirrored_repeat };

struct TextureReference {
    int image = -1;  // into Model::images; -1: no texture
    Wrap wrap_s = Wrap::repeat;
    Wrap wrap_t = Wrap::repeat;
};

enum class AlphaMode { opaque, mask, blend };

// glTF 2.0's metallic-roughness material, as far as vertex and face shading can show it. Normal textures are left out
// on import: Gouraud and flat shading never sample them.
struct Material {
    std::string name;
    Vec4f base_color{1.0f};  // linear
    float metallic = 0.0f;
    float roughness = 0.6f;
    Vec3f emissive{0.0f};
    TextureReference base_color_texture;
    TextureReference metallic_roughness_texture;
    TextureReference occlusion_texture;
    TextureReference emissive_texture;
    AlphaMode alpha_mode = AlphaMode::opaque;
    float alpha_cutoff = 0.5f;
    bool double_sided = false;
};

inline bool has_texture(const Material& m) {
    return m.base_color_texture.image >= 0 || m.metallic_roughness_texture.image >= 0 ||
           m.occlusion_texture.image >= 0 || m.emissive_texture.image >= 0;
}

struct Image {
    std::string media_type;  // "image/png" or "image/jpeg"
    std::vector<std::byte> bytes;
    std::uint32_t width = 0;  // texels
    std::uint32_t height = 0;
};

enum class Kind { mesh, scene, terrain, points };
const char* kind_name(Kind kind);  // "mesh", "scene", "terrain", "points"

// The source's scene graph, whose transforms are already applied. A mesh that several nodes show is several objects.
struct SceneGraph {
    std::vector<std::uint32_t> parents;       // of each node: a node before it, or no_parent
    std::vector<std::uint32_t> object_nodes;  // of each object: its node; empty where the mesh is one object
};
inline constexpr std::uint32_t no_parent = std::numeric_limits<std::uint32_t>::max();

// A root with a node for each object below it.
SceneGraph flat_graph(std::uint32_t objects);

// An object that shows a shape of the model, as others may.
struct Instance {
    std::uint32_t object = 0;  // of the graph's
    std::uint32_t shape = 0;   // into Model::shapes
    Mat4d matrix{1.0};         // from the shape's coordinates to those of Model::mesh; affine, not singular
};

// One imported asset: world-space geometry (node transforms applied) and what it needs to be drawn.
struct Model {
    Mesh mesh;
    std::vector<Mesh> shapes;         // of instances: in coordinates of their own, without triangle_objects
    std::vector<Instance> instances;  // the objects that are not in `mesh`
    std::vector<Material> materials;  // never empty where the mesh has triangles
    std::vector<Image> images;
    Vec3d origin{0.0};  // world position of the mesh's (0,0,0); keeps float positions exact far from the world's origin
    Kind kind = Kind::mesh;
    SceneGraph graph;
    std::uint32_t objects = 1;  // those of the graph that have triangles
};

}  // namespace lodestream::mesh
