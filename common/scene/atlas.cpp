#include "common/scene/atlas.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include "common/image/pack.h"
#include "common/mesh/operations.h"

namespace lodestream::scene {

namespace {

constexpr std::uint32_t none = Texel::nothing;
constexpr std::uint32_t gutter = 1;     // texels around a chart
constexpr int smoothing_rounds = 4;     // of the directions that triangles face
constexpr double least_facing = 0.35;   // cosine, of a triangle that follows its neighbours
constexpr double overlap_depth = 2.0;   // texels between parts that lie over each other
constexpr double inside = -1e-9;        // weights of places inside or on a side
constexpr double usual_room = 3.0;      // of the charts' rectangles to the surface
constexpr double least_filled = 0.4;    // of a picture from a side
constexpr std::uint64_t most_room = 8;  // of all charts to the texels asked for

using Vec2d = glm::dvec2;

using Neighbors = std::vector<std::array<std::uint32_t, 3>>;

// Across each side of each triangle one that has both its positions; none where there is none left.
Neighbors neighbors_of(const mesh::Mesh& mesh) {
    const std::vector<std::uint32_t> positions = mesh::weld_positions(mesh.positions);
    struct Side {
        std::uint32_t a, b, triangle, k;
    };
    std::vector<Side> sides;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = positions[mesh.triangles[t][k]], b = positions[mesh.triangles[t][(k + 1) % 3]];
            sides.push_back({std::min(a, b), std::max(a, b), t, k});
        }
    std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
        return std::tie(x.a, x.b, x.triangle, x.k) < std::tie(y.a, y.b, y.triangle, y.k);
    });
    Neighbors neighbors(mesh.triangles.size(), {none, none, none});
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
        const Side &x = sides[i], &y = sides[i + 1];
        if (x.a != y.a || x.b != y.b) continue;
        neighbors[x.triangle][x.k] = y.triangle;
        neighbors[y.triangle][y.k] = x.triangle;
        ++i;
    }
    return neighbors;
}

// One of the six directions along the axes: 2 * axis, and one more where it is the negative.
using Facing = std::size_t;
constexpr Facing facings = 6;

double along(const Vec3d& normal, Facing facing) {
    const double component = normal[static_cast<int>(facing / 2)];
    return facing % 2 == 0 ? component : -component;
}

Facing nearest_facing(const Vec3d& normal) {
    Facing best = 0;
    for (Facing facing = 1; facing < facings; ++facing)
        if (along(normal, facing) > along(normal, best)) best = facing;
    return best;
}

// What each triangle faces; one that stands out from two of its neighbours does as they do, if it can.
std::vector<Facing> facings_of(const mesh::Mesh& mesh, const Neighbors& neighbors) {
    std::vector<Vec3d> normals;
    std::vector<Facing> faced;
    for (const mesh::Triangle& t : mesh.triangles) {
        normals.push_back(mesh::face_normal(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]));
        faced.push_back(nearest_facing(normals.back()));
    }
    for (int round = 0; round < smoothing_rounds; ++round)
        for (std::size_t t = 0; t < faced.size(); ++t) {
            std::array<int, facings> votes{};
            for (const std::uint32_t n : neighbors[t])
                if (n != none) ++votes[faced[n]];
            for (Facing facing = 0; facing < facings; ++facing)
                if (votes[facing] >= 2 && along(normals[t], facing) > least_facing) faced[t] = facing;
        }
    return faced;
}

struct Chart {
    std::vector<std::uint32_t> triangles;
    Facing facing = 0;
    Vec2d low{0.0};                       // of its projection
    std::uint32_t width = 0, height = 0;  // texels, with the gutter
    std::vector<Texel> texels;            // width * height
};

using Part = std::vector<std::uint32_t>;  // triangles

Vec2d projected(const Vec3f& p, Facing facing) {
    const int axis = static_cast<int>(facing / 2);
    return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

struct Shadow {
    Vec2d low{std::numeric_limits<double>::max()}, high{std::numeric_limits<double>::lowest()};
};

Shadow shadow_of(const mesh::Mesh& mesh, const Part& part, Facing facing) {
    Shadow shadow;
    for (const std::uint32_t t : part)
        for (const std::uint32_t v : mesh.triangles[t]) {
            shadow.low = min(shadow.low, projected(mesh.positions[v], facing));
            shadow.high = max(shadow.high, projected(mesh.positions[v], facing));
        }
    return shadow;
}

// Connected triangles that face one way.
std::vector<Part> parts_of(const Neighbors& neighbors, const std::vector<Facing>& faced) {
    std::vector<Part> parts;
    std::vector<bool> is_taken(faced.size(), false);
    for (std::uint32_t seed = 0; seed < faced.size(); ++seed) {
        if (is_taken[seed]) continue;
        Part part{seed};
        is_taken[seed] = true;
        for (std::size_t i = 0; i < part.size(); ++i)
            for (const std::uint32_t n : neighbors[part[i]]) {
                if (n == none || is_taken[n] || faced[n] != faced[seed]) continue;
                is_taken[n] = true;
                part.push_back(n);
            }
        parts.push_back(std::move(part));
    }
    return parts;
}

class Unfolding {
  public:
    Unfolding(const mesh::Mesh& mesh, std::uint64_t texels) : mesh_(mesh), texels_(texels) {
        const Neighbors neighbors = neighbors_of(mesh);
        faced_ = facings_of(mesh, neighbors);
        parts_ = parts_of(neighbors, faced_);
        std::stable_sort(parts_.begin(), parts_.end(),
                         [](const Part& a, const Part& b) { return a.size() > b.size(); });
        texel_size_ = choose_texel_size();
    }

    // Pictures from the six sides as long as they are filled well, then parts one by one. What lies over itself makes
    // charts of its own, until these take more room than is reasonable.
    std::vector<Chart> charts() const {
        std::vector<Chart> charts;
        std::uint64_t taken = 0;
        const auto add = [&](Part& rest) {
            charts.push_back(chart_of(rest, faced_[rest.front()], taken > most_room * texels_));
            taken += charts.back().texels.size();
        };
        for (Facing facing = 0; facing < facings; ++facing) {
            Part side;
            for (const Part& part : parts_)
                if (faced_[part.front()] == facing) side.insert(side.end(), part.begin(), part.end());
            while (!side.empty() && filled(side, facing) > least_filled) add(side);
            std::vector<bool> is_left(faced_.size(), false);
            for (const std::uint32_t t : side) is_left[t] = true;
            for (const Part& part : parts_) {
                Part rest;
                std::copy_if(part.begin(), part.end(), std::back_inserter(rest), [&](auto t) { return is_left[t]; });
                while (!rest.empty()) add(rest);
            }
        }
        return charts;
    }

    // Where a corner is in its chart, texels from the corner of that.
    Vec2d place(const Chart& chart, const Vec3f& p) const {
        return (projected(p, chart.facing) - chart.low) / texel_size_ + (gutter + 0.5);
    }

  private:
    // The share of the rectangle around them that triangles could fill.
    double filled(const Part& part, Facing facing) const {
        const Shadow shadow = shadow_of(mesh_, part, facing);
        const double room = (shadow.high.x - shadow.low.x) * (shadow.high.y - shadow.low.y);
        double area = 0.0;
        for (const std::uint32_t t : part) {
            const mesh::Triangle& triangle = mesh_.triangles[t];
            const auto corner = [&](std::size_t k) { return projected(mesh_.positions[triangle[k]], facing); };
            area += 0.5 * std::abs(cross_of(corner(1) - corner(0), corner(2) - corner(0)));
        }
        return room > 0.0 ? area / room : 0.0;
    }

    // Such that the surface takes so many texels, its charts little more, and no chart is larger than the limit.
    double choose_texel_size() const {
        double area = 0.0, room = 0.0;
        for (const auto& [a, b, c] : mesh_.triangles)
            area += mesh::face_area(mesh_.positions[a], mesh_.positions[b], mesh_.positions[c]);
        for (const Part& part : parts_) {
            const Shadow shadow = shadow_of(mesh_, part, faced_[part.front()]);
            room += (shadow.high.x - shadow.low.x) * (shadow.high.y - shadow.low.y);
        }
        const Vec3d extent = mesh::bounds(mesh_).extent();
        const double least = std::max({extent.x, extent.y, extent.z}) / (max_atlas_side - 2 * gutter - 2);
        return std::max(std::sqrt(std::max(area, room / usual_room) / static_cast<double>(texels_)), least);
    }

    // Takes out of `rest` what goes into the chart: all that does not lie over what is in it before, if that counts.
    // The first always goes.
    Chart chart_of(Part& rest, Facing facing, bool may_overlap) const {
        Chart chart;
        chart.facing = facing;
        const Shadow shadow = shadow_of(mesh_, rest, facing);
        chart.low = shadow.low;
        const Vec2d size = (shadow.high - shadow.low) / texel_size_;
        chart.width = static_cast<std::uint32_t>(size.x) + 2 + 2 * gutter;
        chart.height = static_cast<std::uint32_t>(size.y) + 2 + 2 * gutter;
        chart.texels.resize(std::size_t{chart.width} * chart.height);
        bool is_empty = true;
        Part left;
        for (const std::uint32_t t : rest) {
            std::vector<std::pair<std::size_t, Texel>> covered;
            if (!cover(chart, t, covered) && !may_overlap) {
                left.push_back(t);
                continue;
            }
            chart.triangles.push_back(t);
            for (const auto& [index, texel] : covered) chart.texels[index] = texel;
            is_empty = is_empty && covered.empty();
        }
        if (is_empty)
            chart.texels[chart.texels.size() / 2 + chart.width / 2] = {chart.triangles.front(), Vec3f(1.0f / 3.0f)};
        rest = std::move(left);
        return chart;
    }

    // The texels that show a triangle; false where it lies over what is there already.
    bool cover(const Chart& chart, std::uint32_t t, std::vector<std::pair<std::size_t, Texel>>& covered) const {
        const mesh::Triangle& triangle = mesh_.triangles[t];
        std::array<Vec2d, 3> p;
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = place(chart, mesh_.positions[triangle[k]]) - 0.5;  // middles at 0, 1, …
        const double area = cross_of(p[1] - p[0], p[2] - p[0]);
        if (area == 0.0) return true;
        const Vec2d low = max(min(min(p[0], p[1]), p[2]), Vec2d(0.0));
        const Vec2d high = max(max(p[0], p[1]), p[2]);
        for (auto y = static_cast<std::uint32_t>(std::ceil(low.y)); y <= high.y && y < chart.height; ++y)
            for (auto x = static_cast<std::uint32_t>(std::ceil(low.x)); x <= high.x && x < chart.width; ++x) {
                const Vec2d middle(x, y);
                const double a = cross_of(p[1] - middle, p[2] - middle) / area;
                const double b = cross_of(p[2] - middle, p[0] - middle) / area;
                const double c = 1.0 - a - b;
                if (a < inside || b < inside || c < inside) continue;
                const Texel texel{t, Vec3f(max(Vec3d(a, b, c), Vec3d(0.0)))};
                const std::size_t index = std::size_t{y} * chart.width + x;
                const Texel& before = chart.texels[index];
                if (before.triangle == none)
                    covered.emplace_back(index, texel);
                else if (std::abs(depth(chart, texel) - depth(chart, before)) > overlap_depth * texel_size_)
                    return false;
            }
        return true;
    }

    double depth(const Chart& chart, const Texel& texel) const {
        const int axis = static_cast<int>(chart.facing / 2);
        double sum = 0.0;
        for (int k = 0; k < 3; ++k)
            sum += static_cast<double>(texel.weights[k]) *
                   mesh_.positions[mesh_.triangles[texel.triangle][static_cast<std::size_t>(k)]][axis];
        return sum;
    }

    static double cross_of(const Vec2d& a, const Vec2d& b) { return a.x * b.y - a.y * b.x; }

    const mesh::Mesh& mesh_;
    std::uint64_t texels_;
    std::vector<Facing> faced_;
    std::vector<Part> parts_;
    double texel_size_ = 0.0;
};

}  // namespace

Atlas unfold(const mesh::Mesh& surface, std::uint64_t texels) {
    assert(!surface.triangles.empty() && texels > 0);
    const Unfolding unfolding(surface, texels);
    Atlas atlas;
    const std::vector<Chart> charts = unfolding.charts();
    std::vector<image::Rectangle> places;
    for (const Chart& chart : charts) places.push_back({chart.width, chart.height});
    const image::PackedSize size = image::pack(places);
    atlas.width = size.width;
    atlas.height = size.height;
    atlas.texels.resize(std::size_t{atlas.width} * atlas.height);
    atlas.mesh.triangles.resize(surface.triangles.size());
    for (std::size_t i = 0; i < charts.size(); ++i) {
        const Chart& chart = charts[i];
        const image::Rectangle& at = places[i];
        for (std::uint32_t y = 0; y < chart.height; ++y)
            std::copy_n(chart.texels.begin() + std::ptrdiff_t{y} * chart.width, chart.width,
                        atlas.texels.begin() + (std::ptrdiff_t{at.y} + y) * atlas.width + at.x);
        std::map<std::uint32_t, std::uint32_t> vertices;  // of the surface, and what they have become in this chart
        for (const std::uint32_t t : chart.triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = surface.triangles[t][k];
                const auto next = static_cast<std::uint32_t>(atlas.mesh.positions.size());
                const auto [known, is_new] = vertices.emplace(v, next);
                atlas.mesh.triangles[t][k] = known->second;
                if (!is_new) continue;
                const Vec2d place = unfolding.place(chart, surface.positions[v]) + Vec2d(at.x, at.y);
                atlas.mesh.positions.push_back(surface.positions[v]);
                if (!surface.normals.empty()) atlas.mesh.normals.push_back(surface.normals[v]);
                atlas.mesh.texture_coordinates.emplace_back(place / Vec2d(atlas.width, atlas.height));
            }
    }
    return atlas;
}

}  // namespace lodestream::scene
