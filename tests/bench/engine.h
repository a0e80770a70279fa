// All that the benchmarks know of common/simplify.
#pragma once

#include <cstdint>

#include "common/mesh/mesh.h"
#include "common/simplify/history.h"

namespace lodestream::bench {

struct Recording {
    simplify::History history;
};

// Recorded on all cores; the mesh is freed on the way. Terminates with the error's message where the engine refuses.
Recording record(mesh::Mesh mesh);
mesh::Mesh cut(const Recording& recording, std::uint64_t triangles);

}  // namespace lodestream::bench
