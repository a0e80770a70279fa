#include "common/simplify/wedges.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace lodestream::simplify {

namespace {

constexpr std::uint32_t no_vertex = 0xffffffffu;
constexpr float texture_tolerance = 1e-5f;  // of the texture's width
constexpr int color_tolerance = 2;          // of 255
constexpr double other_material = 1e6;      // a foreign material is worse than any other attribute

}  // namespace

Wedges::Wedges(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& positions, std::uint32_t count)
    : mesh_(mesh),
      material_(positions.size(), 0),
      group_(positions.size()),
      first_(count + 1, 0),
      vertices_(positions.size()) {
    for (std::size_t t = mesh.triangles.size(); t-- > 0;)
        for (const std::uint32_t v : mesh.triangles[t]) material_[v] = mesh::material_of(mesh, t);
    for (const std::uint32_t p : positions) ++first_[p + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t v = 0; v < positions.size(); ++v) vertices_[next[positions[v]]++] = v;

    const auto key = [&](std::uint32_t v) {
        const Vec2f uv = mesh.texture_coordinates.empty() ? Vec2f{0.0f} : mesh.texture_coordinates[v] + Vec2f{0.0f};
        const Rgba8 color = mesh.colors.empty() ? Rgba8{0} : mesh.colors[v];
        return std::tuple{material_[v], std::bit_cast<std::uint32_t>(uv.x), std::bit_cast<std::uint32_t>(uv.y),
                          std::bit_cast<std::uint32_t>(color)};
    };
    std::iota(group_.begin(), group_.end(), 0u);
    std::vector<std::uint32_t> sorted;
    for (std::uint32_t p = 0; p < count; ++p) {
        const Range here = at(p);
        if (here.size() < 2) continue;
        sorted.assign(here.begin(), here.end());
        std::stable_sort(sorted.begin(), sorted.end(), [&](auto a, auto b) { return key(a) < key(b); });
        for (std::size_t i = 1; i < sorted.size(); ++i)
            if (key(sorted[i]) == key(sorted[i - 1])) group_[sorted[i]] = group_[sorted[i - 1]];
    }
}

bool Wedges::agree(std::uint32_t a, std::uint32_t b) const {
    if (material_[a] != material_[b]) return false;
    if (!mesh_.texture_coordinates.empty()) {
        const Vec2f d = abs(mesh_.texture_coordinates[a] - mesh_.texture_coordinates[b]);
        if (!(d.x <= texture_tolerance && d.y <= texture_tolerance)) return false;
    }
    if (!mesh_.colors.empty())
        for (int k = 0; k < 4; ++k)
            if (std::abs(int{mesh_.colors[a][k]} - int{mesh_.colors[b][k]}) > color_tolerance) return false;
    return true;
}

double Wedges::normal_distance(std::uint32_t a, std::uint32_t b) const {
    return mesh_.normals.empty() ? 0.0 : 1.0 - double{dot(mesh_.normals[a], mesh_.normals[b])};
}

double Wedges::attribute_distance(std::uint32_t a, std::uint32_t b) const {
    double distance = material_[a] == material_[b] ? 0.0 : other_material;
    if (!mesh_.texture_coordinates.empty()) {
        const Vec2f d = mesh_.texture_coordinates[a] - mesh_.texture_coordinates[b];
        distance += std::min(double{dot(d, d)}, other_material / 10);
    }
    if (!mesh_.colors.empty())
        for (int k = 0; k < 4; ++k) {
            const double d = (int{mesh_.colors[a][k]} - int{mesh_.colors[b][k]}) / 255.0;
            distance += d * d;
        }
    return distance + 1e-3 * normal_distance(a, b);
}

std::uint32_t Wedges::nearest(std::uint32_t vertex, Range candidates) const {
    std::uint32_t best = no_vertex;
    double best_distance = std::numeric_limits<double>::infinity();
    for (const std::uint32_t candidate : candidates) {
        const double distance = attribute_distance(vertex, candidate);
        if (best != no_vertex && !(distance < best_distance)) continue;
        best = candidate;
        best_distance = distance;
    }
    return best;
}

// The vertex of `target`, nearest in normal, that goes on where the group of `vertex` is told to go; else one that
// agrees with `vertex` itself; no_vertex if there is none or the told pairs tear the group apart.
std::uint32_t Wedges::partner_in_group(std::uint32_t vertex, std::uint32_t target,
                                       const std::vector<Pair>& told) const {
    std::uint32_t told_group = no_vertex, best = no_vertex;
    double best_distance = std::numeric_limits<double>::infinity();
    const auto consider = [&](std::uint32_t candidate, double distance) {
        if (best != no_vertex && !(distance < best_distance)) return;
        best = candidate;
        best_distance = distance;
    };
    for (const Pair& pair : told) {
        if (group_[pair.from] != group_[vertex]) continue;
        if (told_group != no_vertex && group_[pair.to] != told_group) return no_vertex;
        told_group = group_[pair.to];
        if (pair.from == vertex) consider(pair.to, normal_distance(vertex, pair.to));
    }
    if (best != no_vertex) return best;
    for (const std::uint32_t candidate : at(target))
        if (told_group != no_vertex ? group_[candidate] == told_group : agree(vertex, candidate))
            consider(candidate, normal_distance(vertex, candidate));
    return best;
}

bool Wedges::find_partners(const std::vector<std::uint32_t>& used, std::uint32_t target, const std::vector<Pair>& told,
                           bool keep_seams, std::vector<Pair>& partners) const {
    for (const std::uint32_t vertex : used) {
        std::uint32_t partner = partner_in_group(vertex, target, told);
        if (partner == no_vertex) {
            if (keep_seams) return false;
            partner = nearest(vertex, at(target));
        }
        partners.push_back({vertex, partner});
    }
    return true;
}

}  // namespace lodestream::simplify
