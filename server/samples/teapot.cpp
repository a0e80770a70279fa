// Martin Newell's teapot (1975; the bottom by Frank Crow, 1987). Rim, body, bottom and lid are surfaces of revolution,
// handle and spout are symmetric about their middle plane, so four tubes hold all 32 patches: a tube is a row of rings,
// and each ring goes once around all patches of its row.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "server/samples/count_limits.h"
#include "server/samples/samples.h"

namespace lodestream::samples {
namespace {

using Row = std::array<Vec3d, 4>;  // control points around
using Patch = std::array<Row, 4>;  // rows along the tube
using Piece = std::vector<Patch>;  // the patches around a tube, which close into a ring
struct Tube {
    std::vector<Piece> pieces;  // along the tube
    bool starts_at_pole = false;
    bool ends_at_pole = false;
    bool inside_out = false;  // along × around points inwards
};

// Newell's control points, z up.

struct ProfilePoint {
    double radius, height;
    double roundness = 0.56;  // handle length of the quarter circle, over the radius
};
using Profile = std::array<ProfilePoint, 4>;

constexpr Profile rim{{{1.4, 2.4}, {1.3375, 2.53125}, {1.4375, 2.53125}, {1.5, 2.4}}};
constexpr Profile upper_body{{{1.5, 2.4}, {1.75, 1.875}, {2, 1.35}, {2, 0.9}}};
constexpr Profile lower_body{{{2, 0.9}, {2, 0.45}, {1.5, 0.225}, {1.5, 0.15}}};
constexpr Profile bottom{{{1.5, 0.15}, {1.5, 0.075}, {1.425, 0}, {0, 0}}};
constexpr Profile knob{{{0, 3.15}, {0.8, 3.15, 0.5625}, {0, 2.85}, {0.2, 2.7}}};
constexpr Profile lid{{{0.2, 2.7}, {0.4, 2.55}, {1.3, 2.55}, {1.3, 2.4}}};

// One side (y <= 0) of handle and spout: the row's first and last point lie in the plane y = 0, the two between at
// -width.
struct SideRow {
    double first_x, first_z, last_x, last_z, width;
};
using Side = std::array<SideRow, 4>;

constexpr Side upper_handle{{{-1.6, 2.025, -1.5, 2.25, 0.3},
                             {-2.3, 2.025, -2.5, 2.25, 0.3},
                             {-2.7, 2.025, -3.0, 2.25, 0.3},
                             {-2.7, 1.8, -3.0, 1.8, 0.3}}};
constexpr Side lower_handle{{{-2.7, 1.8, -3.0, 1.8, 0.3},
                             {-2.7, 1.575, -3.0, 1.35, 0.3},
                             {-2.5, 1.125, -2.65, 0.9375, 0.3},
                             {-2.0, 0.9, -1.9, 0.6, 0.3}}};
constexpr Side lower_spout{{{1.7, 1.425, 1.7, 0.6, 0.66},
                            {2.6, 1.425, 3.1, 0.825, 0.66},
                            {2.3, 2.1, 2.4, 2.025, 0.25},
                            {2.7, 2.4, 3.3, 2.4, 0.25}}};
constexpr Side upper_spout{{{2.7, 2.4, 3.3, 2.4, 0.25},
                            {2.8, 2.475, 3.525, 2.49375, 0.25},
                            {2.9, 2.475, 3.45, 2.5125, 0.15},
                            {2.8, 2.4, 3.2, 2.4, 0.15}}};

Piece revolve(const Profile& profile) {
    Piece quarters(4);
    for (std::size_t i = 0; i < 4; ++i) {
        const auto [r, z, roundness] = profile[i];
        const double k = roundness * r;
        quarters[0][i] = {Vec3d{r, 0, z}, Vec3d{r, k, z}, Vec3d{k, r, z}, Vec3d{0, r, z}};
        for (std::size_t q = 1; q < 4; ++q)
            for (std::size_t j = 0; j < 4; ++j) {
                const Vec3d& p = quarters[q - 1][i][j];
                quarters[q][i][j] = {-p.y, p.x, p.z};
            }
    }
    return quarters;
}

Piece mirror(const Side& side) {
    Piece halves(2);
    for (std::size_t i = 0; i < 4; ++i) {
        const auto [x0, z0, x1, z1, width] = side[i];
        halves[0][i] = {Vec3d{x0, 0, z0}, Vec3d{x0, -width, z0}, Vec3d{x1, -width, z1}, Vec3d{x1, 0, z1}};
        halves[1][i] = {Vec3d{x1, 0, z1}, Vec3d{x1, width, z1}, Vec3d{x0, width, z0}, Vec3d{x0, 0, z0}};
    }
    return halves;
}

std::vector<Tube> newell_tubes() {
    return {{.pieces = {revolve(rim), revolve(upper_body), revolve(lower_body), revolve(bottom)}, .ends_at_pole = true},
            {.pieces = {revolve(knob), revolve(lid)}, .starts_at_pole = true},
            {.pieces = {mirror(upper_handle), mirror(lower_handle)}, .inside_out = true},
            {.pieces = {mirror(lower_spout), mirror(upper_spout)}, .inside_out = true}};
}

struct SurfacePoint {
    Vec3d position, around, along;
};

std::array<double, 4> bernstein(double t) {
    const double s = 1 - t;
    return {s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
}

std::array<double, 4> bernstein_slope(double t) {
    const double s = 1 - t;
    return {-3 * s * s, 3 * s * s - 6 * s * t, 6 * s * t - 3 * t * t, 3 * t * t};
}

SurfacePoint evaluate(const Patch& patch, double u, double v) {
    const auto bu = bernstein(u), bv = bernstein(v), du = bernstein_slope(u), dv = bernstein_slope(v);
    SurfacePoint s{Vec3d{0}, Vec3d{0}, Vec3d{0}};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j) {
            s.position += patch[i][j] * (bv[i] * bu[j]);
            s.around += patch[i][j] * (bv[i] * du[j]);
            s.along += patch[i][j] * (dv[i] * bu[j]);
        }
    return s;
}

// How finely each tube is cut.

struct Ring {
    const Piece* piece;
    double along;            // in the piece
    std::uint64_t vertices;  // around; 1 at a pole
    std::uint64_t strips;    // that it borders on: a vertex more on it is so many triangles more
    bool pole = false;
};
using Rings = std::vector<Ring>;

Rings cut(const Tube& tube, std::uint64_t rows, std::uint64_t columns, bool extra_row) {
    Rings rings;
    for (std::size_t i = 0; i < tube.pieces.size(); ++i) {
        const Piece& piece = tube.pieces[i];
        const std::uint64_t n = rows + (extra_row && i == 1 ? 1 : 0);
        for (std::uint64_t row = i == 0 ? 0 : 1; row <= n; ++row)
            rings.push_back({&piece, static_cast<double>(row) / static_cast<double>(n), columns * piece.size(), 2});
    }
    for (const bool first : {true, false}) {
        Ring& end = first ? rings.front() : rings.back();
        end.pole = first ? tube.starts_at_pole : tube.ends_at_pole;
        end.strips = end.pole ? 0 : 1;
        if (end.pole) end.vertices = 1;
    }
    return rings;
}

// 32 patches of rows * columns quads. The fans at the two poles fall short by half a row each; one row more on the
// upper body, the largest patch, makes up for both. What is then missing is spread as evenly over the rings as it goes.
std::vector<Rings> cut_all(const std::vector<Tube>& tubes, std::uint64_t triangles) {
    const auto rows = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(triangles) / 64.0));
    const std::uint64_t columns = triangles / (64 * rows);
    std::vector<Rings> cuts;
    for (const Tube& tube : tubes) cuts.push_back(cut(tube, rows, columns, &tube == &tubes.front()));

    const std::uint64_t missing = triangles - 64 * rows * columns;
    std::uint64_t capacity = 0, passed = 0, given = 0;
    for (const Rings& rings : cuts)
        for (const Ring& ring : rings) capacity += ring.strips;
    for (Rings& rings : cuts)
        for (Ring& ring : rings) {
            if (ring.strips == 0) continue;
            passed += ring.strips;
            const std::uint64_t due = missing * passed / capacity - given;
            ring.vertices += due / ring.strips;
            given += due / ring.strips * ring.strips;
        }
    return cuts;
}

Vec3d upright(const Vec3d& p) {
    return {p.x, p.z, -p.y};
}

struct Surface {
    std::vector<Vec3d> positions, normals;
    std::vector<mesh::Triangle> triangles;
};

void add_ring(Surface& surface, const Ring& ring, bool inside_out) {
    const double patches = static_cast<double>(ring.piece->size());
    for (std::uint64_t k = 0; k < ring.vertices; ++k) {
        const double around = patches * static_cast<double>(k) / static_cast<double>(ring.vertices);
        const auto patch = static_cast<std::size_t>(around);
        const SurfacePoint s = evaluate((*ring.piece)[patch], around - static_cast<double>(patch), ring.along);
        const Vec3d outward =
            ring.pole ? Vec3d{0, 0, ring.along > 0.5 ? -1 : 1} : cross(s.along, s.around) * (inside_out ? -1.0 : 1.0);
        surface.positions.push_back(upright(s.position));
        surface.normals.push_back(upright(normalize(outward)));
    }
}

// Walks around two rings at once and always closes the triangle whose next corner comes first.
void stitch(Surface& surface, const Ring& a, std::uint32_t a_start, const Ring& b, std::uint32_t b_start,
            bool inside_out) {
    const auto at = [](const Ring& ring, std::uint32_t start, std::uint64_t k) {
        return start + static_cast<std::uint32_t>(k % ring.vertices);
    };
    const std::uint64_t steps_a = a.pole ? 0 : a.vertices, steps_b = b.pole ? 0 : b.vertices;
    for (std::uint64_t i = 0, j = 0; i < steps_a || j < steps_b;) {
        const bool step_a = j == steps_b || (i < steps_a && (i + 1) * steps_b <= (j + 1) * steps_a);
        const std::uint32_t p = at(a, a_start, i), q = at(b, b_start, j);
        const std::uint32_t next = step_a ? at(a, a_start, ++i) : at(b, b_start, ++j);
        if (inside_out) {
            surface.triangles.push_back({p, next, q});
        } else {
            surface.triangles.push_back({p, q, next});
        }
    }
}

Surface tessellate(const std::vector<Tube>& tubes, const std::vector<Rings>& cuts) {
    Surface surface;
    for (std::size_t t = 0; t < tubes.size(); ++t) {
        std::uint32_t previous = 0;
        for (std::size_t i = 0; i < cuts[t].size(); ++i) {
            const auto start = static_cast<std::uint32_t>(surface.positions.size());
            add_ring(surface, cuts[t][i], tubes[t].inside_out);
            if (i > 0) stitch(surface, cuts[t][i - 1], previous, cuts[t][i], start, tubes[t].inside_out);
            previous = start;
        }
    }
    return surface;
}

mesh::Mesh two_metres_wide(const Surface& surface) {
    Box box;
    for (const Vec3d& p : surface.positions) box.add(p);
    const Vec3d center = box.center(), extent = box.extent();
    const double scale = 2.0 / std::max({extent.x, extent.y, extent.z});

    mesh::Mesh mesh;
    mesh.triangles = surface.triangles;
    for (const Vec3d& p : surface.positions) mesh.positions.emplace_back((p - center) * scale);
    for (const Vec3d& n : surface.normals) mesh.normals.emplace_back(n);
    return mesh;
}

}  // namespace

Result<mesh::Model> teapot(std::uint64_t triangles) {
    if (auto error = outside("teapot triangles", triangles, min_teapot_triangles, max_sample_triangles)) return *error;
    const std::vector<Tube> tubes = newell_tubes();

    mesh::Model model;
    model.mesh = two_metres_wide(tessellate(tubes, cut_all(tubes, triangles)));
    mesh::Material porcelain;
    porcelain.name = "porcelain";
    porcelain.base_color = {0.87f, 0.80f, 0.64f, 1.0f};
    porcelain.roughness = 0.3f;
    porcelain.double_sided = true;  // the surface is open at the rim and at the spout
    model.materials = {porcelain};
    return model;
}

}  // namespace lodestream::samples
