// Models whose objects show shapes that are there once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::mesh {

// Instances counted as often as they are shown.
std::uint64_t triangle_count(const Model& model);
std::uint64_t vertex_count(const Model& model);

// The smallest box around all that the model shows, relative to its origin.
Box bounds(const Model& model);

// What an instance shows, in the coordinates of Model::mesh: `shape` is the model's, or a level of it.
Mesh placed(const Mesh& shape, const Instance& instance);
Box bounds(const Mesh& shape, const Instance& instance);  // of that

// The model as one mesh. `shapes`: what is shown of each of the model's shapes; the shapes themselves, or levels of
// them. pre: all have the attributes of Model::mesh
Mesh flattened(const Model& model, std::span<const Mesh> shapes);
// The same model without shapes: what its instances show is in its mesh.
Model without_instances(Model model);

}  // namespace lodestream::mesh
