#include "common/simplify/wedges.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

namespace lodestream::simplify {

namespace {

constexpr std::uint32_t none = 0xffffffffu;
constexpr float texture_tolerance = 1e-5f;  // of the texture's width
constexpr int color_tolerance = 2;          // of 255
constexpr double other_material = 1e6;      // a foreign material is worse than any other attribute

constexpr float least_normal = 1e-3f;  // of the sum of two normals, against their lengths: opposite ones have no mean
constexpr double min_normal_length = 1e-15, max_normal_length = 1e15;  // well inside single precision when squared

template <class Attribute>
std::vector<Attribute> reordered(const std::vector<Attribute>& of_vertex, const std::vector<std::uint32_t>& wedge) {
    std::vector<Attribute> of_wedge(of_vertex.size());
    for (std::size_t v = 0; v < of_vertex.size(); ++v) of_wedge[wedge[v]] = of_vertex[v];
    return of_wedge;
}

}  // namespace

Vec3f joined_normal(const Vec3f& a, const Vec3f& b) {
    const Vec3f sum = a + b;
    return length(sum) > least_normal * (length(a) + length(b)) ? sum : a;
}

Wedges::Wedges(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& positions, std::uint32_t count,
               std::vector<std::uint32_t>& wedge_of_vertex)
    : size_(positions.size()), positions_(count), uses_(positions.size(), 0) {
    first_.assign(count + 1, 0);
    for (const std::uint32_t p : positions) ++first_[p];
    std::uint32_t end = count;
    for (std::uint32_t p = 0; p < count; ++p) first_[p] = std::exchange(end, end + first_[p] - 1);
    first_[count] = end;
    std::vector<std::uint32_t> next(count, none);
    further_position_.resize(size_ - count);
    wedge_of_vertex.resize(positions.size());
    for (std::uint32_t v = 0; v < positions.size(); ++v) {
        const std::uint32_t p = positions[v];
        wedge_of_vertex[v] = next[p] == none ? p : next[p];
        next[p] = next[p] == none ? first_[p] : next[p] + 1;
        if (wedge_of_vertex[v] >= count) further_position_[wedge_of_vertex[v] - count] = p;
    }
    next = {};

    normals_ = reordered(mesh.normals, wedge_of_vertex);
    texture_coordinates_ = reordered(mesh.texture_coordinates, wedge_of_vertex);
    colors_ = reordered(mesh.colors, wedge_of_vertex);
    if (!mesh.triangle_materials.empty()) {
        material_.assign(positions.size(), 0);
        for (std::size_t t = mesh.triangles.size(); t-- > 0;)
            for (const std::uint32_t v : mesh.triangles[t]) material_[wedge_of_vertex[v]] = mesh.triangle_materials[t];
    }
    if (positions.size() == count)
        first_ = {};
    else if (!texture_coordinates_.empty() || !colors_.empty() || !material_.empty())
        find_groups();
}

void Wedges::find_groups() {
    const auto key = [&](std::uint32_t w) {
        const Vec2f uv = texture_coordinates_.empty() ? Vec2f{0.0f} : texture_coordinates_[w] + Vec2f{0.0f};
        const Rgba8 color = colors_.empty() ? Rgba8{0} : colors_[w];
        return std::tuple{material(w), std::bit_cast<std::uint32_t>(uv.x), std::bit_cast<std::uint32_t>(uv.y),
                          std::bit_cast<std::uint32_t>(color)};
    };
    group_.resize(uses_.size());
    std::iota(group_.begin(), group_.end(), 0u);
    std::vector<std::uint32_t> sorted;
    for (std::uint32_t p = 0; p < positions_; ++p) {
        if (at(p).size() < 2) continue;
        sorted.clear();
        for (const std::uint32_t wedge : at(p)) sorted.push_back(wedge);
        std::stable_sort(sorted.begin(), sorted.end(), [&](auto a, auto b) { return key(a) < key(b); });
        for (std::size_t i = 1; i < sorted.size(); ++i)
            if (key(sorted[i]) == key(sorted[i - 1])) group_[sorted[i]] = group_[sorted[i - 1]];
    }
}

bool Wedges::has_seam(std::uint32_t position) const {
    for (const std::uint32_t wedge : at(position))
        if (group(wedge) != group(position)) return true;
    return false;
}

void Wedges::weigh_normal(std::uint32_t wedge, double area) {
    if (!normals_.empty())
        normals_[wedge] *= static_cast<float>(std::clamp(area, min_normal_length, max_normal_length));
}

Attributes Wedges::attributes(std::uint32_t wedge) const {
    Attributes a;
    if (!normals_.empty()) a.normal = normals_[wedge];
    if (!texture_coordinates_.empty()) a.texture_coordinate = texture_coordinates_[wedge];
    if (!colors_.empty()) a.color = colors_[wedge];
    return a;
}

void Wedges::set_attributes(std::uint32_t wedge, const Attributes& a) {
    if (!normals_.empty()) normals_[wedge] = a.normal;
    if (!texture_coordinates_.empty()) texture_coordinates_[wedge] = a.texture_coordinate;
    if (!colors_.empty()) colors_[wedge] = a.color;
}

void Wedges::blend(const std::array<std::uint32_t, 3>& wedges, const Vec3d& weights, Attributes& a) const {
    glm::dvec2 texture_coordinate{0.0};
    std::array<double, 4> color{};
    for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t wedge = wedges[static_cast<std::size_t>(corner)];
        if (!texture_coordinates_.empty())
            texture_coordinate += weights[corner] * glm::dvec2(texture_coordinates_[wedge]);
        if (!colors_.empty())
            for (int k = 0; k < 4; ++k) color[static_cast<std::size_t>(k)] += weights[corner] * colors_[wedge][k];
    }
    if (!texture_coordinates_.empty()) a.texture_coordinate = Vec2f(texture_coordinate);
    if (colors_.empty()) return;
    for (int k = 0; k < 4; ++k)
        a.color[k] = static_cast<std::uint8_t>(std::clamp(std::lround(color[static_cast<std::size_t>(k)]), 0l, 255l));
}

bool Wedges::agree(std::uint32_t a, std::uint32_t b) const {
    if (material(a) != material(b)) return false;
    if (!texture_coordinates_.empty()) {
        const Vec2f d = abs(texture_coordinates_[a] - texture_coordinates_[b]);
        if (!(d.x <= texture_tolerance && d.y <= texture_tolerance)) return false;
    }
    if (!colors_.empty())
        for (int k = 0; k < 4; ++k)
            if (std::abs(int{colors_[a][k]} - int{colors_[b][k]}) > color_tolerance) return false;
    return true;
}

double Wedges::normal_distance(std::uint32_t a, std::uint32_t b) const {
    if (normals_.empty()) return 0.0;
    const Vec3d n(normals_[a]), m(normals_[b]);
    const double lengths = length(n) * length(m);
    return lengths > 0 ? 1.0 - dot(n, m) / lengths : 0.0;
}

double Wedges::attribute_distance(std::uint32_t a, std::uint32_t b) const {
    double distance = material(a) == material(b) ? 0.0 : other_material;
    if (!texture_coordinates_.empty()) {
        const Vec2f d = texture_coordinates_[a] - texture_coordinates_[b];
        distance += std::min(double{dot(d, d)}, other_material / 10);
    }
    if (!colors_.empty())
        for (int k = 0; k < 4; ++k) {
            const double d = (int{colors_[a][k]} - int{colors_[b][k]}) / 255.0;
            distance += d * d;
        }
    return distance + 1e-3 * normal_distance(a, b);
}

std::uint32_t Wedges::nearest(std::uint32_t wedge, Range candidates) const {
    std::uint32_t best = none;
    double best_distance = std::numeric_limits<double>::infinity();
    for (const std::uint32_t candidate : candidates) {
        if (!is_used(candidate)) continue;
        const double distance = attribute_distance(wedge, candidate);
        if (best != none && !(distance < best_distance)) continue;
        best = candidate;
        best_distance = distance;
    }
    return best;
}

// The candidate, nearest in normal, that goes on where the group of `wedge` is told to go; else one that agrees with
// `wedge` itself; none if there is none or the told pairs tear the group apart.
std::uint32_t Wedges::partner_in_group(std::uint32_t wedge, Range candidates, const std::vector<Pair>& told) const {
    std::uint32_t told_group = none, best = none;
    double best_distance = std::numeric_limits<double>::infinity();
    const auto consider = [&](std::uint32_t candidate, double distance) {
        if (best != none && !(distance < best_distance)) return;
        best = candidate;
        best_distance = distance;
    };
    for (const Pair& pair : told) {
        if (group(pair.from) != group(wedge)) continue;
        if (told_group != none && group(pair.to) != told_group) return none;
        told_group = group(pair.to);
        if (pair.from == wedge) consider(pair.to, normal_distance(wedge, pair.to));
    }
    if (best != none) return best;
    for (const std::uint32_t candidate : candidates)
        if (is_used(candidate) && (told_group != none ? group(candidate) == told_group : agree(wedge, candidate)))
            consider(candidate, normal_distance(wedge, candidate));
    return best;
}

bool Wedges::find_partners(const std::vector<std::uint32_t>& used, std::uint32_t target, const std::vector<Pair>& told,
                           bool keep_seams, std::vector<Pair>& partners) const {
    for (const std::uint32_t wedge : used) {
        std::uint32_t partner = partner_in_group(wedge, at(target), told);
        if (partner == none) {
            if (keep_seams) return false;
            partner = nearest(wedge, at(target));
            if (partner == none) return false;
        }
        partners.push_back({wedge, partner});
    }
    return true;
}

}  // namespace lodestream::simplify
