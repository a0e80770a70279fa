#include "common/metric/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "common/mesh/nearest.h"

namespace lodestream::metric {

namespace {

constexpr std::uint32_t triangles_in_leaf = 4;
constexpr std::size_t bins = 16;       // places to split at
constexpr std::size_t max_open = 640;  // three at each depth; 2^32 triangles are within 166 splits, an eighth each
constexpr float infinity = std::numeric_limits<float>::infinity();
// Rounding in float takes less than this from what a box is compared with.
constexpr float shrink = 1.0f - 1e-6f;
constexpr double grow = 1.0 + 1e-6;
// Of scaled lengths: more than rounding in float takes from a ray's way to a box.
constexpr float box_slack = 4e-6f;
constexpr double least_slope = 1e-12;       // of a ray along an axis, so that nothing is divided by zero
constexpr double smallest_squared = 1e-36;  // of scaled lengths: a float's squares are as exact down to there

double squared(const Vec3d& v) {
    return dot(v, v);
}

float saturated(double value) {
    constexpr double most = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp(value, -most, most));
}

Vec3f saturated(const Vec3d& v) {
    return {saturated(v.x), saturated(v.y), saturated(v.z)};
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

void TriangleTree::FloatBox::add(const FloatBox& other) {
    min = glm::min(min, other.min);
    max = glm::max(max, other.max);
}

double TriangleTree::FloatBox::area() const {
    const Vec3d extent = Vec3d(max) - Vec3d(min);
    return extent.x * extent.y + extent.y * extent.z + extent.z * extent.x;
}

void TriangleTree::Side::add(const Side& other) {
    if (other.count == 0) return;
    if (count > 0)
        box.add(other.box);
    else
        box = other.box;
    count += other.count;
}

TriangleTree::TriangleTree(const mesh::Mesh& mesh) {
    std::vector<Item> items(mesh.triangles.size());
    for (std::uint32_t t = 0; t < items.size(); ++t) {
        const Vec3f &a = mesh.positions[mesh.triangles[t][0]], &b = mesh.positions[mesh.triangles[t][1]],
                    &c = mesh.positions[mesh.triangles[t][2]];
        const FloatBox box{min(min(a, b), c), max(max(a, b), c)};
        items[t] = {box, 0.5f * box.min + 0.5f * box.max, t};
    }
    float largest = 0.0f;
    for (const Item& item : items)
        for (int axis = 0; axis < 3; ++axis)
            largest = std::max({largest, std::abs(item.box.min[axis]), std::abs(item.box.max[axis])});
    if (largest > 0.0f) scale_ = std::exp2(-std::ilogb(largest));
    if (!items.empty()) build(items);
    triangles_.reserve(items.size());
    order_.reserve(items.size());
    for (const Item& item : items) {
        order_.push_back(item.triangle);
        const mesh::Triangle& t = mesh.triangles[item.triangle];
        triangles_.push_back({mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
    }
}

// Splits what is largest in two until a node has all its children, top down.
void TriangleTree::build(std::vector<Item>& items) {
    std::vector<Range> ranges{{0, static_cast<std::uint32_t>(items.size())}};  // of each node
    for (std::size_t n = 0; n < ranges.size(); ++n) {
        std::array<Range, width> parts{ranges[n]};
        for (std::size_t k = 1; k < width; ++k) {
            Range& largest = *std::max_element(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(k),
                                               [](const Range& a, const Range& b) { return a.count < b.count; });
            if (largest.count <= triangles_in_leaf) break;
            const std::uint32_t left = split(std::span(items).subspan(largest.first, largest.count));
            parts[k] = {largest.first + left, largest.count - left};
            largest.count = left;
        }
        Node& node = nodes_.emplace_back();
        for (std::size_t k = 0; k < width && parts[k].count > 0; ++k) {
            set_box(node, k, box_of(std::span(items).subspan(parts[k].first, parts[k].count)));
            node.children[k] = parts[k];
            if (parts[k].count <= triangles_in_leaf) continue;
            node.children[k] = {static_cast<std::uint32_t>(ranges.size()), 0};
            ranges.push_back(parts[k]);
        }
    }
}

TriangleTree::FloatBox TriangleTree::box_of(std::span<const Item> items) {
    FloatBox box = items.front().box;
    for (const Item& item : items) box.add(item.box);
    return box;
}

// Orders the items along the longest axis of their centres so far that the first ones, whose number this returns, are
// one side. Of `bins` places to cut, takes the one at which both sides' surface areas times their items are least
// (Wald 2007, "On fast construction of SAH-based bounding volume hierarchies"); no side gets less than an eighth.
std::uint32_t TriangleTree::split(std::span<Item> items) {
    FloatBox centers{items.front().center, items.front().center};
    for (const Item& item : items) centers.add({item.center, item.center});
    const Vec3d extent = Vec3d(centers.max) - Vec3d(centers.min);
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;

    std::array<Side, bins> in_bin{};
    const double per_length = extent[axis] > 0.0 ? bins / extent[axis] : 0.0;
    for (const Item& item : items) {
        const double place = (double{item.center[axis]} - double{centers.min[axis]}) * per_length;
        in_bin[std::min(bins - 1, static_cast<std::size_t>(place))].add({item.box, 1});
    }
    std::array<Side, bins> from{};  // this bin and all above
    for (std::size_t k = bins; k-- > 0;) {
        if (k + 1 < bins) from[k] = from[k + 1];
        from[k].add(in_bin[k]);
    }
    const auto count = static_cast<std::uint32_t>(items.size()), least = (count + 7) / 8;
    std::uint32_t left = count / 2;
    double best = std::numeric_limits<double>::infinity();
    Side below;
    for (std::size_t k = 1; k < bins; ++k) {
        below.add(in_bin[k - 1]);
        const double cost = below.cost() + from[k].cost();
        if (std::min(below.count, from[k].count) < least || !(cost < best)) continue;
        best = cost;
        left = below.count;
    }
    std::nth_element(items.begin(), items.begin() + left, items.end(), [axis](const Item& a, const Item& b) {
        return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.triangle < b.triangle;
    });
    return left;
}

void TriangleTree::set_box(Node& node, std::size_t child, const FloatBox& box) const {
    for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(axis);
        node.min[k][child] = static_cast<float>(scale_ * box.min[axis]);
        node.max[k][child] = static_cast<float>(scale_ * box.max[axis]);
    }
}

struct TriangleTree::Query {
    Query(const Vec3d& at, double scale) : squared_scale(scale * scale) {
        const Vec3d scaled = scale * at;
        point = saturated(scaled);
        rounded = saturated(grow * abs(scaled - Vec3d(point)));
    }
    // What a box's squared distance must be below, for a triangle nearer than `squared` to be in it.
    float limit(double squared) const {
        const double scaled = squared * squared_scale;
        if (scaled < smallest_squared) return 0.0f;
        return scaled < std::numeric_limits<float>::max() ? static_cast<float>(scaled) / shrink : infinity;
    }

    double squared_scale;
    Vec3f point;
    Vec3f rounded;  // how far the point may be from that, along each axis
};

TriangleTree::Lanes TriangleTree::squared_distances(const Node& node, const Query& query) {
    Lanes sum{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(axis);
        const Lanes below = node.min[k] - query.point[axis], above = query.point[axis] - node.max[k];
        const Lanes outside = (below > above ? below : above) - query.rounded[axis];
        const Lanes away = outside > 0.0f ? outside : Lanes{};
        sum += away * away;
    }
    const Lanes most = Lanes{} + std::numeric_limits<float>::max();
    return sum < most ? sum : most;
}

TriangleTree::Hit TriangleTree::nearest(const Vec3d& point, double bound) const {
    Hit hit{bound, no_triangle};
    if (nodes_.empty()) return hit;
    const Query query(point, scale_);
    struct Open {
        float distance;
        Range range;  // as a node has its children
    };
    std::array<Open, max_open> open;
    std::size_t count = 0;
    open[count++] = {0.0f, {0, 0}};
    float limit = query.limit(bound);
    while (count > 0) {
        const auto [distance, range] = open[--count];
        if (!(distance < limit)) continue;
        for (std::uint32_t t = range.first; t < range.first + range.count; ++t) {
            const double squared = metric::squared_distance(triangles_[t], point);
            if (!(squared < hit.squared_distance)) continue;
            hit = {squared, t};
            limit = query.limit(squared);
        }
        if (range.count > 0) continue;
        const Node& node = nodes_[range.first];
        const Lanes distances = squared_distances(node, query);
        const std::size_t first = count;
        for (std::size_t k = 0; k < width; ++k) {
            const Range& child = node.children[k];
            const bool is_none = child.count == 0 && child.first == 0;
            if (is_none || !(distances[k] < limit)) continue;
            std::size_t place = count++;  // the nearest last
            for (; place > first && open[place - 1].distance < distances[k]; --place) open[place] = open[place - 1];
            open[place] = {distances[k], child};
        }
    }
    return hit;
}

// Distances are scaled as the boxes are.
struct TriangleTree::Ray {
    Ray(const Vec3d& from, const Vec3d& direction, double scale) : origin(saturated(scale * from)) {
        for (int axis = 0; axis < 3; ++axis) {
            const double slope = direction[axis];
            per_slope[axis] = static_cast<float>(1.0 / (std::abs(slope) < least_slope ? least_slope : slope));
        }
    }
    Vec3f origin, per_slope;
};

// Where the ray enters the boxes; infinity where it misses one or enters it beyond `to`.
TriangleTree::Lanes TriangleTree::entries(const Node& node, const Ray& ray, float to) {
    const Lanes never = Lanes{} + infinity;
    Lanes enter{}, leave = Lanes{} + to;
    for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(axis);
        const Lanes a = (node.min[k] - box_slack - ray.origin[axis]) * ray.per_slope[axis];
        const Lanes b = (node.max[k] + box_slack - ray.origin[axis]) * ray.per_slope[axis];
        const Lanes first = a < b ? a : b, last = a < b ? b : a;
        enter = first > enter ? first : enter;
        leave = last < leave ? last : leave;
    }
    return enter <= leave ? enter : never;
}

// Moller and Trumbore 1997, "Fast, minimum storage ray-triangle intersection".
TriangleTree::Crossing TriangleTree::first_along(const Vec3d& origin, const Vec3d& direction, double from,
                                                 double to) const {
    Crossing first{to, no_triangle, Vec3d(0.0)};
    if (nodes_.empty()) return first;
    const Ray ray(origin, direction, scale_);
    const auto meet = [&](std::uint32_t t) {
        const Vec3d corner(triangles_[t][0]), ab = Vec3d(triangles_[t][1]) - corner,
                                              ac = Vec3d(triangles_[t][2]) - corner, to_origin = origin - corner;
        const Vec3d p = cross(direction, ac), q = cross(to_origin, ab);
        const double volume = dot(ab, p);
        const double v = dot(to_origin, p) / volume, w = dot(direction, q) / volume, distance = dot(ac, q) / volume;
        if (v >= 0.0 && w >= 0.0 && v + w <= 1.0 && distance >= from && distance < first.distance)
            first = {distance, t, {1.0 - v - w, v, w}};
    };
    struct Open {
        float entry;
        Range range;
    };
    std::array<Open, max_open> open;
    std::size_t count = 0;
    open[count++] = {0.0f, {0, 0}};
    while (count > 0) {
        const auto [entry, range] = open[--count];
        const float limit = saturated(scale_ * first.distance * grow);
        if (entry > limit) continue;
        for (std::uint32_t t = range.first; t < range.first + range.count; ++t) meet(t);
        if (range.count > 0) continue;
        const Lanes entered = entries(nodes_[range.first], ray, limit);
        const std::size_t begin = count;
        for (std::size_t k = 0; k < width; ++k) {
            const Range& child = nodes_[range.first].children[k];
            if ((child.count == 0 && child.first == 0) || !(entered[k] < infinity)) continue;
            std::size_t place = count++;  // the first last
            for (; place > begin && open[place - 1].entry < entered[k]; --place) open[place] = open[place - 1];
            open[place] = {entered[k], child};
        }
    }
    return first;
}

SurfacePlace nearest_place(const TriangleTree& tree, const mesh::Mesh& mesh, const Vec3d& point) {
    const TriangleTree::Hit hit = tree.nearest(point, std::numeric_limits<double>::infinity());
    const mesh::Triangle& t = mesh.triangles[tree.order()[hit.triangle]];
    return {t, mesh::nearest_weights(point, Vec3d(mesh.positions[t[0]]), Vec3d(mesh.positions[t[1]]),
                                     Vec3d(mesh.positions[t[2]]))};
}

}  // namespace lodestream::metric
