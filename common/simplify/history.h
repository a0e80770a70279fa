// Record, then cut: one decimation pass over a mesh records who merged into whom, and any level is read off that
// record. The engine behind record_history() is OpenMesh; nothing else of the project knows.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::simplify {

inline constexpr std::uint32_t never = std::numeric_limits<std::uint32_t>::max();

// The collapse history of one mesh. Steps are numbered 0, 1, … in the order in which they were made; at each step one
// position (all its vertices) merges into another, or, at the very end, single triangles are dropped.
struct History {
    std::vector<std::uint32_t> vertex_parent;   // a vertex: the vertex it merges into; itself if it never does
    std::vector<std::uint32_t> vertex_step;     // a vertex: the step of that merge; `never` if it stays
    std::vector<std::uint32_t> triangle_order;  // the source's triangles, longest-living first
    std::vector<std::uint32_t> triangle_step;   // of triangle_order[i]: the step at which it vanishes; non-increasing
};

struct RecordOptions {
    // Called now and then with the share done in [0,1]; returning false cancels the recording.
    std::function<bool(double)> progress;
};

// Records the whole history down to one triangle. Priority: quadric error (Garland and Heckbert 1997) with planes along
// open boundaries and attribute seams. Seams, boundaries and material borders are kept unless all else costs more than
// moving the area around a merge by its length, then merged nearest attribute first; a whole piece is dropped once it
// is less visible than the next merge; at the very end the least visible triangles go. Deterministic. `mesh` must be
// compact (see mesh/operations.h). Any connectivity is taken: non-manifold, soup, thousands of pieces. Errors:
// unavailable (cancelled).
Result<History> record_history(const mesh::Mesh& mesh, const RecordOptions& options = {});

// The level of the most triangles that is not above `triangles`. Attributes and materials follow. O(result).
// pre: history was recorded for `source`.
mesh::Mesh cut(const mesh::Mesh& source, const History& history, std::uint64_t triangles);

// Whether a history read from outside belongs to a mesh of these counts: sizes, ranges, order. Never trusts.
Status validate(const History& history, std::size_t vertices, std::size_t triangles);

}  // namespace lodestream::simplify
