// An asset's ladder as a 3D Tiles 1.1 tileset: a chain of tiles from the coarsest level (the root) to the finest, each
// replacing the one above it. Source: OGC 3D Tiles 1.1 (22-025r4), 7.2 "Geometric error" and 7.4 "Refinement".
#pragma once

#include <string>

#include "proto/messages.h"

namespace lodestream::http {

// True for a ready asset that has levels and bounds: what tileset_json() needs.
bool has_tileset(const proto::Asset& asset);

// A tile's geometricError is its level's max_error, its content the level's url as it stands in `asset` (set other urls
// for tiles that lie beside the tileset). glTF is y up and tiles are z up: (x, y, z) becomes (x, -z, y).
// pre: has_tileset(asset)
std::string tileset_json(const proto::Asset& asset);

}  // namespace lodestream::http
