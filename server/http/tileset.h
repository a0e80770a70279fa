// A tree of levels as a 3D Tiles 1.1 tileset, each tile replacing those below it.
// Source: OGC 3D Tiles 1.1 (22-025r4), 7.2 "Geometric error" and 7.4 "Refinement".
#pragma once

#include <functional>
#include <span>
#include <string>

#include "common/scene/lod_tree.h"

namespace lodestream::http {

// A tile's geometricError is its level's maximum error, its content what `uri` says of the tile at this place. glTF is
// y up and tiles are z up: (x, y, z) becomes (x, -z, y). pre: validate(tree)
std::string tileset_json(std::span<const scene::LodNode> tree, const std::function<std::string(std::size_t)>& uri);

}  // namespace lodestream::http
