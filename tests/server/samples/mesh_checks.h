// What holds for every sample, and the edges of a mesh.
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "common/mesh/mesh.h"
#include "common/mesh/operations.h"

namespace lodestream::testing {

inline void expect_sound(const mesh::Model& model) {
    const mesh::Mesh& m = model.mesh;
    ASSERT_EQ(m.normals.size(), m.positions.size());
    ASSERT_FALSE(m.triangles.empty());
    std::vector<bool> used(m.positions.size());
    std::size_t bad = 0;
    for (std::size_t t = 0; t < m.triangles.size(); ++t) {
        const auto [a, b, c] = m.triangles[t];
        ASSERT_LT(std::max({a, b, c}), m.positions.size());
        used[a] = used[b] = used[c] = true;
        bad += !(mesh::face_area(m.positions[a], m.positions[b], m.positions[c]) > 0) || a == b || b == c || c == a;
        bad += mesh::material_of(m, t) >= model.materials.size();
    }
    for (const Vec3f& p : m.positions) bad += !all_finite(p);
    for (const Vec3f& n : m.normals) bad += !(std::abs(length(Vec3d(n)) - 1) < 1e-5);
    EXPECT_EQ(bad, 0u);
    EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

// Directed edges, and how often each occurs.
inline std::map<Edge, int> directed_edges_by_index(const mesh::Mesh& m) {
    std::map<Edge, int> edges;
    for (const auto& t : m.triangles)
        for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
    return edges;
}
inline std::map<Edge, int> directed_edges(mesh::Mesh m) {  // between positions
    const auto welded = mesh::weld_positions(m.positions);
    for (auto& t : m.triangles) t = {welded[t[0]], welded[t[1]], welded[t[2]]};
    return directed_edges_by_index(m);
}

// The edges that only one triangle has.
inline std::vector<Edge> border(const std::map<Edge, int>& edges) {
    std::vector<Edge> result;
    for (const auto& [edge, uses] : edges)
        if (!edges.contains({edge.second, edge.first})) result.push_back(edge);
    return result;
}

inline bool each_edge_once(const std::map<Edge, int>& edges) {
    return std::all_of(edges.begin(), edges.end(), [](const auto& entry) { return entry.second == 1; });
}

// Parts that hang together by edges, counted by their vertices.
inline std::size_t components(const std::map<Edge, int>& edges) {
    std::map<std::uint32_t, std::uint32_t> parent;
    const auto root = [&](std::uint32_t v) {
        parent.try_emplace(v, v);
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (const auto& [edge, uses] : edges) parent[root(edge.first)] = root(edge.second);
    std::set<std::uint32_t> roots;
    for (const auto& [edge, uses] : edges) roots.insert(root(edge.first));
    return roots.size();
}

inline double signed_volume(const mesh::Mesh& m) {
    double volume = 0;
    for (const auto& [a, b, c] : m.triangles)
        volume += dot(Vec3d(m.positions[a]), cross(Vec3d(m.positions[b]), Vec3d(m.positions[c]))) / 6;
    return volume;
}

// The least agreement, as a cosine, between a triangle's own normal and those of its corners.
inline double worst_normal(const mesh::Mesh& m) {
    double worst = 1;
    for (const auto& t : m.triangles) {
        const Vec3d normal = mesh::face_normal(m.positions[t[0]], m.positions[t[1]], m.positions[t[2]]);
        for (const std::uint32_t v : t) worst = std::min(worst, dot(normal, Vec3d(m.normals[v])));
    }
    return worst;
}

}  // namespace lodestream::testing
