#include "tests/bench/connectivity.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/mesh/operations.h"

namespace lodestream::bench {

namespace {

struct Edge {
    std::uint64_t key;  // both vertices
    std::uint32_t corner;

    bool operator<(const Edge& other) const { return key != other.key ? key < other.key : corner < other.corner; }
};

std::uint64_t key_of(std::uint32_t from, std::uint32_t to) {
    return static_cast<std::uint64_t>(from) << 32 | to;
}

std::vector<Edge> sorted_directed_edges(const std::vector<mesh::Triangle>& triangles) {
    std::vector<Edge> edges;
    edges.reserve(3 * triangles.size());
    for (std::uint32_t c = 0; c < 3 * triangles.size(); ++c)
        edges.push_back({key_of(vertex_of(triangles, c), vertex_of(triangles, next_corner(c))), c});
    std::sort(edges.begin(), edges.end());
    return edges;
}

std::vector<Edge> sorted_undirected_edges(const std::vector<mesh::Triangle>& triangles) {
    std::vector<Edge> edges;
    edges.reserve(3 * triangles.size());
    for (std::uint32_t c = 0; c < 3 * triangles.size(); ++c) {
        const std::uint32_t from = vertex_of(triangles, c), to = vertex_of(triangles, next_corner(c));
        edges.push_back({key_of(std::min(from, to), std::max(from, to)), c});
    }
    std::sort(edges.begin(), edges.end());
    return edges;
}

mesh::Mesh welded(const mesh::Mesh& mesh) {
    mesh::Mesh bare;
    bare.positions = mesh.positions;
    bare.triangles = mesh.triangles;
    return mesh::compact(bare);
}

std::uint64_t drop_second_takers(std::vector<mesh::Triangle>& triangles) {
    const std::vector<Edge> edges = sorted_directed_edges(triangles);
    std::vector<bool> dropped(triangles.size(), false);
    for (std::size_t i = 1; i < edges.size(); ++i)
        if (edges[i].key == edges[i - 1].key) dropped[edges[i].corner / 3] = true;
    std::size_t kept = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t)
        if (!dropped[t]) triangles[kept++] = triangles[t];
    const std::uint64_t count = triangles.size() - kept;
    triangles.resize(kept);
    return count;
}

class DisjointSets {
  public:
    explicit DisjointSets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }

    std::uint32_t find(std::uint32_t item) {
        while (parent_[item] != item) item = parent_[item] = parent_[parent_[item]];
        return item;
    }
    void unite(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<std::uint32_t> parent_;
};

// Corners are at one vertex of a manifold if a walk across shared edges leads from one to the other.
std::uint64_t split_fans(mesh::Mesh& mesh) {
    const std::vector<std::uint32_t> opposite = opposite_corners(mesh.triangles);
    DisjointSets fans(opposite.size());
    for (std::uint32_t c = 0; c < opposite.size(); ++c) {
        if (opposite[c] == none) continue;
        fans.unite(c, next_corner(opposite[c]));
        fans.unite(next_corner(c), opposite[c]);
    }
    constexpr std::uint32_t unseen = none;
    std::vector<std::uint32_t> fan_vertex(opposite.size(), unseen);
    std::vector<bool> taken(mesh.positions.size(), false);
    std::uint64_t copies = 0;
    for (std::uint32_t c = 0; c < opposite.size(); ++c) {
        const std::uint32_t vertex = vertex_of(mesh.triangles, c);
        std::uint32_t& mine = fan_vertex[fans.find(c)];
        if (mine == unseen && !taken[vertex]) {
            taken[vertex] = true;
            mine = vertex;
        } else if (mine == unseen) {
            mine = static_cast<std::uint32_t>(mesh.positions.size());
            mesh.positions.push_back(Vec3f(mesh.positions[vertex]));
            ++copies;
        }
    }
    for (std::uint32_t c = 0; c < opposite.size(); ++c) mesh.triangles[c / 3][c % 3] = fan_vertex[fans.find(c)];
    return copies;
}

}  // namespace

std::vector<std::uint32_t> opposite_corners(const std::vector<mesh::Triangle>& triangles) {
    const std::vector<Edge> edges = sorted_undirected_edges(triangles);
    std::vector<std::uint32_t> opposite(edges.size(), none);
    for (std::size_t i = 1; i < edges.size(); ++i) {
        if (edges[i].key != edges[i - 1].key) continue;
        opposite[edges[i].corner] = edges[i - 1].corner;
        opposite[edges[i - 1].corner] = edges[i].corner;
    }
    return opposite;
}

mesh::Mesh make_manifold(const mesh::Mesh& mesh, Repairs& repairs) {
    mesh::Mesh result = welded(mesh);
    repairs.dropped_triangles = drop_second_takers(result.triangles);
    result = welded(result);
    repairs.split_vertices = split_fans(result);
    return result;
}

std::vector<std::array<std::uint32_t, 2>> open_edges(const mesh::Mesh& mesh) {
    const std::vector<std::uint32_t> position = mesh::weld_positions(mesh.positions);
    std::vector<mesh::Triangle> welded_triangles = mesh.triangles;
    for (mesh::Triangle& t : welded_triangles)
        for (std::uint32_t& vertex : t) vertex = position[vertex];
    const std::vector<Edge> edges = sorted_undirected_edges(welded_triangles);
    std::vector<std::array<std::uint32_t, 2>> open;
    for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
        while (end < edges.size() && edges[end].key == edges[i].key) ++end;
        const std::uint32_t corner = edges[i].corner;
        if (end == i + 1)
            open.push_back({vertex_of(mesh.triangles, corner), vertex_of(mesh.triangles, next_corner(corner))});
    }
    return open;
}

}  // namespace lodestream::bench
