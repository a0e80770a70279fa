// Private to the codec: which normals a plain level sends.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::codec {

// The level with the normals of its Gouraud triangles replaced, within the tolerance (EncodeOptions), by those that
// sent_normals() derives in each material: Draco predicts the same from the positions, so they cost next to nothing,
// and corners that need no normals of their own become one vertex. Triangles keep their places; vertices are added
// behind the level's, each `source` of them having the attributes of that one. `grid_points`: of each of the level's
// vertices.
struct Replaced {
    mesh::Mesh level;
    std::vector<std::uint32_t> sources;  // of the added vertices
};
Replaced replace_normals(const mesh::Mesh& level, std::span<const std::uint8_t> gouraud,
                         const std::vector<Vec3d>& grid_points, double tolerance_degrees, int normal_bits);

}  // namespace lodestream::codec
