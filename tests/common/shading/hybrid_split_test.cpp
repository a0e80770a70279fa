#include "common/shading/hybrid_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "common/shading/importance.h"
#include "tests/support/meshes.h"

namespace lodestream::shading {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// The order that a sphere's own importance gives.
std::vector<std::uint32_t> sphere_order(const mesh::Mesh& mesh) {
    return order_by_gain(importance(mesh, {}, {.view = View{{0, 10, 0}, {0, 0, 0}, 45.0, {0, 1, 0}}}).gain);
}

std::vector<std::uint32_t> identity_order(std::size_t count) {
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    return order;
}

std::uint64_t count_gouraud(const std::vector<std::uint8_t>& labels) {
    return static_cast<std::uint64_t>(std::count(labels.begin(), labels.end(), std::uint8_t{1}));
}

mesh::Mesh two_apart(const mesh::Mesh& first, const mesh::Mesh& second) {
    mesh::Mesh result = first;
    const auto base = static_cast<std::uint32_t>(first.positions.size());
    for (const Vec3f& p : second.positions) result.positions.push_back(p + Vec3f(100, 0, 0));
    for (const mesh::Triangle& t : second.triangles)
        result.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    result.normals.clear();
    return result;
}

std::size_t border_length(const mesh::Mesh& mesh, const std::vector<std::uint8_t>& labels) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::set<std::uint8_t>> sides;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int i = 0; i < 3; ++i)
            sides[std::minmax(mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3])].insert(labels[t]);
    return static_cast<std::size_t>(
        std::count_if(sides.begin(), sides.end(), [](const auto& side) { return side.second.size() > 1; }));
}

TEST(GouraudCount, RoundsTheNearShare) {
    EXPECT_EQ(gouraud_count(6400, 0.0), 6400u);
    EXPECT_EQ(gouraud_count(6400, 1.0), 0u);
    EXPECT_EQ(gouraud_count(564, 0.4), 338u);
    EXPECT_EQ(gouraud_count(3, 0.5), 2u);
    EXPECT_EQ(gouraud_count(10, -3.0), 10u);
    EXPECT_EQ(gouraud_count(10, 7.0), 0u);
    EXPECT_EQ(gouraud_count(0, 0.3), 0u);
}

TEST(CoherentSplit, CountIsExactForEveryShareAndRegionCount) {
    const mesh::Mesh meshes[] = {testing::sphere(9), testing::flat_grid(6), testing::single_triangle(),
                                 two_apart(testing::sphere(5), testing::tetrahedron())};
    for (const mesh::Mesh& mesh : meshes) {
        const std::size_t count = mesh.triangles.size();
        std::vector<std::uint32_t> order = identity_order(count);
        std::reverse(order.begin(), order.end());
        for (const std::uint32_t regions : {0u, 1u, 2u, 7u, 64u, 1'000'000u})
            for (std::uint64_t gouraud = 0; gouraud <= count; ++gouraud)
                ASSERT_EQ(count_gouraud(coherent_split(mesh, order, gouraud, regions)), gouraud) << regions;
        EXPECT_EQ(count_gouraud(coherent_split(mesh, order, count + 5, 4)), count);
    }
}

TEST(CoherentSplit, WithoutRegionsTakesTheFirstOfTheOrder) {
    const mesh::Mesh mesh = testing::sphere(7);
    const auto order = sphere_order(mesh);
    std::vector<std::uint8_t> smaller(order.size(), 0);
    for (std::uint64_t gouraud = 0; gouraud <= order.size(); ++gouraud) {
        const auto labels = coherent_split(mesh, order, gouraud, 0);
        for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(labels[order[i]], i < gouraud ? 1 : 0);
        for (std::size_t t = 0; t < order.size(); ++t) EXPECT_LE(smaller[t], labels[t]);
        smaller = labels;
    }
}

TEST(CoherentSplit, FewerRegionsHaveAShorterBorder) {
    const mesh::Mesh mesh = testing::flat_grid(40);
    std::vector<std::uint32_t> order;  // every other triangle first: the most ragged split there is
    for (const std::uint32_t first : {0u, 1u})
        for (std::uint32_t t = first; t < mesh.triangles.size(); t += 2) order.push_back(t);
    const auto border = [&](std::uint32_t regions) {
        return border_length(mesh, coherent_split(mesh, order, mesh.triangles.size() / 2, regions));
    };
    EXPECT_GT(border(0), 1000u);
    EXPECT_LT(border(64), border(0) / 3);
    EXPECT_LE(border(1), 82u);  // a straight cut passes 40 edges, or 80 with the diagonals
}

TEST(CoherentSplit, FollowsTheOrder) {
    const mesh::Mesh mesh = testing::flat_grid(32);  // rows from low z to high
    const std::size_t half = mesh.triangles.size() / 2;
    const auto labels = coherent_split(mesh, identity_order(mesh.triangles.size()), half, 16);
    EXPECT_GT(std::accumulate(labels.begin(), labels.begin() + static_cast<std::ptrdiff_t>(half), std::size_t{0}),
              half * 9 / 10);
}

TEST(CoherentSplit, SmallPiecesStayWhole) {
    const mesh::Mesh mesh = two_apart(testing::tetrahedron(), testing::sphere(12));
    std::vector<std::uint32_t> order = identity_order(mesh.triangles.size());
    const auto labels = coherent_split(mesh, order, 30, 4);
    EXPECT_EQ(std::accumulate(labels.begin(), labels.begin() + 4, 0) % 4, 0);
}

TEST(CoherentSplit, SurvivesDegenerateGeometry) {
    mesh::Mesh mesh;
    for (int i = 0; i < 40; ++i) mesh.positions.emplace_back(i % 2 ? nan : 0.0f);
    for (std::uint32_t i = 0; i + 2 < 40; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
    for (std::uint32_t i = 0; i < 200; ++i) mesh.triangles.push_back({0, 1, i % 40});  // a fan on one edge
    const auto order = identity_order(mesh.triangles.size());
    for (const std::uint32_t regions : {1u, 3u, 50u})
        EXPECT_EQ(count_gouraud(coherent_split(mesh, order, 77, regions)), 77u);
    for (Vec3f& p : mesh.positions) p = Vec3f(3e38f);
    EXPECT_EQ(count_gouraud(coherent_split(mesh, order, 77, 8)), 77u);
}

TEST(CoherentSplit, IsDeterministic) {
    const mesh::Mesh mesh = testing::sphere(20);
    const auto order = sphere_order(mesh);
    EXPECT_EQ(coherent_split(mesh, order, 300, 16), coherent_split(mesh, order, 300, 16));
}

TEST(RegionCounts, FallToOneAndKeepRegionsLarge) {
    EXPECT_EQ(region_counts_to_try(100'000), (std::vector<std::uint32_t>{256, 64, 16, 4, 1}));
    EXPECT_EQ(region_counts_to_try(564), (std::vector<std::uint32_t>{4, 1}));
    EXPECT_TRUE(region_counts_to_try(10).empty());
}

}  // namespace
}  // namespace lodestream::shading
