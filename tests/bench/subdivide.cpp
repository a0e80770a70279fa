#include "tests/bench/subdivide.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/operations.h"
#include "tests/bench/connectivity.h"

namespace lodestream::bench {

namespace {

constexpr double smooth_degrees = 180.0;  // every edge is smooth: one normal a position

std::uint32_t previous_corner(std::uint32_t corner) {
    return next_corner(next_corner(corner));
}

// Sums of the neighbours of each vertex. A boundary vertex counts its two neighbours along the boundary alone.
struct Rings {
    std::vector<Vec3d> inner_sum, boundary_sum;
    std::vector<std::uint32_t> valence;
    std::vector<bool> on_boundary;
};

Rings gather_rings(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& opposite) {
    const std::size_t n = mesh.positions.size();
    Rings rings{std::vector<Vec3d>(n, Vec3d{0}), std::vector<Vec3d>(n, Vec3d{0}), std::vector<std::uint32_t>(n, 0),
                std::vector<bool>(n, false)};
    for (std::uint32_t c = 0; c < opposite.size(); ++c) {
        const std::uint32_t from = vertex_of(mesh.triangles, c), to = vertex_of(mesh.triangles, next_corner(c));
        rings.inner_sum[from] += Vec3d(mesh.positions[to]);
        ++rings.valence[from];
        if (opposite[c] != none) continue;
        rings.on_boundary[from] = rings.on_boundary[to] = true;
        rings.boundary_sum[from] += Vec3d(mesh.positions[to]);
        rings.boundary_sum[to] += Vec3d(mesh.positions[from]);
    }
    return rings;
}

Vec3f moved_vertex(const Vec3f& position, const Rings& rings, std::size_t v) {
    if (rings.on_boundary[v]) return Vec3f(0.75 * Vec3d(position) + 0.125 * rings.boundary_sum[v]);
    const double n = rings.valence[v];
    if (!(n > 0)) return position;
    const double beta = rings.valence[v] == 3 ? 3.0 / 16.0 : 3.0 / (8.0 * n);
    return Vec3f((1.0 - n * beta) * Vec3d(position) + beta * rings.inner_sum[v]);
}

Vec3f edge_vertex(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& opposite, std::uint32_t c) {
    const auto at = [&](std::uint32_t corner) { return Vec3d(mesh.positions[vertex_of(mesh.triangles, corner)]); };
    const Vec3d ends = at(c) + at(next_corner(c));
    if (opposite[c] == none) return Vec3f(0.5 * ends);
    return Vec3f(0.375 * ends + 0.125 * (at(previous_corner(c)) + at(previous_corner(opposite[c]))));
}

double lattice_value(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
    std::uint64_t k = seed + static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ull +
                      static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4full +
                      static_cast<std::uint64_t>(z) * 0x165667b19e3779f9ull;
    k = (k ^ (k >> 30)) * 0xbf58476d1ce4e5b9ull;
    k = (k ^ (k >> 27)) * 0x94d049bb133111ebull;
    return static_cast<double>((k ^ (k >> 31)) >> 11) * 0x1p-52 - 1.0;
}

// Random values at whole numbers, blended smoothly between; in [-1, 1].
double noise(const Vec3d& p, std::uint64_t seed) {
    const Vec3d base(std::floor(p.x), std::floor(p.y), std::floor(p.z));
    const Vec3d t = p - base, blend = t * t * (3.0 - 2.0 * t);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
        const double weight =
            (dx ? blend.x : 1 - blend.x) * (dy ? blend.y : 1 - blend.y) * (dz ? blend.z : 1 - blend.z);
        sum += weight * lattice_value(static_cast<std::int64_t>(base.x) + dx, static_cast<std::int64_t>(base.y) + dy,
                                      static_cast<std::int64_t>(base.z) + dz, seed);
    }
    return sum;
}

double mean_edge(const mesh::Mesh& mesh) {
    double sum = 0;
    for (const mesh::Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            sum += length(Vec3d(mesh.positions[t[k]]) - Vec3d(mesh.positions[t[(k + 1) % 3]]));
    return sum / std::max<double>(1.0, 3.0 * static_cast<double>(mesh.triangles.size()));
}

void displace(mesh::Mesh& mesh, double longest, double shortest, double roughness, std::uint64_t seed) {
    mesh = mesh::with_normals(mesh, smooth_degrees);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        double height = 0;
        std::uint64_t octave = 0;
        for (double wavelength = longest; wavelength >= shortest; wavelength /= 2)
            height += wavelength * noise(Vec3d(mesh.positions[v]) / wavelength, seed + octave++);
        mesh.positions[v] = Vec3f(Vec3d(mesh.positions[v]) + roughness * height * Vec3d(mesh.normals[v]));
    }
    mesh.normals.clear();
}

}  // namespace

mesh::Mesh loop_subdivide(const mesh::Mesh& mesh) {
    const std::vector<std::uint32_t> opposite = opposite_corners(mesh.triangles);
    const Rings rings = gather_rings(mesh, opposite);
    mesh::Mesh fine;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        fine.positions.push_back(moved_vertex(mesh.positions[v], rings, v));
    std::vector<std::uint32_t> middle(opposite.size(), none);  // of the edge that a corner's edge leads along
    for (std::uint32_t c = 0; c < opposite.size(); ++c) {
        if (middle[c] != none) continue;
        middle[c] = static_cast<std::uint32_t>(fine.positions.size());
        if (opposite[c] != none) middle[opposite[c]] = middle[c];
        fine.positions.push_back(edge_vertex(mesh, opposite, c));
    }
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [a, b, c] = mesh.triangles[t];
        const std::uint32_t ab = middle[3 * t], bc = middle[3 * t + 1], ca = middle[3 * t + 2];
        fine.triangles.insert(fine.triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    return fine;
}

mesh::Mesh detailed(const mesh::Mesh& base, int steps, double roughness, std::uint64_t seed) {
    mesh::Mesh mesh = base;
    const double longest = 8 * mean_edge(base);
    for (int step = 0; step < steps; ++step) mesh = loop_subdivide(mesh);
    displace(mesh, longest, 2 * mean_edge(mesh), roughness, seed);
    return mesh;
}

}  // namespace lodestream::bench
