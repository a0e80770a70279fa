#include "common/codec/rounding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/mesh/operations.h"

namespace lodestream::codec {
namespace {

// What a step along the surface counts beside one off it.
constexpr double sliding_weight = 0.005;

}  // namespace

double nearest_step(double value, double origin, double range, int bits) {
    return std::floor((value - origin) * ((std::ldexp(1.0, bits) - 1.0) / range) + 0.5);
}

Vec3d nearest_grid_point(const Vec3f& position, const QuantizationGrid& grid) {
    Vec3d point;
    for (int axis = 0; axis < 3; ++axis)
        point[axis] = nearest_step(position[axis], grid.origin[axis], grid.range, grid.bits);
    return point;
}

// The sum of weight * n nT, its upper triangle: a displacement d is off the planes by sqrt(dT A d / weight).
class SurfaceRounding::Planes {
  public:
    void add(const Vec3d& n, double weight) {
        xx_ += weight * n.x * n.x;
        xy_ += weight * n.x * n.y;
        xz_ += weight * n.x * n.z;
        yy_ += weight * n.y * n.y;
        yz_ += weight * n.y * n.z;
        zz_ += weight * n.z * n.z;
        weight_ += weight;
    }
    double weight() const { return weight_; }
    double off(const Vec3d& d) const {
        return d.x * d.x * xx_ + d.y * d.y * yy_ + d.z * d.z * zz_ +
               2 * (d.x * d.y * xy_ + d.x * d.z * xz_ + d.y * d.z * yz_);
    }

  private:
    double xx_ = 0, xy_ = 0, xz_ = 0, yy_ = 0, yz_ = 0, zz_ = 0;
    double weight_ = 0;
};

SurfaceRounding::~SurfaceRounding() = default;

SurfaceRounding::SurfaceRounding(const std::vector<Vec3f>& positions, const std::vector<mesh::Triangle>& triangles)
    : positions_(positions),
      triangles_(triangles),
      first_(mesh::weld_positions(positions)),
      planes_(positions.size()),
      held_(positions.size(), 0) {
    double largest = 0.0;  // areas count as shares of it, so that none is too large or too small
    const auto cross_product = [&](const mesh::Triangle& t) {
        const Vec3d a(positions[t[0]]);
        return cross(Vec3d(positions[t[1]]) - a, Vec3d(positions[t[2]]) - a);
    };
    for (const mesh::Triangle& t : triangles) largest = std::max(largest, length(cross_product(t)));
    for (const mesh::Triangle& t : triangles) {
        const Vec3d normal = cross_product(t);
        const double size = length(normal);
        if (!(size > 0.0) || !std::isfinite(largest)) continue;
        for (const std::uint32_t v : t) planes_[first_[v]].add(normal / size, size / largest);
    }
    hold_borders();
}

// Both ends of every edge that two triangles do not share, running along it in opposite directions.
void SurfaceRounding::hold_borders() {
    struct Edge {
        std::uint64_t ends;  // the lower one first
        bool rises;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * triangles_.size());
    for (const mesh::Triangle& t : triangles_)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint64_t a = first_[t[k]], b = first_[t[(k + 1) % 3]];
            edges.push_back({std::min(a, b) << 32 | std::max(a, b), a < b});
        }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.ends < b.ends; });
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        while (end < edges.size() && edges[end].ends == edges[begin].ends) ++end;
        if (end - begin == 2 && edges[begin].rises != edges[begin + 1].rises) continue;
        held_[edges[begin].ends >> 32] = held_[edges[begin].ends & 0xffffffffu] = 1;
    }
}

Vec3d SurfaceRounding::best(std::uint32_t v, const QuantizationGrid& grid) const {
    const Vec3d middle = nearest_grid_point(positions_[v], grid);
    const Planes& planes = planes_[v];
    if (held_[v] || !(planes.weight() > 0.0)) return middle;
    const Vec3d from = (Vec3d(positions_[v]) - Vec3d(grid.origin)) / grid.step();
    const double last = std::ldexp(1.0, grid.bits) - 1.0;
    Vec3d best = middle;
    double least = std::numeric_limits<double>::infinity();
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z) {
                const Vec3d to = middle + Vec3d(x, y, z);
                if (std::min({to.x, to.y, to.z}) < 0.0 || std::max({to.x, to.y, to.z}) > last) continue;
                const Vec3d moved = to - from;
                const double cost = planes.off(moved) + sliding_weight * planes.weight() * dot(moved, moved);
                if (cost < least) {
                    least = cost;
                    best = to;
                }
            }
    return best;
}

Rounded SurfaceRounding::round(const QuantizationGrid& grid) const {
    Rounded result;
    std::vector<Vec3d>& points = result.points;
    points.reserve(positions_.size());
    for (std::uint32_t v = 0; v < positions_.size(); ++v)
        points.push_back(first_[v] < v ? points[first_[v]] : best(v, grid));
    undo_folds(grid, points);

    double squares = 0.0, weight = 0.0;
    for (std::uint32_t v = 0; v < positions_.size(); ++v) {
        points[v] = points[first_[v]];
        if (first_[v] < v || !(planes_[v].weight() > 0.0)) continue;
        squares += planes_[v].off(points[v] - (Vec3d(positions_[v]) - Vec3d(grid.origin)) / grid.step());
        weight += planes_[v].weight();
    }
    result.off_surface_rms = weight > 0.0 ? grid.step() * std::sqrt(std::max(0.0, squares) / weight) : 0.0;
    return result;
}

// Triangles that would face the other way put their corners back, until none is left that this could help.
void SurfaceRounding::undo_folds(const QuantizationGrid& grid, std::vector<Vec3d>& points) const {
    for (bool moved = true; moved;) {
        moved = false;
        for (const mesh::Triangle& t : triangles_) {
            const auto cross_product = [&](const auto& at) { return cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0])); };
            const Vec3d before = cross_product([&](std::uint32_t v) { return Vec3d(positions_[v]); });
            const Vec3d after = cross_product([&](std::uint32_t v) { return points[first_[v]]; });
            if (dot(before, after) > 0.0) continue;
            for (const std::uint32_t v : t) {
                const Vec3d nearest = nearest_grid_point(positions_[v], grid);
                moved = moved || length(points[first_[v]] - nearest) > 0.0;
                points[first_[v]] = nearest;
            }
        }
    }
}

}  // namespace lodestream::codec
