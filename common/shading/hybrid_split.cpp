#include "common/shading/hybrid_split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <span>
#include <tuple>
#include <utility>

#include "common/mesh/operations.h"
#include "common/shading/numbers.h"

namespace lodestream::shading {
namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

// What a region gains by lying wholly among those already taken, in shares of the paper's order. At this price 16
// regions of a mesh of 5,000 triangles and more kept a half-flat level below the all-Gouraud one on every model tried;
// free borders did so on five of seven.
constexpr double border_price = 1.0;
constexpr int max_smoothing_passes = 16;

Vec3d centroid(const mesh::Mesh& mesh, const mesh::Triangle& triangle) {
    Vec3d sum(0.0);
    for (const std::uint32_t v : triangle) sum += Vec3d(mesh.positions[v]) / 3.0;
    return all_finite(sum) ? sum : Vec3d(0.0);
}

// Triangles that share an edge between positions. Where more than two share one they form a chain.
class DualGraph {
  public:
    explicit DualGraph(const mesh::Mesh& mesh) : first_(mesh.triangles.size() + 1, 0) {
        const std::vector<std::pair<std::uint32_t, std::uint32_t>> links = links_of(mesh);
        for (const auto& [a, b] : links) {
            ++first_[a + 1];
            ++first_[b + 1];
        }
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        neighbours_.resize(first_.back());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for (const auto& [a, b] : links) {
            neighbours_[next[a]++] = b;
            neighbours_[next[b]++] = a;
        }
    }

    std::span<const std::uint32_t> of(std::uint32_t triangle) const {
        return std::span(neighbours_).subspan(first_[triangle], first_[triangle + 1] - first_[triangle]);
    }

  private:
    static std::vector<std::pair<std::uint32_t, std::uint32_t>> links_of(const mesh::Mesh& mesh) {
        const std::vector<std::uint32_t> position = mesh::weld_positions(mesh.positions);
        struct Edge {
            std::uint32_t low, high, triangle;
        };
        std::vector<Edge> edges;
        edges.reserve(mesh.triangles.size() * 3);
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            for (int i = 0; i < 3; ++i) {
                const std::uint32_t a = position[mesh.triangles[t][i]], b = position[mesh.triangles[t][(i + 1) % 3]];
                if (a != b) edges.push_back({std::min(a, b), std::max(a, b), t});
            }
        std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
            return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
        });
        std::vector<std::pair<std::uint32_t, std::uint32_t>> links;
        for (std::size_t i = 1; i < edges.size(); ++i) {
            const Edge &a = edges[i - 1], &b = edges[i];
            if (a.low == b.low && a.high == b.high && a.triangle != b.triangle)
                links.emplace_back(a.triangle, b.triangle);
        }
        return links;
    }

    std::vector<std::uint32_t> first_;
    std::vector<std::uint32_t> neighbours_;
};

// The connected pieces of the mesh: a number a triangle, in the order of their lowest triangle.
std::vector<std::uint32_t> components_of(const DualGraph& dual, std::uint32_t triangles) {
    std::vector<std::uint32_t> component(triangles, none);
    std::vector<std::uint32_t> open;
    std::uint32_t count = 0;
    for (std::uint32_t start = 0; start < triangles; ++start) {
        if (component[start] != none) continue;
        component[start] = count;
        open.push_back(start);
        while (!open.empty()) {
            const std::uint32_t t = open.back();
            open.pop_back();
            for (const std::uint32_t neighbour : dual.of(t))
                if (component[neighbour] == none) {
                    component[neighbour] = count;
                    open.push_back(neighbour);
                }
        }
        ++count;
    }
    return component;
}

// Places on a curve through the box of `points` that keeps neighbours together (Morton order).
std::vector<std::uint64_t> curve_places(const std::vector<Vec3d>& points) {
    Box box;
    for (const Vec3d& p : points) box.add(p);
    const Vec3d extent = box.extent();
    const double largest = std::max({extent.x, extent.y, extent.z});
    const auto spread = [](std::uint64_t x) {
        x = (x | x << 32) & 0x1f00000000ffffull;
        x = (x | x << 16) & 0x1f0000ff0000ffull;
        x = (x | x << 8) & 0x100f00f00f00f00full;
        x = (x | x << 4) & 0x10c30c30c30c30c3ull;
        return (x | x << 2) & 0x1249249249249249ull;
    };
    std::vector<std::uint64_t> places;
    for (const Vec3d& p : points) {
        std::uint64_t place = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double share = largest > 0.0 ? (p[axis] - box.min[axis]) / largest : 0.0;
            place |= spread(static_cast<std::uint64_t>(std::clamp(share, 0.0, 1.0) * 2097151.0)) << axis;
        }
        places.push_back(place);
    }
    return places;
}

// Grows a region around each seed, nearest triangle first, so that borders are short and every region is connected.
std::vector<std::uint32_t> grow_regions(const DualGraph& dual, const std::vector<Vec3d>& centers,
                                        const std::vector<std::uint32_t>& seeds) {
    struct Step {
        double distance;
        std::uint32_t triangle, region;
        bool operator>(const Step& other) const {
            return std::tie(distance, triangle, region) > std::tie(other.distance, other.triangle, other.region);
        }
    };
    std::priority_queue<Step, std::vector<Step>, std::greater<>> queue;
    std::vector<std::uint32_t> region(centers.size(), none);
    for (std::uint32_t r = 0; r < seeds.size(); ++r) queue.push({0.0, seeds[r], r});
    while (!queue.empty()) {
        const Step step = queue.top();
        queue.pop();
        if (region[step.triangle] != none) continue;
        region[step.triangle] = step.region;
        for (const std::uint32_t neighbour : dual.of(step.triangle))
            if (region[neighbour] == none)
                queue.push({glm::distance(centers[neighbour], centers[seeds[step.region]]), neighbour, step.region});
    }
    return region;
}

// A seed for every connected piece, and more in proportion for those larger than a region, spread evenly over them.
std::vector<std::uint32_t> choose_seeds(const DualGraph& dual, const std::vector<Vec3d>& centers,
                                        std::uint32_t regions) {
    const std::uint64_t triangles = centers.size();
    const std::vector<std::uint32_t> component = components_of(dual, static_cast<std::uint32_t>(triangles));
    const std::vector<std::uint64_t> places = curve_places(centers);
    std::vector<std::uint32_t> along(triangles);
    std::iota(along.begin(), along.end(), 0u);
    std::sort(along.begin(), along.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tie(component[a], places[a], a) < std::tie(component[b], places[b], b);
    });
    std::vector<std::uint32_t> seeds;
    for (std::uint64_t begin = 0, end = 0; begin < triangles; begin = end) {
        while (end < triangles && component[along[end]] == component[along[begin]]) ++end;
        const std::uint64_t size = end - begin;
        const std::uint64_t pieces = std::clamp<std::uint64_t>(size * regions / triangles, 1, size);
        for (std::uint64_t i = 0; i < pieces; ++i) seeds.push_back(along[begin + size * (2 * i + 1) / (2 * pieces)]);
    }
    return seeds;
}

struct Region {
    std::vector<std::uint32_t> triangles;
    double mean_rank = 0.0;                                           // in the paper's order, as a share of all
    std::vector<std::pair<std::uint32_t, std::uint32_t>> neighbours;  // region, edges shared with it
    std::uint32_t border = 0;                                         // edges shared with all of them
};

std::vector<Region> describe_regions(const DualGraph& dual, const std::vector<std::uint32_t>& region_of,
                                     std::size_t count, const std::vector<std::uint32_t>& order) {
    std::vector<Region> regions(count);
    for (std::uint32_t i = 0; i < order.size(); ++i)
        regions[region_of[order[i]]].mean_rank += static_cast<double>(i) / static_cast<double>(order.size());
    std::vector<std::pair<std::uint32_t, std::uint32_t>> crossings;
    for (std::uint32_t t = 0; t < region_of.size(); ++t) {
        regions[region_of[t]].triangles.push_back(t);
        for (const std::uint32_t neighbour : dual.of(t))
            if (region_of[neighbour] != region_of[t]) crossings.emplace_back(region_of[t], region_of[neighbour]);
    }
    std::sort(crossings.begin(), crossings.end());
    for (const auto& [from, to] : crossings) {
        Region& region = regions[from];
        if (region.neighbours.empty() || region.neighbours.back().first != to) region.neighbours.emplace_back(to, 0);
        ++region.neighbours.back().second;
        ++region.border;
    }
    for (Region& region : regions) region.mean_rank /= static_cast<double>(region.triangles.size());
    return regions;
}

// Labels whole regions while they fit into `wanted`. Returns the first that does not fit, or none, and what is left for
// it.
std::uint32_t take_regions(const std::vector<Region>& regions, std::uint32_t& wanted,
                           std::vector<std::uint8_t>& labels) {
    std::vector<std::uint8_t> taken(regions.size(), 0);
    std::vector<std::uint32_t> shared(regions.size(), 0);  // edges with regions already taken
    const auto cost = [&](std::uint32_t r) {
        const double enclosed = regions[r].border > 0 ? static_cast<double>(shared[r]) / regions[r].border : 1.0;
        return regions[r].mean_rank - border_price * enclosed;
    };
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (std::uint32_t r = 0; r < regions.size(); ++r) queue.emplace(cost(r), r);
    while (wanted > 0 && !queue.empty()) {
        const std::uint32_t r = queue.top().second;
        queue.pop();
        if (taken[r]) continue;
        if (regions[r].triangles.size() > wanted) return r;
        taken[r] = 1;
        wanted -= static_cast<std::uint32_t>(regions[r].triangles.size());
        for (const std::uint32_t t : regions[r].triangles) labels[t] = 1;
        for (const auto& [neighbour, edges] : regions[r].neighbours) {
            shared[neighbour] += edges;
            if (!taken[neighbour]) queue.emplace(cost(neighbour), neighbour);
        }
    }
    return none;
}

std::uint64_t border_edges(const DualGraph& dual, const std::vector<std::uint32_t>& triangles,
                           const std::vector<std::uint8_t>& labels) {
    std::uint64_t edges = 0;
    for (const std::uint32_t t : triangles)
        for (const std::uint32_t neighbour : dual.of(t)) edges += labels[neighbour] != labels[t] ? 1 : 0;
    return edges;
}

// Labels exactly `wanted` triangles of a region: those on one side of a plane, the one that gives the shortest border.
void cut_region(const DualGraph& dual, const std::vector<Vec3d>& centers, std::vector<std::uint32_t> triangles,
                std::uint32_t wanted, std::vector<std::uint8_t>& labels) {
    const auto cut_along = [&](int direction) {
        const Vec3d axis(direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1);
        std::nth_element(triangles.begin(), triangles.begin() + wanted, triangles.end(),
                         [&](std::uint32_t a, std::uint32_t b) {
                             return std::pair(glm::dot(axis, centers[a]), a) < std::pair(glm::dot(axis, centers[b]), b);
                         });
        for (std::uint32_t i = 0; i < triangles.size(); ++i) labels[triangles[i]] = i < wanted ? 1 : 0;
    };
    int best = 0;
    std::uint64_t shortest = std::numeric_limits<std::uint64_t>::max();
    for (int direction = 0; direction < 27; ++direction) {
        if (direction == 13) continue;  // the axis of length zero
        cut_along(direction);
        const std::uint64_t edges = border_edges(dual, triangles, labels);
        if (edges >= shortest) continue;
        shortest = edges;
        best = direction;
    }
    cut_along(best);
}

// By how many edges the border gets shorter when `triangle` changes sides.
int gain(const DualGraph& dual, const std::vector<std::uint8_t>& labels, std::uint32_t triangle) {
    int edges = 0;
    for (const std::uint32_t neighbour : dual.of(triangle)) edges += labels[neighbour] != labels[triangle] ? 1 : -1;
    return edges;
}

// Exchanges triangles of the two sides, one for one, while that shortens the border.
bool smooth_border_once(const DualGraph& dual, std::vector<std::uint8_t>& labels) {
    std::array<std::vector<std::uint32_t>, 2> candidates;
    for (std::uint32_t t = 0; t < labels.size(); ++t)
        if (gain(dual, labels, t) > 0) candidates[labels[t]].push_back(t);
    bool changed = false;
    auto flat = candidates[0].begin(), gouraud = candidates[1].begin();
    while (flat != candidates[0].end() && gouraud != candidates[1].end()) {
        if (gain(dual, labels, *flat) <= 0) {
            ++flat;
            continue;
        }
        labels[*flat] = 1;
        if (gain(dual, labels, *gouraud) > 0) {
            labels[*gouraud] = 0;
            ++flat;
            changed = true;
        } else {
            labels[*flat] = 0;
        }
        ++gouraud;
    }
    return changed;
}

std::vector<std::uint8_t> split_by_regions(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& order,
                                           std::uint32_t wanted, std::uint32_t count) {
    const DualGraph dual(mesh);
    std::vector<Vec3d> centers;
    for (const mesh::Triangle& t : mesh.triangles) centers.push_back(centroid(mesh, t));
    const std::vector<std::uint32_t> seeds = choose_seeds(dual, centers, count);
    const std::vector<Region> regions = describe_regions(dual, grow_regions(dual, centers, seeds), seeds.size(), order);
    std::vector<std::uint8_t> labels(order.size(), 0);
    const std::uint32_t last = take_regions(regions, wanted, labels);
    if (last != none) cut_region(dual, centers, regions[last].triangles, wanted, labels);
    for (int pass = 0; pass < max_smoothing_passes && smooth_border_once(dual, labels); ++pass) continue;
    return labels;
}

}  // namespace

std::uint64_t gouraud_count(std::uint64_t triangles, double d) {
    const double share = 1.0 - std::clamp(finite_or_zero(d), 0.0, 1.0);
    return std::min(triangles, static_cast<std::uint64_t>(std::floor(share * static_cast<double>(triangles) + 0.5)));
}

std::vector<std::uint8_t> coherent_split(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& order,
                                         std::uint64_t gouraud, std::uint32_t regions) {
    const auto wanted = static_cast<std::uint32_t>(std::min<std::uint64_t>(gouraud, order.size()));
    if (regions > 0 && wanted > 0 && wanted < order.size()) return split_by_regions(mesh, order, wanted, regions);
    std::vector<std::uint8_t> result(order.size(), 0);
    for (std::uint32_t i = 0; i < wanted; ++i) result[order[i]] = 1;
    return result;
}

std::vector<std::uint32_t> region_counts_to_try(std::uint64_t triangles) {
    std::vector<std::uint32_t> counts;
    for (const std::uint32_t count : {256u, 64u, 16u, 4u, 1u})
        if (triangles / count >= min_region_triangles) counts.push_back(count);
    return counts;
}

}  // namespace lodestream::shading
