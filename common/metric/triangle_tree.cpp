#include "common/metric/triangle_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "common/mesh/nearest.h"

namespace lodestream::metric {

namespace {

constexpr std::uint32_t triangles_in_leaf = 4;
constexpr std::size_t max_depth = 64;  // halving 2^32 triangles needs half of it

double squared(const Vec3d& v) {
    return dot(v, v);
}

// From the origin to the segment a + t * ab.
double squared_distance_to_segment(const Vec3d& a, const Vec3d& ab) {
    const double span = squared(ab);
    const double t = span > 0 ? std::clamp(-dot(a, ab) / span, 0.0, 1.0) : 0.0;
    return squared(a + t * ab);
}

}  // namespace

// Barycentric regions as in Ericson, Real-Time Collision Detection, 5.1.5; every answer is that of a point on the
// triangle.
double squared_distance(const TriangleTree::Corners& triangle, const Vec3d& point) {
    const Vec3d a = Vec3d(triangle[0]) - point, b = Vec3d(triangle[1]) - point, c = Vec3d(triangle[2]) - point;
    const Vec3d ab = b - a, ac = c - a;
    const double d1 = -dot(ab, a), d2 = -dot(ac, a);
    if (d1 <= 0 && d2 <= 0) return squared(a);
    const double d3 = -dot(ab, b), d4 = -dot(ac, b);
    if (d3 >= 0 && d4 <= d3) return squared(b);
    const double d5 = -dot(ab, c), d6 = -dot(ac, c);
    if (d6 >= 0 && d5 <= d6) return squared(c);

    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (va > 0 && vb > 0 && vc > 0) {
        const double sum = va + vb + vc;
        return squared(a + (vb / sum) * ab + (vc / sum) * ac);
    }
    return std::min({squared_distance_to_segment(a, ab), squared_distance_to_segment(a, ac),
                     squared_distance_to_segment(b, c - b)});
}

TriangleTree::TriangleTree(const mesh::Mesh& mesh) {
    std::vector<Item> items(mesh.triangles.size());
    for (std::uint32_t t = 0; t < items.size(); ++t) {
        const Vec3f &a = mesh.positions[mesh.triangles[t][0]], &b = mesh.positions[mesh.triangles[t][1]],
                    &c = mesh.positions[mesh.triangles[t][2]];
        const FloatBox box{min(min(a, b), c), max(max(a, b), c)};
        items[t] = {box, 0.5f * box.min + 0.5f * box.max, t};
    }
    if (!items.empty()) build(items);
    triangles_.reserve(items.size());
    order_.reserve(items.size());
    for (const Item& item : items) {
        order_.push_back(item.triangle);
        const mesh::Triangle& t = mesh.triangles[item.triangle];
        triangles_.push_back({mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
    }
}

// Halves the triangles along the longest axis of their centres, top down.
void TriangleTree::build(std::vector<Item>& items) {
    nodes_.reserve(items.size() / 2 + 2);
    nodes_.push_back({{}, 0, static_cast<std::uint32_t>(items.size())});
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
        const std::uint32_t first = nodes_[n].first, count = nodes_[n].count;
        Item *begin = items.data() + first, *end = begin + count;
        FloatBox box = begin->box, centers{begin->center, begin->center};
        for (const Item* i = begin; i != end; ++i) {
            box = {min(box.min, i->box.min), max(box.max, i->box.max)};
            centers = {min(centers.min, i->center), max(centers.max, i->center)};
        }
        nodes_[n].box = box;
        if (count <= triangles_in_leaf) continue;

        const Vec3d extent = Vec3d(centers.max) - Vec3d(centers.min);
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const std::uint32_t half = count / 2;
        std::nth_element(begin, begin + half, end, [axis](const Item& a, const Item& b) {
            return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.triangle < b.triangle;
        });
        nodes_[n].first = static_cast<std::uint32_t>(nodes_.size());
        nodes_[n].count = 0;
        nodes_.push_back({{}, first, half});
        nodes_.push_back({{}, first + half, count - half});
    }
}

double TriangleTree::squared_distance(const FloatBox& box, const Vec3d& point) {
    const Vec3d outside = max(max(Vec3d(box.min) - point, point - Vec3d(box.max)), Vec3d{0.0});
    return squared(outside);
}

TriangleTree::Hit TriangleTree::nearest(const Vec3d& point, double bound) const {
    Hit hit{bound, no_triangle};
    if (nodes_.empty()) return hit;
    struct Open {
        std::uint32_t node;
        double distance;
    };
    std::array<Open, max_depth> open;
    std::size_t depth = 0;
    open[depth++] = {0, squared_distance(nodes_[0].box, point)};
    while (depth > 0) {
        const Open next = open[--depth];
        if (next.distance >= hit.squared_distance) continue;
        const Node& node = nodes_[next.node];
        if (node.count > 0) {
            for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
                const double distance = metric::squared_distance(triangles_[t], point);
                if (distance < hit.squared_distance) hit = {distance, t};
            }
            continue;
        }
        Open near{node.first, squared_distance(nodes_[node.first].box, point)};
        Open far{node.first + 1, squared_distance(nodes_[node.first + 1].box, point)};
        if (far.distance < near.distance) std::swap(near, far);
        if (far.distance < hit.squared_distance) open[depth++] = far;
        if (near.distance < hit.squared_distance) open[depth++] = near;
    }
    return hit;
}

SurfacePlace nearest_place(const TriangleTree& tree, const mesh::Mesh& mesh, const Vec3d& point) {
    const TriangleTree::Hit hit = tree.nearest(point, std::numeric_limits<double>::infinity());
    const mesh::Triangle& t = mesh.triangles[tree.order()[hit.triangle]];
    return {t, mesh::nearest_weights(point, Vec3d(mesh.positions[t[0]]), Vec3d(mesh.positions[t[1]]),
                                     Vec3d(mesh.positions[t[2]]))};
}

}  // namespace lodestream::metric
