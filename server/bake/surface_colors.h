// The colour of a model's surface at any place of it, for points: they carry no textures.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/math.h"
#include "common/image/codec.h"
#include "common/mesh/mesh.h"

namespace lodestream::bake {

class SurfaceColors {
  public:
    // `model`: its materials and images; `mesh`: the geometry. Both must outlive this. An image that cannot be decoded
    // is white.
    SurfaceColors(const mesh::Model& model, const mesh::Mesh& mesh);

    // The same model's on another geometry of it, which must outlive them.
    SurfaceColors on(const mesh::Mesh& mesh) const;

    // The colour of the whole surface, where it has but one.
    std::optional<Vec4f> constant() const;

    // Linear RGBA: the material's base colour, times its texture's nearest texel, times the vertices' colours.
    // pre: weights of the triangle's corners, in [0, 1]
    Rgba8 at(std::size_t triangle, const Vec3f& weights) const;

  private:
    using Images = std::vector<image::Pixels>;

    SurfaceColors(const mesh::Model& model, const mesh::Mesh& mesh, std::shared_ptr<const Images> images)
        : model_(model), mesh_(mesh), images_(std::move(images)) {}
    Vec4f texel(const mesh::TextureReference& texture, const Vec2f& place) const;

    const mesh::Model& model_;
    const mesh::Mesh& mesh_;
    std::shared_ptr<const Images> images_;  // those that base colours use; others are empty
};

}  // namespace lodestream::bake
