// Other codecs, given a level as the engine cut it: what they make of it, without container and images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::bench {

struct Compressed {
    std::uint64_t bytes = 0;
    double encode_ms = 0.0;  // CPU time
    double decode_ms = 0.0;  // likewise, the least of the turns
    double arrays_ms = 0.0;  // Draco's alone: likewise, with arrays of floats and indices made of what it decodes
    mesh::Mesh decoded;
};

// As given, the defaults of gltf-transform's `draco` command. Speed: 0 is the smallest, 10 the fastest.
struct DracoSettings {
    int position_bits = 14;
    int normal_bits = 10;
    int texture_coordinate_bits = 12;
    int speed = 5;
};

// One stream a material; the grid of positions is of the whole level, as `quantizationVolume: mesh` has it. Throws
// std::runtime_error.
Compressed by_draco(const mesh::Mesh& level, const DracoSettings& settings, int turns);

// Of decoding these streams, to what Draco keeps or to arrays a renderer could be given.
double draco_ms(const std::vector<std::span<const std::byte>>& streams, int turns);
double draco_arrays_ms(const std::vector<std::span<const std::byte>>& streams, int turns);

// As given, gltfpack's: EXT_meshopt_compression of integers, normals by the octahedral filter.
struct MeshoptSettings {
    int position_bits = 14;  // at most 16
    int normal_bits = 8;     // likewise
    int texture_coordinate_bits = 12;
};

// Decoding ends with the integers that a GPU is given, as in glTF. Throws std::runtime_error.
Compressed by_meshopt(const mesh::Mesh& level, const MeshoptSettings& settings, int turns);

// One mesh a material, as codecs are given a level.
std::vector<mesh::Mesh> by_material(const mesh::Mesh& level);

}  // namespace lodestream::bench
