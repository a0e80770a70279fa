#include "client/render/vertex_order.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <utility>

namespace lodestream::render {
namespace {

constexpr unsigned smallest_cache = 16;

// The given triangles over vertices numbered 0 … count-1.
struct Local {
    std::vector<std::uint32_t> indices;
    std::size_t vertices = 0;
};

Local renumbered(std::span<const mesh::Triangle> triangles) {
    std::vector<std::uint32_t> used;
    used.reserve(triangles.size() * 3);
    for (const mesh::Triangle& t : triangles) used.insert(used.end(), t.begin(), t.end());
    std::vector<std::uint32_t> names = used;
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    for (std::uint32_t& v : used)
        v = static_cast<std::uint32_t>(std::lower_bound(names.begin(), names.end(), v) - names.begin());
    return {std::move(used), names.size()};
}

using Corners = std::array<std::uint32_t, 3>;

// Rotated so that the lowest corner comes first: the library may turn triangles.
Corners turned(const std::uint32_t* corners) {
    Corners t{corners[0], corners[1], corners[2]};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
}

}  // namespace

std::vector<std::uint32_t> cache_order(std::span<const mesh::Triangle> triangles) {
    const Local local = renumbered(triangles);
    std::vector<std::uint32_t> arranged(local.indices.size());
    meshopt_optimizeVertexCache(arranged.data(), local.indices.data(), local.indices.size(), local.vertices);
    std::vector<std::pair<Corners, std::uint32_t>> known;
    known.reserve(triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) known.emplace_back(turned(&local.indices[3 * t]), t);
    std::sort(known.begin(), known.end());
    std::vector<std::uint32_t> order, taken(triangles.size(), 0);  // of equal triangles, how many
    order.reserve(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto equal = std::lower_bound(known.begin(), known.end(), std::pair(turned(&arranged[3 * t]), 0u));
        std::uint32_t& before = taken[static_cast<std::size_t>(equal - known.begin())];
        order.push_back((equal + before++)->second);
    }
    return order;
}

double transforms_per_triangle(const mesh::Mesh& mesh) {
    if (mesh.triangles.empty()) return 0.0;
    return static_cast<double>(meshopt_analyzeVertexCache(mesh.triangles[0].data(), mesh.triangles.size() * 3,
                                                          mesh.positions.size(), smallest_cache, 0, 0)
                                   .acmr);
}

}  // namespace lodestream::render
