#include "common/scene/fit_colors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "tests/support/meshes.h"

namespace lodestream::scene {
namespace {

// An n x n grid of the unit square whose colour depends on the place.
template <class Color>
mesh::Mesh square(std::uint32_t n, Color color) {
    mesh::Mesh mesh = testing::flat_grid(n);
    for (Vec3f& p : mesh.positions) {
        p /= static_cast<float>(n);
        mesh.colors.push_back(color(p.x, p.z));
    }
    return mesh;
}

Rgba8 grey(double value) {
    const auto byte = static_cast<std::uint8_t>(value + 0.5);
    return {byte, byte, byte, 255};
}

TEST(FitColors, FindsAGradientThatItCanShow) {
    const auto gradient = [](double x, double z) { return grey(255.0 * (0.5 * x + 0.5 * z)); };
    const mesh::Mesh source = square(64, gradient);
    mesh::Mesh level = square(2, [](double, double) { return grey(255); });
    const std::vector<Rgba8> colors = fit_colors(level, source);
    for (std::size_t v = 0; v < colors.size(); ++v) {
        const Rgba8 wanted = gradient(level.positions[v].x, level.positions[v].z);
        for (int k = 0; k < 4; ++k) EXPECT_LE(std::abs(colors[v][k] - wanted[k]), 4) << v;
    }
}

TEST(FitColors, FineNoiseBecomesItsMean) {
    std::mt19937 random(5);
    const mesh::Mesh source = square(128, [&](double, double) { return grey(random() % 2 == 0 ? 255 : 0); });
    const mesh::Mesh level = square(2, [](double, double) { return grey(0); });
    double sum = 0.0;
    const std::vector<Rgba8> colors = fit_colors(level, source);
    for (const Rgba8& color : colors) sum += color.x;
    EXPECT_NEAR(sum / static_cast<double>(colors.size()), 127, 30);
}

// The mean squared difference between what the level's triangles show and a colour that depends on x.
template <class Color>
double mean_square(const mesh::Mesh& level, const std::vector<Rgba8>& colors, Color color) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    constexpr int places = 200;
    double sum = 0.0;
    for (const auto& [a, b, c] : level.triangles)
        for (int i = 0; i < places; ++i) {
            const double u = std::sqrt(unit(random)), v = unit(random);
            const Vec3d w{1.0 - u, u * (1.0 - v), u * v};
            const double x = w.x * level.positions[a].x + w.y * level.positions[b].x + w.z * level.positions[c].x;
            const double shown = w.x * colors[a].x + w.y * colors[b].x + w.z * colors[c].x;
            sum += (shown - color(x, 0.0).x) * (shown - color(x, 0.0).x);
        }
    return sum / (places * static_cast<double>(level.triangles.size()));
}

TEST(FitColors, ShowsASharpBorderBetterThanTheColoursAtTheVertices) {
    const auto border = [](double x, double) { return grey(x < 0.36 ? 0 : 255); };
    const mesh::Mesh source = square(64, border), level = square(3, border);
    EXPECT_LT(mean_square(level, fit_colors(level, source), border), 0.8 * mean_square(level, level.colors, border));
}

TEST(FitColors, KeepsColoursWhereNothingTells) {
    const mesh::Mesh source = square(4, [](double, double) { return grey(10); });
    mesh::Mesh line = testing::single_triangle();
    line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    line.colors.assign(3, grey(99));
    EXPECT_EQ(fit_colors(line, source), line.colors);

    mesh::Mesh unused = square(2, [](double, double) { return grey(50); });
    unused.positions.push_back({9, 9, 9});
    unused.colors.push_back(grey(201));
    EXPECT_EQ(fit_colors(unused, source).back(), grey(201));
}

}  // namespace
}  // namespace lodestream::scene
