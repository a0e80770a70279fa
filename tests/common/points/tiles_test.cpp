#include "common/points/tiles.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/random.h"
#include "common/points/order.h"

namespace lodestream::points {
namespace {

PointCloud random_cloud(std::size_t count) {
    Random random(11);
    PointCloud cloud;
    for (std::size_t i = 0; i < count; ++i)
        cloud.positions.emplace_back(random.uniform(), random.uniform(0, 0.1), random.uniform());
    return cloud;
}

TEST(PointTiles, HoldEveryPointOnceInTheCloudsOrderAndInTheirBoxes) {
    const PointCloud cloud = random_cloud(200'000);
    const std::vector<Tile> tiles = tiles_of(cloud);
    std::vector<int> seen(cloud.positions.size(), 0);
    ASSERT_GT(tiles.size(), 8u);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const Tile& tile = tiles[i];
        EXPECT_TRUE(std::ranges::is_sorted(tile.points));
        EXPECT_LE(tile.points.size(), points_per_tile);
        EXPECT_FALSE(tile.points.empty());
        for (const std::uint32_t point : tile.points) ++seen[point];
        for (std::uint32_t at = static_cast<std::uint32_t>(i); at != no_tile; at = tiles[at].parent)
            for (const std::uint32_t point : tile.points) {
                const Vec3d p(cloud.positions[point]);
                ASSERT_TRUE(tiles[at].box.min == min(tiles[at].box.min, p) &&
                            tiles[at].box.max == max(tiles[at].box.max, p));
            }
        for (std::uint32_t k = 0; k < tile.child_count; ++k) {
            EXPECT_EQ(tiles[tile.first_child + k].parent, i);
            EXPECT_GE(tiles[tile.first_child + k].shown, tile.shown);
        }
    }
    EXPECT_EQ(std::ranges::count(seen, 1), std::ssize(seen));
}

// What makes a tile a level of its place: nothing in the box is farther from its points than in the cloud's own prefix.
TEST(PointTiles, ShowTheirBoxesAsThatPrefixOfTheCloudDoes) {
    const PointCloud cloud = order(random_cloud(60'000), 60'000).cloud;
    const std::vector<Tile> tiles = tiles_of(cloud);
    for (std::uint32_t i = 0; i < tiles.size(); ++i) {
        if (tiles[i].child_count == 0) continue;
        std::vector<bool> shown(cloud.positions.size(), false);
        for (std::uint32_t at = i; at != no_tile; at = tiles[at].parent)
            for (const std::uint32_t point : tiles[at].points) shown[point] = true;
        for (std::uint32_t k = 0; k < tiles[i].child_count; ++k)
            for (const std::uint32_t point : tiles[tiles[i].first_child + k].points) ASSERT_GE(point, tiles[i].shown);
        EXPECT_TRUE(shown[tiles[i].shown - 1]);
    }
}

TEST(PointTiles, OfNoneOneAndCoincidentPointsEnd) {
    EXPECT_TRUE(tiles_of({}).empty());
    EXPECT_EQ(tiles_of(random_cloud(1)).size(), 1u);
    PointCloud same;
    same.positions.assign(40'000, Vec3f(1, 2, 3));
    std::size_t points = 0;
    for (const Tile& tile : tiles_of(same)) points += tile.points.size();
    EXPECT_EQ(points, 40'000u);
    PointCloud crowded;  // each half of the rest in the corner: deeper than any tree may be
    for (int i = 0; i < 120; ++i)
        for (int k = 0; k < 2'000; ++k) crowded.positions.emplace_back(std::ldexp(1.0f + 0.0001f * k, -i), 0.0f, 0.0f);
    points = 0;
    for (const Tile& tile : tiles_of(crowded)) points += tile.points.size();
    EXPECT_EQ(points, crowded.positions.size());
}

TEST(PointTiles, CarryTheAttributesOfTheirPoints) {
    PointCloud cloud = random_cloud(20'000);
    for (std::size_t i = 0; i < 20'000; ++i) cloud.colors.emplace_back(i % 256, i / 256, 0, 255);
    const std::vector<Tile> tiles = tiles_of(cloud);
    const PointCloud part = points_of(cloud, tiles.back());
    ASSERT_EQ(part.colors.size(), tiles.back().points.size());
    EXPECT_TRUE(part.normals.empty());
    EXPECT_EQ(part.colors[1], cloud.colors[tiles.back().points[1]]);
    EXPECT_EQ(part.positions[1], cloud.positions[tiles.back().points[1]]);
}

}  // namespace
}  // namespace lodestream::points
