#include "server/bake/seen_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/mesh/operations.h"
#include "common/scene/surroundings.h"

namespace lodestream::bake {

namespace {

constexpr std::uint32_t rough_cells = 48;
constexpr double wrapped_ratio = 8.0;  // triangles of a surface wrapped around to those of the finest level of it
constexpr std::size_t samples_per_triangle = 4;  // beside the corners

// How fine the surface wrapped around is to be, for a level of so many triangles.
std::uint32_t cells_for(const mesh::Mesh& mesh, std::uint64_t triangles) {
    const double faces = static_cast<double>(scene::Surroundings(mesh, rough_cells).faces());
    const double wanted = wrapped_ratio * static_cast<double>(triangles) / 2.0;
    return static_cast<std::uint32_t>(
        std::clamp<double>(rough_cells * std::sqrt(wanted / faces), scene::min_cells, scene::max_cells));
}

}  // namespace

mesh::Mesh bare(const mesh::Mesh& mesh) {
    mesh::Mesh out;
    out.positions = mesh.positions;
    out.triangles = mesh.triangles;
    return mesh::compact(out);
}

mesh::Mesh with_plausible_normals(mesh::Mesh level) {
    if (level.normals.empty()) return level;
    return mesh::with_plausible_normals(level, max_normal_degrees, level_crease_degrees);
}

bool can_be_painted(const std::vector<mesh::Material>& materials) {
    return std::all_of(materials.begin(), materials.end(), [](const mesh::Material& material) {
        return material.alpha_mode == mesh::AlphaMode::opaque && material.emissive == Vec3f(0.0f) &&
               material.emissive_texture.image < 0;
    });
}

std::size_t samples_of(const mesh::Mesh& mesh) {
    return std::min(metric::default_samples, samples_per_triangle * mesh.triangles.size());
}

SeenSurface seen_from_outside(const Surface& whole, std::uint64_t triangles, bool may_wrap) {
    const scene::Surroundings around(whole.mesh, cells_for(whole.mesh, triangles));
    std::vector<Surface> surfaces;
    surfaces.push_back({mesh::compact(mesh::part(whole.mesh, around.visible_triangles())), whole.is_bare});
    if (may_wrap) {
        mesh::Mesh wrapped = bare(around.wrapped());
        if (!wrapped.triangles.empty()) surfaces.push_back({std::move(wrapped), true});
    }
    metric::SurfaceIndex original(surfaces.front().mesh, samples_of(surfaces.front().mesh));
    original.keep_samples([&](const Vec3f& position) { return around.sees(position); });
    return {std::move(surfaces), around.visible_triangles(), std::move(original)};
}

}  // namespace lodestream::bake
