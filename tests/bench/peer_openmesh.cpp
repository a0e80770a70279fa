#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include <stdexcept>

#include "tests/bench/methods.h"

namespace lodestream::bench {

namespace {

using Surface = OpenMesh::TriMesh_ArrayKernelT<>;
using Decimater = OpenMesh::Decimater::DecimaterT<Surface>;
using Quadric = OpenMesh::Decimater::ModQuadricT<Surface>;

Surface to_openmesh(const mesh::Mesh& mesh) {
    Surface surface;
    surface.reserve(mesh.positions.size(), 3 * mesh.triangles.size() / 2, mesh.triangles.size());
    for (const Vec3f& p : mesh.positions) surface.add_vertex(Surface::Point(p.x, p.y, p.z));
    using Vertex = OpenMesh::VertexHandle;
    for (const mesh::Triangle& t : mesh.triangles)
        if (!surface
                 .add_face(Vertex(static_cast<int>(t[0])), Vertex(static_cast<int>(t[1])),
                           Vertex(static_cast<int>(t[2])))
                 .is_valid())
            throw std::runtime_error("OpenMesh refuses a triangle");
    return surface;
}

mesh::Mesh from_openmesh(const Surface& surface) {
    mesh::Mesh mesh;
    std::vector<std::uint32_t> number(surface.n_vertices());
    for (const auto vertex : surface.vertices()) {
        const Surface::Point& p = surface.point(vertex);
        number[static_cast<std::size_t>(vertex.idx())] = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(Vec3f(p[0], p[1], p[2]));
    }
    for (const auto face : surface.faces()) {
        mesh::Triangle triangle{};
        std::size_t k = 0;
        for (const auto vertex : surface.fv_range(face)) triangle[k++] = number[static_cast<std::size_t>(vertex.idx())];
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

}  // namespace

Run run_openmesh(const mesh::Mesh& mesh, const std::vector<std::uint64_t>& counts) {
    Run run;
    const Stopwatch preparation;
    Surface surface = to_openmesh(mesh);
    run.prepared = preparation.elapsed();

    Duration total;
    Stopwatch time;
    Decimater decimater(surface);
    OpenMesh::Decimater::ModHandleT<Quadric> quadric;
    decimater.add(quadric);
    decimater.module(quadric).unset_max_err();
    decimater.initialize();
    for (const std::uint64_t count : counts) {
        decimater.decimate_to_faces(0, count);
        const Duration more = time.elapsed();
        total = {total.wall_ms + more.wall_ms, total.cpu_ms + more.cpu_ms};
        surface.garbage_collection();  // the next call counts deleted triangles too
        run.levels.push_back({from_openmesh(surface), total});
        time = Stopwatch();
    }
    return run;
}

}  // namespace lodestream::bench
