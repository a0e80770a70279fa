#include "common/points/level.h"

#include "common/points/resample.h"
#include "tests/support/meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <span>

namespace lodestream::points {
namespace {

OrderedCloud ordered_sphere(const mesh::Mesh& mesh, std::uint64_t count) {
    return order(resample(mesh, choose_parameters(mesh, count)), count);
}

TEST(Level, PrefixOfMoreThanThereAreIsAll) {
    PointCloud cloud;
    cloud.positions = {{0, 0, 0}, {1, 0, 0}};
    EXPECT_EQ(prefix(cloud, 5).positions.size(), 2u);
    EXPECT_EQ(prefix(cloud, 1).positions.size(), 1u);
    EXPECT_TRUE(prefix(cloud, 1).colors.empty());
}

TEST(Level, ErrorIsMeasuredBothWays) {
    const mesh::Mesh mesh = testing::single_triangle();
    const metric::SurfaceIndex index(mesh);
    PointCloud corner;
    corner.positions = {{0, 0, 0}};
    EXPECT_NEAR(measure(index, mesh, corner, 1).max, 1.0, 1e-6);  // of the surface to the point
    PointCloud above = corner;
    above.positions = {{0, 0, 5}};
    EXPECT_GT(measure(index, mesh, above, 1).max, 5.0);
}

TEST(Level, NoPointsHaveTheErrorOfTheWholeDiagonal) {
    const mesh::Mesh mesh = testing::single_triangle();
    EXPECT_DOUBLE_EQ(measure(metric::SurfaceIndex(mesh), mesh, {}, 0).max, std::sqrt(2.0));
    EXPECT_TRUE(measured_levels(metric::SurfaceIndex(mesh), mesh, {}).empty());
}

TEST(Level, HalvesAreMeasuredFinestFirst) {
    const mesh::Mesh mesh = testing::sphere(40);
    const metric::SurfaceIndex index(mesh);
    const OrderedCloud ordered = ordered_sphere(mesh, 4000);
    const std::vector<Level> levels = measured_levels(index, mesh, ordered);
    ASSERT_EQ(levels.size(), 7u);
    EXPECT_EQ(levels[0].points, 4000u);
    EXPECT_EQ(levels[5].points, 125u);
    EXPECT_EQ(levels[6].points, 1u);
    for (std::size_t k = 0; k < levels.size(); ++k) {
        EXPECT_LT(levels[k].error.max, 1.3 * levels[k].radius);
        EXPECT_LE(levels[k].error.rms, levels[k].error.max);
    }
    for (std::size_t k = 1; k < levels.size(); ++k) {
        EXPECT_GE(levels[k].error.max, levels[k - 1].error.max);
        EXPECT_GT(levels[k].radius, levels[k - 1].radius);
    }
}

// Every place twice, a hair apart: the finest level's last points are the twins of others.
TEST(Level, AUsedUpCloudStillCoversItsSurface) {
    const mesh::Mesh mesh = testing::sphere(40);
    PointCloud cloud = resample(mesh, choose_parameters(mesh, 2000));
    const std::size_t once = cloud.positions.size();
    for (std::size_t i = 0; i < once; ++i) {
        cloud.positions.push_back(cloud.positions[i] * 1.0001f);
        cloud.normals.push_back(cloud.normals[i]);
    }
    const std::vector<Level> levels = measured_levels(metric::SurfaceIndex(mesh), mesh, order(cloud, ~0ull));
    EXPECT_GT(levels[0].points, once);
    EXPECT_GT(levels[0].radius, 0.02);  // of about 4,000 places on the unit sphere
    EXPECT_LT(levels[0].radius, 0.2);
}

TEST(Level, BetweenTwoMeasuredOnes) {
    const std::vector<Level> levels{{400, {1, 2}, 1.0}, {200, {2, 3}, 1.4}, {100, {4, 6}, 2.0}};
    EXPECT_EQ(level_of(levels, 1000).points, 400u);
    EXPECT_EQ(level_of(levels, 1000).error.rms, 1.0);
    EXPECT_EQ(level_of(levels, 300).error.rms, 2.0);
    EXPECT_NEAR(level_of(levels, 300).radius, std::sqrt(400.0 / 300.0), 1e-12);
    EXPECT_EQ(level_of(levels, 200).radius, 1.4);
    EXPECT_EQ(level_of(levels, 25).error.max, 6.0);
    EXPECT_NEAR(level_of(levels, 25).radius, 4.0, 1e-12);
    EXPECT_EQ(level_of(levels, 0).points, 0u);
}

// Of a long thin model's points half as many are farther apart than by the square root of two, or less.
TEST(Level, NoLevelHasLargerDiscsThanACoarserOne) {
    const std::vector<Level> levels{{400, {1, 2}, 1.0}, {200, {2, 3}, 1.1}, {100, {4, 6}, 2.0}};
    for (std::uint64_t points = 399; points > 100; --points)
        EXPECT_LE(level_of(levels, points + 1).radius, level_of(levels, points).radius) << points;
}

TEST(Level, AsManyPointsAsMakeDiscsOfARadius) {
    const std::vector<Level> levels{{400, {1, 2}, 1.0}, {200, {2, 3}, 1.4}, {100, {4, 6}, 2.0}};
    EXPECT_EQ(points_for(levels, 1.4), 200u);
    EXPECT_EQ(points_for(levels, 3.0), 100u);  // coarser levels are not told of
    for (const double finer : {0.5, 0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_EQ(points_for(levels, finer), 400u) << finer;
    for (const double radius : {1.05, 1.3, 1.41, 1.99}) {
        const std::uint64_t points = points_for(levels, radius);
        EXPECT_LE(level_of(levels, points).radius, radius);
        EXPECT_GT(level_of(levels, points - 1).radius, radius);
    }
    EXPECT_EQ(points_for(std::span(levels).first(1), 9.0), 400u);
}

}  // namespace
}  // namespace lodestream::points
