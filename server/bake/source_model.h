// The imported model as it is kept in the store until its bake is done.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::bake {

// Whether every node's parent is before it, and every object's node is there.
bool is_forest(const mesh::SceneGraph& graph);

std::vector<std::byte> serialize(const mesh::Model& model);
// Errors: invalid_input (damaged: sizes, indices and numbers are checked).
Result<mesh::Model> open_source_model(std::span<const std::byte> bytes);

}  // namespace lodestream::bake
