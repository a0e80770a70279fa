#include "common/scene/fit_colors.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "common/mesh/operations.h"
#include "common/metric/triangle_tree.h"

namespace lodestream::scene {

namespace {

constexpr std::uint32_t least_rows = 2, most_rows = 24;  // of places on a triangle
constexpr double places_per_triangle = 16.0;             // on average
constexpr double stiffness = 1e-3;  // with which a vertex keeps its colour, of a mean vertex's weight
constexpr int iterations = 60;
constexpr double enough = 1e-6;  // of the first residual

using Colors = std::vector<Vec4d>;

struct Place {
    std::size_t triangle;
    Vec3d weights;
    double area;
    Vec4d color;
};

Vec4d color_at(const mesh::Mesh& mesh, const mesh::Triangle& t, const Vec3d& w) {
    return w.x * Vec4d(mesh.colors[t[0]]) + w.y * Vec4d(mesh.colors[t[1]]) + w.z * Vec4d(mesh.colors[t[2]]);
}

Vec3d position_at(const mesh::Mesh& mesh, const mesh::Triangle& t, const Vec3d& w) {
    return w.x * Vec3d(mesh.positions[t[0]]) + w.y * Vec3d(mesh.positions[t[1]]) + w.z * Vec3d(mesh.positions[t[2]]);
}

// In the middles of the rows² small triangles that a triangle divides into, as many as its area asks for.
std::vector<Place> places_on(const mesh::Mesh& level, const mesh::Mesh& source) {
    std::vector<double> areas;
    double total = 0.0;
    for (const auto& [a, b, c] : level.triangles) {
        areas.push_back(mesh::face_area(level.positions[a], level.positions[b], level.positions[c]));
        total += areas.back();
    }
    std::vector<Place> places;
    if (!(total > 0.0) || !std::isfinite(total)) return places;
    const metric::TriangleTree tree(source);
    const double mean = total / static_cast<double>(level.triangles.size());
    const auto add = [&](std::size_t t, const Vec3d& weights, double area) {
        const Vec3d point = position_at(level, level.triangles[t], weights);
        const metric::SurfacePlace near = metric::nearest_place(tree, source, point);
        places.push_back({t, weights, area, color_at(source, near.triangle, near.weights)});
    };
    for (std::size_t t = 0; t < areas.size(); ++t) {
        const double wanted = std::sqrt(places_per_triangle * areas[t] / mean);
        const auto rows = static_cast<std::uint32_t>(std::clamp<double>(wanted, least_rows, most_rows));
        const double side = 1.0 / rows, area = areas[t] / mean * side * side;
        for (std::uint32_t i = 0; i < rows; ++i)
            for (std::uint32_t j = 0; i + j < rows; ++j) {
                const Vec3d corner{1.0 - side * (i + j), side * i, side * j};
                add(t, corner + side / 3.0 * Vec3d{-2.0, 1.0, 1.0}, area);
                if (i + j + 1 < rows) add(t, corner + side / 3.0 * Vec3d{-4.0, 2.0, 2.0}, area);
            }
    }
    return places;
}

Vec4d dot_of_channels(const Colors& a, const Colors& b) {
    Vec4d sum(0.0);
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

// The normal equations, never written out: (AᵀWA + stiffness) x = AᵀWc + stiffness * x0, channel by channel.
class Equations {
  public:
    Equations(const mesh::Mesh& level, const std::vector<Place>& places, double kept)
        : level_(level), places_(places), kept_(kept) {}

    Colors times(const Colors& x) const {
        Colors out(x.size());
        for (std::size_t v = 0; v < x.size(); ++v) out[v] = kept_ * x[v];
        for (const Place& place : places_) {
            const mesh::Triangle& t = level_.triangles[place.triangle];
            const Vec4d shown = place.weights.x * x[t[0]] + place.weights.y * x[t[1]] + place.weights.z * x[t[2]];
            spread(out, place, shown);
        }
        return out;
    }
    Colors right_side(const Colors& start) const {
        Colors out(start.size());
        for (std::size_t v = 0; v < start.size(); ++v) out[v] = kept_ * start[v];
        for (const Place& place : places_) spread(out, place, place.color);
        return out;
    }

  private:
    void spread(Colors& to, const Place& place, const Vec4d& color) const {
        const mesh::Triangle& t = level_.triangles[place.triangle];
        for (int k = 0; k < 3; ++k) to[t[static_cast<std::size_t>(k)]] += place.area * place.weights[k] * color;
    }

    const mesh::Mesh& level_;
    const std::vector<Place>& places_;
    double kept_;
};

// Conjugate gradients, all channels side by side.
Colors solve(const Equations& equations, Colors x) {
    Colors residual = equations.right_side(x);
    const Colors first = equations.times(x);
    for (std::size_t v = 0; v < x.size(); ++v) residual[v] -= first[v];
    Colors direction = residual;
    Vec4d norm = dot_of_channels(residual, residual);
    const Vec4d goal = enough * enough * norm;
    for (int i = 0; i < iterations && glm::any(glm::greaterThan(norm, goal)); ++i) {
        const Colors image = equations.times(direction);
        const Vec4d along = dot_of_channels(direction, image);
        Vec4d step(0.0);
        for (int k = 0; k < 4; ++k) step[k] = along[k] > 0.0 ? norm[k] / along[k] : 0.0;
        for (std::size_t v = 0; v < x.size(); ++v) {
            x[v] += step * direction[v];
            residual[v] -= step * image[v];
        }
        const Vec4d next = dot_of_channels(residual, residual);
        Vec4d kept(0.0);
        for (int k = 0; k < 4; ++k) kept[k] = norm[k] > 0.0 ? next[k] / norm[k] : 0.0;
        for (std::size_t v = 0; v < x.size(); ++v) direction[v] = residual[v] + kept * direction[v];
        norm = next;
    }
    return x;
}

}  // namespace

std::vector<Rgba8> fit_colors(const mesh::Mesh& level, const mesh::Mesh& source) {
    assert(!level.colors.empty() && !source.colors.empty());
    const std::vector<Place> places = places_on(level, source);
    if (places.empty()) return level.colors;
    const double mean_weight = static_cast<double>(level.triangles.size()) / static_cast<double>(level.colors.size());
    Colors start(level.colors.begin(), level.colors.end());
    std::vector<Rgba8> colors;
    for (const Vec4d& color : solve(Equations(level, places, stiffness * mean_weight), std::move(start)))
        colors.emplace_back(clamp(color, Vec4d(0.0), Vec4d(255.0)) + 0.5);
    return colors;
}

}  // namespace lodestream::scene
