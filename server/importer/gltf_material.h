#pragma once

#include <cstdint>
#include <map>

#include "server/importer/gltf_accessor.h"
#include "server/importer/gltf_document.h"
#include "server/importer/soup.h"

namespace lodestream::importer {

// Which texture coordinates a material samples with, and how KHR_texture_transform moves them.
struct GltfTextureCoordinates {
    int set = 0;
    double offset[2] = {0, 0};
    double rotation = 0;
    double scale[2] = {1, 1};

    bool operator==(const GltfTextureCoordinates&) const = default;
    Vec2f applied(float u, float v) const;
};

struct GltfMaterialUse {
    std::uint32_t material = 0;  // into Soup::materials
    GltfTextureCoordinates coordinates;
};

// Converts materials and loads their images when a primitive first asks for them.
class GltfMaterials {
  public:
    GltfMaterials(const GltfDocument& document, GltfAccessors& accessors, const Source& source, Soup& soup);
    // `material` as a primitive states it; -1: the default one. Errors: invalid_input.
    Result<GltfMaterialUse> use(int material);

  private:
    struct Slot;
    mesh::TextureReference texture(int index);
    int image(int index);
    GltfMaterialUse convert(const tinygltf::Material& from);

    const GltfDocument& document_;
    GltfAccessors& accessors_;
    const Source& source_;
    Soup& soup_;
    std::map<int, GltfMaterialUse> used_;
    std::map<int, int> images_;
};

}  // namespace lodestream::importer
