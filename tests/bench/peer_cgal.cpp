#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <stdexcept>

#include "tests/bench/methods.h"

namespace lodestream::bench {

namespace {

namespace sms = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

Surface to_cgal(const mesh::Mesh& mesh) {
    Surface surface;
    surface.reserve(static_cast<unsigned>(mesh.positions.size()), static_cast<unsigned>(3 * mesh.triangles.size() / 2),
                    static_cast<unsigned>(mesh.triangles.size()));
    for (const Vec3f& p : mesh.positions) surface.add_vertex(Kernel::Point_3(p.x, p.y, p.z));
    using Vertex = Surface::Vertex_index;
    for (const mesh::Triangle& t : mesh.triangles)
        if (surface.add_face(Vertex(t[0]), Vertex(t[1]), Vertex(t[2])) == Surface::null_face())
            throw std::runtime_error("CGAL refuses a triangle");
    return surface;
}

mesh::Mesh from_cgal(const Surface& surface) {
    mesh::Mesh mesh;
    std::vector<std::uint32_t> number(surface.num_vertices());
    for (const auto vertex : surface.vertices()) {
        const Kernel::Point_3& p = surface.point(vertex);
        number[vertex.idx()] = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(Vec3f(Vec3d(p.x(), p.y(), p.z())));
    }
    for (const auto face : surface.faces()) {
        mesh::Triangle triangle{};
        std::size_t k = 0;
        for (const auto vertex : surface.vertices_around_face(surface.halfedge(face)))
            triangle[k++] = number[vertex.idx()];
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

// CGAL's own predicates count edges.
struct StopAtFaces {
    std::uint64_t faces;

    template <class Profile>
    bool operator()(double /*cost*/, const Profile& profile, std::size_t /*initial*/, std::size_t /*current*/) const {
        return profile.surface_mesh().number_of_faces() <= faces;
    }
};

}  // namespace

Run run_cgal(const mesh::Mesh& mesh, const std::vector<std::uint64_t>& counts) {
    Run run;
    const Stopwatch preparation;
    Surface surface = to_cgal(mesh);
    run.prepared = preparation.elapsed();
    Duration total;
    for (const std::uint64_t count : counts) {
        const Stopwatch time;
        sms::edge_collapse(surface, StopAtFaces{count},
                           CGAL::parameters::get_cost(sms::LindstromTurk_cost<Surface>())
                               .get_placement(sms::LindstromTurk_placement<Surface>()));
        const Duration more = time.elapsed();
        total = {total.wall_ms + more.wall_ms, total.cpu_ms + more.cpu_ms};
        run.levels.push_back({from_cgal(surface), total});
    }
    return run;
}

}  // namespace lodestream::bench
