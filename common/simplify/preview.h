// Coarse levels at once, to be shown while the history is still being recorded.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"
#include "common/simplify/history.h"

namespace lodestream::simplify {

struct Preview {
    mesh::Mesh mesh;             // compact; attributes are those of vertices of the source
    metric::SurfaceError error;  // two-sided, by samples; from the level to the source an upper bound
};

// For each of `max_triangles` a level of at most so many triangles, as a rule not far below. O(n log max_triangles):
// vertices are clustered, always the widest cell halved next (hierarchical clustering: Brodsky and Watson 2000); what
// hangs together in a cell becomes one vertex where the squared distance to its triangles' planes is least (Lindstrom
// 2000), once for each side of an attribute seam. Where that leaves nothing (soup), the largest triangles are kept as
// they are. `executor`: as in RecordOptions; the result is the same for every executor. pre: `mesh` is compact and
// finite, counts are >= 1. Previews are empty only where the mesh is.
std::vector<Preview> make_previews(const mesh::Mesh& mesh, std::span<const std::uint64_t> max_triangles,
                                   const Executor& executor = {});

}  // namespace lodestream::simplify
