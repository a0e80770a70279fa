// Every codec over its settings on one level: what each setting costs, and what it alone is off.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"
#include "tests/bench/judge.h"

namespace lodestream::bench {

struct CodecTrial {
    std::string codec;        // "plain", "lean", "draco", "meshopt"
    std::string setting;      // "14 bits, speed 5"
    bool is_default = false;  // what the codec is used with
    std::uint64_t bytes = 0;  // of the geometry: without container and images
    double encode_ms = 0.0;   // CPU time
    double decode_ms = 0.0;   // likewise, the least of the turns
    double image_rms = 0.0;   // against the level as it was before encoding, ImageError::rms
};

struct SweptLevel {
    const mesh::Model& model;
    const mesh::Mesh& level;            // of it
    const Box& grid_bounds;             // of all levels
    const metric::SurfaceError& error;  // the level's
};

// Throws std::runtime_error where a codec refuses.
std::vector<CodecTrial> sweep_codecs(const SweptLevel& swept, Painter& painter, int turns);

// What was found of one level of a model.
struct SweptModel {
    std::string model;
    std::uint64_t triangles = 0;
    std::vector<CodecTrial> trials;
};

// For `lodestream-client report --codecs`. Throws std::runtime_error where it cannot be written.
void write_sweep(const std::string& file, const std::string& command_line, const std::vector<SweptModel>& models);

}  // namespace lodestream::bench
