#include "common/scene/surroundings.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

#include "common/mesh/operations.h"
#include "common/metric/triangle_tree.h"

namespace lodestream::scene {

namespace {

constexpr double samples_per_cell = 3.0;  // along a side: no way through a surface
constexpr std::uint32_t no_vertex = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t max_halvings = 4 * 32;  // of one triangle; more than the least cell needs

struct Corner {
    Vec3d place;
    mesh::Outside::Cell cell;
};
using Corners = std::array<Corner, 3>;

double longest_side(const Box& box) {
    const Vec3d extent = box.extent();
    return std::max({extent.x, extent.y, extent.z});
}

double squared(const Vec3d& v) {
    return dot(v, v);
}

double size_of_cells(const Box& box, std::uint32_t cells) {
    const double longest = longest_side(box);
    return longest > 0.0 ? longest / std::clamp(cells, min_cells, max_cells) : 1.0;
}

// Whether nothing between the corners is in another cell: they are in one, or in two beside each other.
bool only_in_their_cells(const Corners& t) {
    std::uint32_t steps = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [low, high] = std::minmax({t[0].cell[axis], t[1].cell[axis], t[2].cell[axis]});
        steps += high - low;
    }
    return steps <= 1;
}

// Halves the longest side until none is longer than `spacing` or a part cannot meet more cells; `visit` is given the
// cell of each corner of all parts once, but for those that parts share across a side, and ends it by returning true,
// which this returns too.
template <class Visit>
bool any_cell(const mesh::Outside& cells, const std::array<Vec3d, 3>& triangle, double spacing,
              std::vector<Corners>& open, Visit visit) {
    Corners whole{};
    for (std::size_t k = 0; k < 3; ++k) {
        whole[k] = {triangle[k], cells.cell_of(triangle[k])};
        if (visit(whole[k].cell)) return true;
    }
    open.assign(1, whole);
    while (!open.empty()) {
        const Corners t = open.back();
        open.pop_back();
        if (only_in_their_cells(t)) continue;
        const std::array<double, 3> sides{squared(t[1].place - t[0].place), squared(t[2].place - t[1].place),
                                          squared(t[0].place - t[2].place)};
        const auto longest = static_cast<std::size_t>(std::max_element(sides.begin(), sides.end()) - sides.begin());
        if (!(sides[longest] > spacing * spacing) || open.size() > max_halvings) continue;
        const Corner &a = t[longest], &b = t[(longest + 1) % 3], &c = t[(longest + 2) % 3];
        const Vec3d half = 0.5 * (a.place + b.place);
        const Corner middle{half, cells.cell_of(half)};
        if (visit(middle.cell)) return true;
        open.push_back({a, middle, c});
        open.push_back({middle, b, c});
    }
    return false;
}

Vec3f blend(const std::vector<Vec3f>& values, const mesh::Triangle& t, const Vec3d& w) {
    return Vec3f(w.x * Vec3d(values[t[0]]) + w.y * Vec3d(values[t[1]]) + w.z * Vec3d(values[t[2]]));
}

Rgba8 blend(const std::vector<Rgba8>& values, const mesh::Triangle& t, const Vec3d& w) {
    return Rgba8(w.x * Vec4d(values[t[0]]) + w.y * Vec4d(values[t[1]]) + w.z * Vec4d(values[t[2]]) + 0.5);
}

Vec3f facing(const Vec3f& normal, const Vec3d& outwards) {
    const Vec3d wide(normal);
    const double size = glm::length(wide);
    if (!(size > 0.0)) return Vec3f(outwards / glm::length(outwards));
    return Vec3f(dot(wide, outwards) < 0.0 ? -wide / size : wide / size);
}

}  // namespace

Surroundings::Surroundings(const mesh::Mesh& mesh, std::uint32_t cells)
    : Surroundings(mesh, mesh::bounds(mesh), cells) {}

Surroundings::Surroundings(const mesh::Mesh& mesh, const Box& box, std::uint32_t cells)
    : mesh_(mesh), low_(box.min), cell_size_(size_of_cells(box, cells)), outside_(box.extent(), cell_size_) {
    assert(!mesh.triangles.empty());
    const double spacing = cell_size_ / samples_per_cell;
    std::vector<Corners> open;
    const auto any_cell_of = [&](const mesh::Triangle& t, const auto& visit) {
        return any_cell(outside_,
                        {place(mesh.positions[t[0]]), place(mesh.positions[t[1]]), place(mesh.positions[t[2]])},
                        spacing, open, visit);
    };
    for (const mesh::Triangle& t : mesh.triangles)
        any_cell_of(t, [&](const mesh::Outside::Cell& cell) {
            outside_.mark(cell);
            return false;
        });
    outside_.flood();
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        if (any_cell_of(mesh.triangles[t], [&](const mesh::Outside::Cell& cell) { return outside_.reaches(cell); }))
            visible_.push_back(t);
}

// Of each cell that is not outside, the sides towards one that is.
template <class Visit>
void Surroundings::for_each_face(Visit visit) const {
    const mesh::Outside::Cell& size = outside_.size();
    for (std::uint32_t z = 1; z + 1 < size[2]; ++z)
        for (std::uint32_t y = 1; y + 1 < size[1]; ++y)
            for (std::uint32_t x = 1; x + 1 < size[0]; ++x) {
                const mesh::Outside::Cell cell{x, y, z};
                if (outside_.is_outside(cell)) continue;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    for (const bool up : {false, true}) {
                        mesh::Outside::Cell beside = cell;
                        beside[axis] += up ? 1 : -1u;
                        if (outside_.is_outside(beside)) visit(cell, axis, up);
                    }
            }
}

std::uint64_t Surroundings::faces() const {
    std::uint64_t count = 0;
    for_each_face([&](const mesh::Outside::Cell&, std::size_t, bool) { ++count; });
    return count;
}

mesh::Mesh Surroundings::wrapped() const {
    const mesh::Outside::Cell& size = outside_.size();
    std::vector<std::uint32_t> vertices(std::size_t{size[0]} * size[1] * size[2], no_vertex);
    std::vector<mesh::Outside::Cell> corners;  // of each vertex
    std::vector<Vec3d> outwards;               // likewise
    std::vector<std::array<std::uint32_t, 4>> quads;
    for_each_face([&](const mesh::Outside::Cell& cell, std::size_t axis, bool up) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        std::array<std::uint32_t, 4> quad{};
        for (std::size_t k = 0; k < 4; ++k) {
            mesh::Outside::Cell corner{cell[0] - 1, cell[1] - 1, cell[2] - 1};
            corner[axis] += up ? 1 : 0;
            corner[u] += k == 1 || k == 2 ? 1 : 0;
            corner[v] += k >= 2 ? 1 : 0;
            std::uint32_t& vertex = vertices[(std::size_t{corner[2]} * size[1] + corner[1]) * size[0] + corner[0]];
            if (vertex == no_vertex) {
                vertex = static_cast<std::uint32_t>(corners.size());
                corners.push_back(corner);
                outwards.emplace_back(0.0);
            }
            outwards[vertex][static_cast<int>(axis)] += up ? 1.0 : -1.0;
            quad[k] = vertex;
        }
        if (!up) std::swap(quad[1], quad[3]);
        quads.push_back(quad);
    });

    const mesh::Mesh seen = mesh::part(mesh_, visible_);
    const metric::TriangleTree tree(seen);
    mesh::Mesh out;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3d point = low_ + Vec3d(corners[i][0], corners[i][1], corners[i][2]) * cell_size_;
        const auto [t, w] = metric::nearest_place(tree, seen, point);
        out.positions.push_back(blend(seen.positions, t, w));
        // At an edge of the grid's where two outsides meet, the faces' directions may cancel out.
        const Vec3d away = outwards[i] == Vec3d(0.0) ? Vec3d(0.0, 1.0, 0.0) : outwards[i];
        if (!seen.normals.empty()) out.normals.push_back(facing(blend(seen.normals, t, w), away));
        if (!seen.colors.empty()) out.colors.push_back(blend(seen.colors, t, w));
    }
    for (const auto& [a, b, c, d] : quads) {
        const auto& p = out.positions;
        if (distance(p[a], p[c]) <= distance(p[b], p[d])) {
            out.triangles.push_back({a, b, c});
            out.triangles.push_back({a, c, d});
        } else {
            out.triangles.push_back({a, b, d});
            out.triangles.push_back({b, c, d});
        }
    }
    return mesh::compact(out);
}

}  // namespace lodestream::scene
