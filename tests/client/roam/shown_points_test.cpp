#include "client/roam/shown_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/points/tiles.h"

namespace lodestream::roam {
namespace {

struct Tiled {
    scene::LodTree tree;
    std::vector<codec::Points> contents;
};

// As a bake of a cloud leaves them.
Tiled tiles_of(const points::PointCloud& cloud, const Vec3d& origin) {
    Tiled tiled;
    for (const points::Tile& tile : points::tiles_of(cloud)) {
        scene::LodNode node;
        node.box = {tile.box.min + origin, tile.box.max + origin};
        node.parent = tile.parent == points::no_tile ? scene::none : tile.parent;
        node.first_child = tile.first_child;
        node.child_count = tile.child_count;
        tiled.tree.push_back(node);
        codec::Points content;
        content.cloud = points::points_of(cloud, tile);
        content.origin = origin;
        content.levels = {{content.cloud.positions.size(), {}, 0.5 / static_cast<double>(tiled.tree.size())}};
        tiled.contents.push_back(std::move(content));
    }
    return tiled;
}

points::PointCloud random_cloud(std::size_t count) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> place(-1.0f, 1.0f);
    points::PointCloud cloud;
    for (std::size_t i = 0; i < count; ++i) cloud.positions.emplace_back(place(random), place(random), place(random));
    return cloud;
}

codec::Points shown_by(const Tiled& tiled, std::uint32_t node) {
    const std::vector<std::uint32_t> path = path_to(tiled.tree, node);
    std::vector<codec::Points> contents;
    for (const std::uint32_t n : path) contents.push_back(tiled.contents[n]);
    return roam::shown_by(branches_of(tiled.tree, path), contents);
}

std::vector<std::array<float, 3>> sorted(const std::vector<Vec3f>& positions) {
    std::vector<std::array<float, 3>> out;
    for (const Vec3f& p : positions) out.push_back({p.x, p.y, p.z});
    std::ranges::sort(out);
    return out;
}

TEST(ShownPoints, TheFinestTilesTogetherShowEveryPointOnce) {
    const points::PointCloud cloud = random_cloud(150'000);
    const Tiled tiled = tiles_of(cloud, {1e6, 0.0, 0.0});
    ASSERT_GT(tiled.tree.size(), 9u);
    std::vector<Vec3f> shown;
    for (std::uint32_t node = 0; node < tiled.tree.size(); ++node) {
        if (tiled.tree[node].child_count > 0) continue;
        const codec::Points points = shown_by(tiled, node);
        EXPECT_EQ(points.levels.front().radius, tiled.contents[node].levels.front().radius);
        EXPECT_EQ(points.origin, Vec3d(1e6, 0.0, 0.0));
        shown.insert(shown.end(), points.cloud.positions.begin(), points.cloud.positions.end());
    }
    EXPECT_EQ(sorted(shown), sorted(cloud.positions));
}

TEST(ShownPoints, ChildrenTogetherShowWhatTheirParentDoesAndTheirOwn) {
    const Tiled tiled = tiles_of(random_cloud(150'000), Vec3d(0.0));
    const scene::LodNode& root = tiled.tree[0];
    EXPECT_EQ(shown_by(tiled, 0).cloud.positions.size(), points::points_per_tile);
    std::size_t shown = 0, own = points::points_per_tile;
    for (std::uint32_t child = root.first_child; child < root.first_child + root.child_count; ++child) {
        shown += shown_by(tiled, child).cloud.positions.size();
        own += tiled.contents[child].cloud.positions.size();
    }
    EXPECT_EQ(shown, own);
}

TEST(ShownPoints, TilesOfOtherAttributesAreDrawnTogether) {
    Tiled tiled = tiles_of(random_cloud(20'000), Vec3d(0.0));
    codec::Points& root = tiled.contents[0];
    root.base_color = {0.5f, 0.0f, 0.0f, 1.0f};
    root.cloud.normals.assign(root.cloud.positions.size(), Vec3f(0.0f, 1.0f, 0.0f));
    const std::uint32_t child = tiled.tree[0].first_child;
    tiled.contents[child].cloud.colors.assign(tiled.contents[child].cloud.positions.size(), Rgba8(0, 0, 255, 255));
    const codec::Points points = shown_by(tiled, child);
    ASSERT_EQ(points.cloud.colors.size(), points.cloud.positions.size());
    ASSERT_EQ(points.cloud.normals.size(), points.cloud.positions.size());
    EXPECT_EQ(points.base_color, Vec4f(1.0f));
    EXPECT_EQ(points.cloud.colors.front(), Rgba8(128, 0, 0, 255));  // the root's come first
    EXPECT_EQ(points.cloud.normals.front(), Vec3f(0.0f, 1.0f, 0.0f));
    EXPECT_EQ(points.cloud.colors.back(), Rgba8(0, 0, 255, 255));
    EXPECT_EQ(points.cloud.normals.back(), Vec3f(0.0f));
}

}  // namespace
}  // namespace lodestream::roam
