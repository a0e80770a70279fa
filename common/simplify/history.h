// Record, then cut: one decimation pass over a mesh records who merged into whom, and any level is read off that
// record. The engine behind record_history() is OpenMesh; nothing else of the project knows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/simplify/executor.h"

namespace lodestream::simplify {

// The state of a level after a step: how much of each array below belongs to it.
struct Step {
    std::uint32_t triangles = 0;
    std::uint32_t vertices = 0;  // made up to here
    std::uint32_t changes = 0;   // entries of changed_vertices
    bool operator==(const Step&) const = default;
};

// A progressive mesh (Hoppe 1996), coarse to fine: step 0 is the coarsest level, each further step undoes one merge.
// Arrays are in the order of use, so the level of N triangles is a prefix of each of them. A step gives, in this order:
// its new vertices and the new values of old ones (one entry of the value arrays each: first those of the new vertices,
// then those of changed_vertices); the corners of older triangles that now lie at its new vertices; new triangles.
// Attribute arrays are empty where the mesh has none.
template <template <class> class Array>
struct BasicHistory {
    Array<Step> steps;
    Array<Vec3f> positions;
    Array<std::uint32_t> normals;  // packed_normal.h
    Array<Vec2f> texture_coordinates;
    Array<Rgba8> colors;
    Array<std::uint32_t> changed_vertices;
    Array<std::uint32_t> moved_corners;      // 3 * triangle + 0, 1 or 2, by the vertex that they move to
    Array<std::uint32_t> moved_corner_ends;  // of each vertex: where its moved_corners end; they begin where those of
                                             // the vertex before it end
    Array<mesh::Triangle> triangles;
    Array<std::uint32_t> triangle_materials;
};

template <class T>
using OwnedArray = std::vector<T>;
template <class T>
using ArrayView = std::span<const T>;

using History = BasicHistory<OwnedArray>;
using HistoryView = BasicHistory<ArrayView>;  // of a History, or of a file mapped into memory

HistoryView view(const History& history);

struct RecordOptions {
    // Called now and then with the share done in [0,1], one call at a time; returning false cancels the recording.
    std::function<bool(double)> progress;
    Executor executor;  // the result is the same bytes for every one, and without one
};

// Records the whole history down to one triangle. Merges are placed where the integral of the squared distance to the
// triangles around them is least while their volume is kept (memoryless simplification: Lindstrom and Turk 1998, 1999);
// an open border and an attribute seam count as lines to stay on. Seams, borders and material borders are kept unless
// all else costs more than moving the area around a merge by its length, then merged nearest attribute first; a whole
// piece is dropped once it is less visible than the next merge; at the very end the least visible triangles go. `mesh`
// must be compact (see mesh/operations.h); triangles without three different positions and unused vertices are left
// out. Any connectivity is taken: non-manifold, soup, thousands of pieces. Errors: unavailable (cancelled),
// limit_exceeded (memory).
// The mesh is freed on the way: what is allocated beside it is at most about 250 bytes a vertex, 300 where surfaces
// touch.
Result<History> record_history(mesh::Mesh mesh, const RecordOptions& options = {});

// The level of the most triangles that is not above `triangles`. Attributes and materials follow. O(result).
// pre: validate(history)
mesh::Mesh cut(const HistoryView& history, std::uint64_t triangles);
inline mesh::Mesh cut(const History& history, std::uint64_t triangles) {
    return cut(view(history), triangles);
}

// The number of triangles that cut() gives for this budget.
std::uint64_t triangles_within(const HistoryView& history, std::uint64_t triangles);
// Of the finest level.
std::uint64_t triangle_count(const HistoryView& history);

// Whether a history from outside can be cut: sizes, ranges, order, finite values. Never trusts.
Status validate(const HistoryView& history);

}  // namespace lodestream::simplify
