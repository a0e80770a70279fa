#include "server/samples/shape_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/mesh/operations.h"

namespace lodestream::samples {
namespace {

constexpr double least_area_m2 = 1e-7;  // below this, a triangle is one of a sheet's collapsed ends

Vec3d unit_or(const Vec3d& v, const Vec3d& otherwise) {
    const double size = length(v);
    return size > 1e-9 ? v / size : otherwise;
}

Vec3d middle(const std::vector<Vec3d>& row) {
    return std::accumulate(row.begin(), row.end(), Vec3d{0}) / static_cast<double>(row.size());
}

// Difference of the neighbours that are not the same point.
Vec3d slope(const Vec3d& before, const Vec3d& here, const Vec3d& after) {
    return length(after - before) > 1e-9 ? after - before : after - here;
}

}  // namespace

Frame turned_at(const Vec3d& origin, double yaw) {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {origin, {c, 0, -s}, {0, 1, 0}, {s, 0, c}};
}

Frame along(const Vec3d& from, const Vec3d& to) {
    const Vec3d y = normalize(to - from);
    const Vec3d x = normalize(cross(y, std::abs(y.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1}));
    return {from, x, y, cross(x, y)};
}

Frame moved(const Frame& frame, const Vec3d& local_offset) {
    Frame result = frame;
    result.origin = frame.point(local_offset);
    return result;
}

std::uint32_t ShapeBuilder::vertex(const Vec3d& position, const Vec3d& normal) {
    mesh_.positions.emplace_back(position);
    mesh_.normals.emplace_back(normal);
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
}

void ShapeBuilder::triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (mesh::face_area(mesh_.positions[a], mesh_.positions[b], mesh_.positions[c]) < least_area_m2) return;
    mesh_.triangles.push_back({a, b, c});
    mesh_.triangle_materials.push_back(material_);
    if (objects_ > 0) mesh_.triangle_objects.push_back(objects_ - 1);
}

void ShapeBuilder::flat_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d normal = unit_or(cross(b - a, c - a), {0, 1, 0});
    triangle(vertex(a, normal), vertex(b, normal), vertex(c, normal));
}

void ShapeBuilder::flat_quad(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    const Vec3d normal = unit_or(cross(c - a, d - b), {0, 1, 0});
    const std::uint32_t i = vertex(a, normal), j = vertex(b, normal), k = vertex(c, normal), l = vertex(d, normal);
    triangle(i, j, k);
    triangle(i, k, l);
}

void ShapeBuilder::box(const Frame& frame, const Vec3d& size) {
    const double x = size.x / 2, z = size.z / 2;
    const std::array<Vec2d, 2> left{{{-x, -z}, {x, -z}}}, right{{{-x, z}, {x, z}}};
    prism(moved(frame, {0, -size.y / 2, 0}), left, right, size.y);
}

void ShapeBuilder::prism(const Frame& frame, std::span<const Vec2d> left, std::span<const Vec2d> right, double height) {
    const auto low = [&](const Vec2d& p) { return frame.point({p.x, 0, p.y}); };
    const auto high = [&](const Vec2d& p) { return frame.point({p.x, height, p.y}); };
    std::vector<Vec2d> outline(right.begin(), right.end());
    outline.insert(outline.end(), left.rbegin(), left.rend());
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const Vec2d &p = outline[i], &q = outline[(i + 1) % outline.size()];
        flat_quad(low(p), low(q), high(q), high(p));
    }
    for (std::size_t i = 0; i + 1 < left.size(); ++i) {
        flat_quad(high(left[i]), high(right[i]), high(right[i + 1]), high(left[i + 1]));
        flat_quad(low(right[i]), low(left[i]), low(left[i + 1]), low(right[i + 1]));
    }
}

void ShapeBuilder::lathe(const Frame& frame, std::span<const Vec2d> profile, int sides) {
    sides *= roundness_;
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
        const Vec2d low = profile[i], high = profile[i + 1], edge = high - low;
        std::vector<std::uint32_t> ring;
        for (int k = 0; k < sides; ++k) {
            const double angle = 2 * pi * k / sides, c = std::cos(angle), s = std::sin(angle);
            const Vec3d normal = unit_or(frame.direction({edge.y * c, -edge.x, edge.y * s}), frame.y);
            ring.push_back(vertex(frame.point({low.x * c, low.y, low.x * s}), normal));
            ring.push_back(vertex(frame.point({high.x * c, high.y, high.x * s}), normal));
        }
        for (std::size_t k = 0; k < ring.size(); k += 2) {
            const std::size_t next = (k + 2) % ring.size();
            if (low.x > 0) triangle(ring[k], ring[k + 1], ring[next]);
            if (high.x > 0) triangle(ring[next], ring[k + 1], ring[next + 1]);
        }
    }
}

void ShapeBuilder::rod(const Vec3d& from, const Vec3d& to, double radius, int sides) {
    const double size = length(to - from);
    const std::array<Vec2d, 4> profile{{{0, 0}, {radius, 0}, {radius, size}, {0, size}}};
    lathe(along(from, to), profile, sides);
}

void ShapeBuilder::pipe(std::span<const Vec3d> path, double radius, int sides) {
    Frame frame = along(path[0], path[1]);
    std::vector<std::uint32_t> previous;
    for (std::size_t i = 0; i < path.size(); ++i) {
        const Vec3d in = i > 0 ? normalize(path[i] - path[i - 1]) : frame.y;
        const Vec3d out = i + 1 < path.size() ? normalize(path[i + 1] - path[i]) : in;
        frame.origin = path[i];
        frame.y = normalize(in + out);
        frame.x = normalize(frame.x - frame.y * dot(frame.x, frame.y));
        frame.z = cross(frame.x, frame.y);
        const std::vector<std::uint32_t> ring = ring_around(frame, radius, sides);
        for (std::size_t k = 0; k < previous.size(); ++k) {
            const std::size_t next = (k + 1) % ring.size();
            triangle(previous[k], ring[k], previous[next]);
            triangle(previous[next], ring[k], ring[next]);
        }
        if (i == 0 || i + 1 == path.size()) disc(ring, i == 0 ? -frame.y : frame.y);
        previous = ring;
    }
}

std::vector<std::uint32_t> ShapeBuilder::ring_around(const Frame& frame, double radius, int sides) {
    sides *= roundness_;
    std::vector<std::uint32_t> ring;
    for (int k = 0; k < sides; ++k) {
        const double angle = 2 * pi * k / sides;
        const Vec3d outward = frame.direction({std::cos(angle), 0, std::sin(angle)});
        ring.push_back(vertex(frame.origin + outward * radius, outward));
    }
    return ring;
}

// Closes a ring on the side that `normal` points to.
void ShapeBuilder::disc(const std::vector<std::uint32_t>& ring, const Vec3d& normal) {
    std::vector<std::uint32_t> rim;
    for (const std::uint32_t i : ring) rim.push_back(vertex(Vec3d(mesh_.positions[i]), normal));
    const Vec3f turn =
        cross(mesh_.positions[ring[1]] - mesh_.positions[ring[0]], mesh_.positions[ring[2]] - mesh_.positions[ring[0]]);
    if (dot(Vec3d(turn), normal) < 0) std::reverse(rim.begin(), rim.end());
    for (std::size_t k = 1; k + 1 < rim.size(); ++k) triangle(rim[0], rim[k], rim[k + 1]);
}

void ShapeBuilder::sheet(const std::vector<std::vector<Vec3d>>& rows) {
    const std::size_t n = rows.size(), m = rows.front().size();
    std::vector<std::uint32_t> index;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3d inside = middle(rows[i == 0 ? 1 : i - 1]);  // seen from a row that is a single point
        for (std::size_t j = 0; j < m; ++j) {
            const Vec3d& here = rows[i][j];
            const Vec3d across = slope(rows[i > 0 ? i - 1 : 0][j], here, rows[std::min(i + 1, n - 1)][j]);
            const Vec3d upward = slope(rows[i][j > 0 ? j - 1 : 0], here, rows[i][std::min(j + 1, m - 1)]);
            index.push_back(vertex(here, unit_or(cross(across, upward), unit_or(here - inside, {0, 1, 0}))));
        }
    }
    for (std::size_t i = 0; i + 1 < n; ++i)
        for (std::size_t j = 0; j + 1 < m; ++j) {
            const std::uint32_t a = index[i * m + j], b = index[i * m + j + 1], c = index[(i + 1) * m + j],
                                d = index[(i + 1) * m + j + 1];
            triangle(a, c, d);
            triangle(a, d, b);
        }
}

void ShapeBuilder::ladder(std::span<const Vec3d> a, std::span<const Vec3d> b) {
    for (std::size_t i = 0; i + 1 < a.size(); ++i) {
        flat_triangle(a[i], a[i + 1], b[i + 1]);
        flat_triangle(a[i], b[i + 1], b[i]);
    }
}

mesh::Mesh ShapeBuilder::take() {
    return mesh::compact(std::exchange(mesh_, {}));
}

}  // namespace lodestream::samples
