// All that the benchmarks know of common/simplify.
#pragma once

#include <cstdint>
#include <string>

#include "common/mesh/mesh.h"
#include "common/simplify/history.h"

namespace lodestream::bench {

struct Recording {
    simplify::History history;
};

// Recorded on all cores; the mesh is freed on the way. Terminates with the error's message where the engine refuses.
Recording record(mesh::Mesh mesh);
mesh::Mesh cut(const Recording& recording, std::uint64_t triangles);

// What recording a model (see load_input()) needs at its peak beside the mesh, in a copy of this process that has
// nothing but the mesh: what reading the file leaves in the heap is left in another. Of the engine alone where this
// process has done nothing big yet.
std::uint64_t recording_peak_bytes(const std::string& spec, const std::string& folder);

}  // namespace lodestream::bench
