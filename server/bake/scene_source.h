// The objects of a baked scene as its source has them, each by itself, so that one can be read, moved and encoded again
// without the others.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/simplify/history.h"
#include "server/store/mapped_file.h"
#include "server/store/store.h"

namespace lodestream::bake {

inline constexpr std::string_view objects_key = "objects";  // among an asset's content
inline constexpr std::uint32_t no_tile = 0xffffffffu;

// Writes the stored form; a shape of the model is in it once. `triangles`: of each object in the model's mesh, none of
// an instance; `tiles`: of each object the finest tile that shows it, or no_tile where it has no triangles.
Result<store::StoredFile> put_scene_source(store::Store& store, const std::string& asset_id, const mesh::Model& model,
                                           std::span<const std::span<const std::uint32_t>> triangles,
                                           const std::vector<std::uint32_t>& tiles);

// What is kept of the objects. Meshes lie one behind the other: first of each object, of none in that of an instance,
// then of each shape.
template <template <class> class Array>
struct ObjectArrays {
    Array<Box> boxes;
    Array<std::uint32_t> tiles;
    Array<std::uint32_t> meshes;  // of each object: which one shows it; empty: each its own
    Array<Mat4d> matrices;  // of each object: from its mesh's coordinates to the model's; empty: none is elsewhere
    Array<std::uint64_t> first_vertex, first_triangle;  // one more than meshes
    Array<Vec3f> positions, normals;
    Array<Vec2f> texture_coordinates;
    Array<Rgba8> colors;
    Array<mesh::Triangle> triangles;  // of vertices counted from the mesh's first
    Array<std::uint32_t> triangle_materials;
};

class SceneSource {
  public:
    // Maps the stored form. Errors: not_found (the asset has none), invalid_input (damaged), io.
    static Result<SceneSource> open(const store::Store& store, const std::string& asset_id);

    std::uint32_t objects() const { return static_cast<std::uint32_t>(arrays_.tiles.size()); }
    // Everything but a mesh.
    const mesh::Model& model() const { return model_; }
    // Around the object, world axes; empty without triangles. pre: object < objects(), here and below
    const Box& box(std::uint32_t object) const { return arrays_.boxes[object]; }
    std::uint32_t tile(std::uint32_t object) const { return arrays_.tiles[object]; }
    // Its geometry, relative to the model's origin. Errors: invalid_input (damaged).
    Result<mesh::Mesh> mesh(std::uint32_t object) const;

  private:
    explicit SceneSource(store::MappedFile file) : file_(std::move(file)) {}
    Status read();

    store::MappedFile file_;
    mesh::Model model_;
    ObjectArrays<simplify::ArrayView> arrays_;
};

}  // namespace lodestream::bake
