// The scene graph of a glTF file: which mesh stands where.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/result.h"
#include "server/importer/gltf_accessor.h"
#include "server/importer/gltf_document.h"

namespace lodestream::importer {

struct GltfInstance {
    int mesh = 0;
    int skin = -1;
    Mat4d to_world{1.0};
    std::uint32_t node = 0;  // of GltfScene::parents
};

struct GltfScene {
    std::vector<GltfInstance> instances;  // sorted by mesh
    std::vector<Mat4d> node_to_world;     // of the scene's nodes; others are unit matrices
    std::vector<std::uint32_t> parents;   // of the scene's nodes, parents first: mesh::SceneGraph
};

// Of the default scene, or of all root nodes where no scene is named default.
// Errors: invalid_input (cycles, nodes that do not exist), limit_exceeded (nodes, depth, instances).
Result<GltfScene> walk_nodes(const GltfDocument& document, GltfAccessors& accessors, const Limits& limits);

}  // namespace lodestream::importer
