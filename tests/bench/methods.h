// The contestants. All get the same mesh and return the levels asked for with the time that each took.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/mesh.h"
#include "tests/bench/stopwatch.h"

namespace lodestream::bench {

struct Level {
    mesh::Mesh mesh;
    Duration reached;  // from the mesh in the method's own structure to this many triangles
};

struct Run {
    std::vector<Level> levels;  // one for each count asked for
    Duration prepared;          // building the method's own structure, which `reached` leaves out
    Duration cut;               // ours: reading all levels off the record
};

// `counts` fall. All methods stop at the count, or where they can go no further.

// Ours: `reached` is the whole history, down to its floor, and the same for every level.
Run run_ours(const mesh::Mesh& mesh, const std::vector<std::uint64_t>& counts);
// One meshopt_simplify call a count, each from the full mesh, without a bound on the error.
Run run_meshoptimizer(const mesh::Mesh& mesh, const std::vector<std::uint64_t>& counts);
// CGAL's Surface_mesh_simplification with Lindstrom and Turk's cost and placement, in double precision. A lower count
// goes on from the one before: the method keeps no memory of earlier collapses.
Run run_cgal(const mesh::Mesh& mesh, const std::vector<std::uint64_t>& counts);
// OpenMesh's DecimaterT with ModQuadricT and no bound on the error. A lower count goes on from the one before, with the
// quadrics gathered so far.
Run run_openmesh(const mesh::Mesh& mesh, const std::vector<std::uint64_t>& counts);

// One meshopt_simplify call on all vertices with their attributes, so that it sees and keeps the seams as it would on a
// textured model; materials follow. The result has the count that it could reach.
mesh::Mesh simplify_with_seams(const mesh::Mesh& mesh, std::uint64_t triangles);

// One meshopt_simplifySloppy call, which keeps no topology; materials follow. At most so many triangles.
mesh::Mesh simplify_sloppily(const mesh::Mesh& mesh, std::uint64_t triangles);

struct Method {
    std::string name;
    Run (*run)(const mesh::Mesh&, const std::vector<std::uint64_t>&);
};

inline const std::vector<Method>& methods() {
    static const std::vector<Method> all{
        {"ours", run_ours}, {"meshopt", run_meshoptimizer}, {"cgal", run_cgal}, {"openmesh", run_openmesh}};
    return all;
}

}  // namespace lodestream::bench
