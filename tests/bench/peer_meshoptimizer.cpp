#include <meshoptimizer.h>

#include <limits>

#include "common/mesh/operations.h"
#include "tests/bench/methods.h"

namespace lodestream::bench {

namespace {

mesh::Mesh with_indices(const mesh::Mesh& source, const std::vector<unsigned>& indices) {
    mesh::Mesh level;
    level.positions = source.positions;
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3)
        level.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
    return mesh::compact(level);
}

}  // namespace

Run run_meshoptimizer(const mesh::Mesh& mesh, const std::vector<std::uint64_t>& counts) {
    Run run;
    const std::size_t corners = 3 * mesh.triangles.size();
    const unsigned* indices = mesh.triangles.front().data();
    for (const std::uint64_t count : counts) {
        const Stopwatch time;
        std::vector<unsigned> kept(corners);
        const std::size_t size =
            meshopt_simplify(kept.data(), indices, corners, &mesh.positions.front().x, mesh.positions.size(),
                             sizeof(Vec3f), 3 * count, std::numeric_limits<float>::max(), 0, nullptr);
        const Duration reached = time.elapsed();
        kept.resize(size);
        run.levels.push_back({with_indices(mesh, kept), reached});
    }
    return run;
}

}  // namespace lodestream::bench
