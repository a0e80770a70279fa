#include "server/importer/polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lodestream::importer {
namespace {

constexpr std::uint64_t plenty = 100'000'000;

// Twice the signed areas along z.
double cross_z(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}
double outline_area(const std::vector<Vec3d>& p) {
    double sum = 0;
    for (std::size_t i = 1; i + 1 < p.size(); ++i) sum += cross_z(p[0], p[i], p[i + 1]);
    return sum;
}

// Triangles that all face the outline's way and add up to its area cover it exactly once.
void expect_cut_exactly(const std::vector<Vec3d>& p) {
    std::vector<mesh::Triangle> triangles;
    std::uint64_t work = 0;
    triangulate(p, triangles, work, plenty);
    ASSERT_EQ(triangles.size(), p.size() - 2);
    double sum = 0;
    for (const auto& [a, b, c] : triangles) {
        const double area = cross_z(p[a], p[b], p[c]);
        EXPECT_GE(area * outline_area(p), 0) << a << " " << b << " " << c;
        sum += std::abs(area);
    }
    EXPECT_NEAR(sum, std::abs(outline_area(p)), 1e-9 * sum);
}

TEST(Polygon, ConcaveQuadIsCutAlongItsInnerDiagonal) {
    expect_cut_exactly({{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {0, 4, 0}});
    expect_cut_exactly({{4, 0, 0}, {1, 1, 0}, {0, 4, 0}, {0, 0, 0}});
}

TEST(Polygon, ClockwiseOutlineKeepsItsDirection) {
    expect_cut_exactly({{0, 0, 0}, {0, 3, 0}, {1, 1, 0}, {3, 3, 0}, {3, 0, 0}});
}

TEST(Polygon, CombIsCutExactly) {
    std::vector<Vec3d> comb;
    for (int i = 0; i < 40; ++i) comb.push_back({i, i % 2 ? 0.1 : 5.0, 0});
    comb.push_back({40, -1, 0});
    comb.push_back({-1, -1, 0});
    expect_cut_exactly(comb);
}

TEST(Polygon, SpiralIsCutExactly) {
    std::vector<Vec3d> spiral;
    for (int i = 0; i <= 200; ++i)
        spiral.push_back({(1 + 0.02 * i) * std::cos(0.1 * i), (1 + 0.02 * i) * std::sin(0.1 * i), 0});
    for (int i = 200; i >= 0; --i)
        spiral.push_back({(1.03 + 0.02 * i) * std::cos(0.1 * i), (1.03 + 0.02 * i) * std::sin(0.1 * i), 0});
    expect_cut_exactly(spiral);
}

TEST(Polygon, StarShapedOutlinesAreCutExactly) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> radius(0.1, 1.0);
    for (int round = 0; round < 100; ++round) {
        std::vector<Vec3d> star;
        const int corners = 5 + round % 60;
        for (int i = 0; i < corners; ++i) {
            const double r = radius(random), angle = 2 * pi * i / corners;
            star.push_back({r * std::cos(angle), r * std::sin(angle), 0});
        }
        expect_cut_exactly(star);
    }
}

TEST(Polygon, BridgedHoleIsLeftOpen) {
    // A square with a square hole, joined by an edge that is walked twice.
    expect_cut_exactly(
        {{0, 0, 0}, {6, 0, 0}, {6, 6, 0}, {0, 6, 0}, {0, 0, 0}, {2, 2, 0}, {2, 4, 0}, {4, 4, 0}, {4, 2, 0}, {2, 2, 0}});
}

TEST(Polygon, HugeAndTinyOutlinesAreCutAlike) {
    for (const double scale : {1e-30, 1e30}) {
        std::vector<mesh::Triangle> triangles;
        std::uint64_t work = 0;
        std::vector<Vec3d> outline = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 1, 0}, {0, 4, 0}};
        for (Vec3d& p : outline) p *= scale;
        triangulate(outline, triangles, work, plenty);
        ASSERT_EQ(triangles.size(), 3u);
        for (const auto& [a, b, c] : triangles)
            EXPECT_GT(cross_z(outline[a] / scale, outline[b] / scale, outline[c] / scale), 0);
    }
}

TEST(Polygon, FlatOrCrossingOutlineStillGivesAllItsTriangles) {
    for (const std::vector<Vec3d>& outline :
         {std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {1.5, 0, 0}},
          std::vector<Vec3d>{{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}, {1, 5, 0}}}) {
        std::vector<mesh::Triangle> triangles;
        std::uint64_t work = 0;
        triangulate(outline, triangles, work, plenty);
        EXPECT_EQ(triangles.size(), 3u);
    }
}

TEST(Polygon, HostileOutlineEndsWhenItsWorkIsUsedUp) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> at(-1, 1);
    std::vector<Vec3d> tangle;
    for (int i = 0; i < 20'000; ++i) tangle.push_back({at(random), at(random), at(random)});
    std::vector<mesh::Triangle> triangles;
    std::uint64_t work = 0;
    triangulate(tangle, triangles, work, 1'000'000);
    EXPECT_EQ(triangles.size(), tangle.size() - 2);
    EXPECT_LT(work, 1'000'000'000u);
}

}  // namespace
}  // namespace lodestream::importer
