// Writes a mesh as binary little-endian PLY 1.0, for `cut --out FILE.ply`.
#pragma once

#include <cstddef>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::cli {

// World positions (origin added, as doubles where there is an origin), normals, texture coordinates (s, t; v upwards as
// PLY's readers expect) and colours where the mesh has them.
std::vector<std::byte> write_ply(const mesh::Model& model);

}  // namespace lodestream::cli
