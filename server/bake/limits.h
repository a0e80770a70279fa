// What one bake may take.
#pragma once

#include <cstdint>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::bake {

inline constexpr double default_max_bake_s = 3600.0;
inline constexpr double memory_share = 0.75;                 // of the machine's memory, where no limit is given
inline constexpr std::uint64_t bake_bytes_per_vertex = 400;  // measured, beside the model and the mesh it is judged by
inline constexpr std::uint32_t max_bake_starts = 2;          // of one asset that end with the program's own end

struct Limits {
    double max_bake_s = default_max_bake_s;  // from the start of the bake, checked whenever it tells its progress
    std::uint64_t max_memory_bytes = 0;      // estimated need; 0: memory_share of the machine
};

std::uint64_t memory_bytes(const mesh::Model& model);                 // of its meshes and images
std::uint64_t bake_memory_bytes(const mesh::Model& model);            // estimated peak of its bake
Status check_memory(const mesh::Model& model, const Limits& limits);  // limit_exceeded, with both figures

}  // namespace lodestream::bake
