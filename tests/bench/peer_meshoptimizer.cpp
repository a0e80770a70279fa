#include <meshoptimizer.h>

#include <limits>
#include <utility>
#include <vector>

#include "common/mesh/operations.h"
#include "tests/bench/methods.h"

namespace lodestream::bench {

namespace {

std::vector<unsigned> simplified_indices(const mesh::Mesh& mesh, std::uint64_t triangles) {
    const std::size_t corners = 3 * mesh.triangles.size();
    std::vector<unsigned> kept(corners);
    kept.resize(meshopt_simplify(kept.data(), mesh.triangles.front().data(), corners, &mesh.positions.front().x,
                                 mesh.positions.size(), sizeof(Vec3f), 3 * triangles, std::numeric_limits<float>::max(),
                                 0, nullptr));
    return kept;
}

std::vector<mesh::Triangle> as_triangles(const std::vector<unsigned>& indices) {
    std::vector<mesh::Triangle> triangles;
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3)
        triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
    return triangles;
}

// compact() keeps the vertices of different materials apart, so a vertex knows its material.
std::vector<std::uint32_t> vertex_materials(const mesh::Mesh& mesh) {
    std::vector<std::uint32_t> materials(mesh.positions.size(), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t vertex : mesh.triangles[t]) materials[vertex] = mesh::material_of(mesh, t);
    return materials;
}

}  // namespace

Run run_meshoptimizer(const mesh::Mesh& mesh, const std::vector<std::uint64_t>& counts) {
    Run run;
    for (const std::uint64_t count : counts) {
        const Stopwatch time;
        const std::vector<unsigned> indices = simplified_indices(mesh, count);
        const Duration reached = time.elapsed();
        mesh::Mesh level;
        level.positions = mesh.positions;
        level.triangles = as_triangles(indices);
        run.levels.push_back({mesh::compact(level), reached});
    }
    return run;
}

namespace {

mesh::Mesh with_triangles(const mesh::Mesh& mesh, std::vector<mesh::Triangle> triangles) {
    mesh::Mesh level = mesh;
    level.triangles = std::move(triangles);
    level.triangle_materials.clear();
    const std::vector<std::uint32_t> materials = vertex_materials(mesh);
    for (const mesh::Triangle& t : level.triangles) level.triangle_materials.push_back(materials[t[0]]);
    return mesh::compact(level);
}

}  // namespace

mesh::Mesh simplify_with_seams(const mesh::Mesh& mesh, std::uint64_t triangles) {
    return with_triangles(mesh, as_triangles(simplified_indices(mesh, triangles)));
}

mesh::Mesh simplify_sloppily(const mesh::Mesh& mesh, std::uint64_t triangles) {
    const std::size_t corners = 3 * mesh.triangles.size();
    std::vector<unsigned> kept(corners);
    kept.resize(meshopt_simplifySloppy(kept.data(), mesh.triangles.front().data(), corners, &mesh.positions.front().x,
                                       mesh.positions.size(), sizeof(Vec3f), 3 * triangles,
                                       std::numeric_limits<float>::max(), nullptr));
    return with_triangles(mesh, as_triangles(kept));
}

}  // namespace lodestream::bench
