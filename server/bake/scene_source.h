// The objects of a baked scene as its source has them, each by itself, so that one can be read, moved and encoded again
// without the others.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "server/store/mapped_file.h"
#include "server/store/store.h"

namespace lodestream::bake {

inline constexpr std::string_view objects_key = "objects";  // among an asset's content
inline constexpr std::uint32_t no_tile = 0xffffffffu;

// Writes the stored form. `triangles`: of each object; `tiles`: of each object the finest tile that shows it, or
// no_tile where it has no triangles.
Result<store::StoredFile> put_scene_source(store::Store& store, const std::string& asset_id, const mesh::Model& model,
                                           std::span<const std::span<const std::uint32_t>> triangles,
                                           const std::vector<std::uint32_t>& tiles);

class SceneSource {
  public:
    // Maps the stored form. Errors: not_found (the asset has none), invalid_input (damaged), io.
    static Result<SceneSource> open(const store::Store& store, const std::string& asset_id);

    std::uint32_t objects() const { return static_cast<std::uint32_t>(tiles_.size()); }
    // Everything but a mesh.
    const mesh::Model& model() const { return model_; }
    // Around the object, world axes; empty without triangles. pre: object < objects(), here and below
    const Box& box(std::uint32_t object) const { return boxes_[object]; }
    std::uint32_t tile(std::uint32_t object) const { return tiles_[object]; }
    // Its geometry, relative to the model's origin. Errors: invalid_input (damaged).
    Result<mesh::Mesh> mesh(std::uint32_t object) const;

  private:
    explicit SceneSource(store::MappedFile file) : file_(std::move(file)) {}
    Status read();

    store::MappedFile file_;
    mesh::Model model_;
    std::span<const Box> boxes_;
    std::span<const std::uint32_t> tiles_;
    std::span<const std::uint64_t> first_vertex_, first_triangle_;  // one more than objects
    std::span<const Vec3f> positions_, normals_;
    std::span<const Vec2f> texture_coordinates_;
    std::span<const Rgba8> colors_;
    std::span<const mesh::Triangle> triangles_;  // of vertices counted from the object's first
    std::span<const std::uint32_t> triangle_materials_;
};

}  // namespace lodestream::bake
