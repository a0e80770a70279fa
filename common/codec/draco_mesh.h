// Draco behind a plain face, for the level codec and for importing KHR_draco_mesh_compression and .drc files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::codec {

// A decoded attribute: `components` floats a point. Attributes of more than four components are not read.
struct DracoAttribute {
    enum class Semantic { position, normal, color, texture_coordinate, generic };
    Semantic semantic = Semantic::generic;
    int components = 0;         // 1 … 4
    bool normalized = false;    // integer data that stands for [0,1] or [-1,1]
    std::vector<float> values;  // components * points; integers are converted, normalized ones scaled
};

struct DracoMesh {
    std::uint32_t points = 0;
    std::vector<mesh::Triangle> triangles;               // empty for a point cloud
    std::map<std::uint32_t, DracoAttribute> attributes;  // by Draco's unique id
    // Of each point, the first one with the same value as its position; empty: no two points share one.
    std::vector<std::uint32_t> first_at_position;
};

// Between the first points at their positions; as they are where `first_at_position` is empty.
std::vector<mesh::Triangle> between_positions(std::vector<mesh::Triangle> triangles,
                                              const std::vector<std::uint32_t>& first_at_position);

// Decodes hostile bytes. Errors: invalid_input (damaged, truncated), limit_exceeded (more than max_points or faces).
// Costs at most about what a sound stream of the same length and counts costs.
Result<DracoMesh> decode_draco(std::span<const std::byte> bytes, std::uint64_t max_points, std::uint64_t max_triangles);

}  // namespace lodestream::codec
