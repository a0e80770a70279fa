#include "server/bake/tile_tree.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/base/transform.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::bake {
namespace {

TileTree small_tree() {
    TileTree tree;
    tree.nodes.resize(3);
    for (scene::LodNode& node : tree.nodes) {
        node.box.add({0, 0, 0});
        node.box.add({1, 2, 3});
        node.triangles = 7;
    }
    tree.nodes[0].error = 0.5;
    tree.nodes[0].first_child = 1;
    tree.nodes[0].child_count = 2;
    tree.nodes[1].parent = tree.nodes[2].parent = 0;
    tree.hashes.assign(3, std::string(64, 'a'));
    tree.bytes = {10, 20, 30};
    return tree;
}

TEST(TileTree, ComesBackAsItWent) {
    const TileTree tree = small_tree();
    const Result<TileTree> back = open_tile_tree(serialize(tree));
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->hashes, tree.hashes);
    EXPECT_EQ(back->bytes, tree.bytes);
    EXPECT_EQ(back->nodes[0].box.max, tree.nodes[0].box.max);
    EXPECT_EQ(serialize(*back), serialize(tree));
}

TEST(TileTree, RefusesEveryTruncationAndSurvivesEveryFlippedByte) {
    const std::vector<std::byte> bytes = serialize(small_tree());
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(open_tile_tree(std::span(bytes).first(size)).ok()) << size;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        std::vector<std::byte> damaged = bytes;
        damaged[i] ^= std::byte{0xff};
        const Result<TileTree> tree = open_tile_tree(damaged);
        EXPECT_TRUE(!tree.ok() || scene::validate(tree->nodes).ok());
    }
}

TEST(TileTree, PlacesComeBackAndOlderTreesHaveNone) {
    TileTree tree = small_tree();
    const std::vector<std::byte> without = serialize(tree);
    for (std::size_t i = 0; i < tree.nodes.size(); ++i)
        tree.matrices.push_back(translation(Vec3d(static_cast<double>(i), 0, 0)));
    EXPECT_EQ(open_tile_tree(serialize(tree))->matrices, tree.matrices);

    std::vector<std::byte> older(without.begin(), without.end() - sizeof(std::uint64_t));  // the count of none
    older[7] = std::byte{'1'};
    const Result<TileTree> back = open_tile_tree(older);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_TRUE(back->matrices.empty());
    EXPECT_EQ(back->hashes, tree.hashes);
}

TEST(TileTree, RefusesTooFewPlacesAndThoseThatAreNone) {
    TileTree tree = small_tree();
    tree.matrices.assign(1, Mat4d(1.0));
    EXPECT_FALSE(open_tile_tree(serialize(tree)).ok());
    tree.matrices.assign(tree.nodes.size(), Mat4d(1.0));
    tree.matrices.back()[0][0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(open_tile_tree(serialize(tree)).ok());
    tree.matrices.back() = Mat4d(0.0);
    EXPECT_FALSE(open_tile_tree(serialize(tree)).ok());
}

TEST(TileTree, RefusesAHashThatIsAPath) {
    TileTree tree = small_tree();
    tree.hashes[1] = "../" + std::string(61, 'a');
    EXPECT_FALSE(open_tile_tree(serialize(tree)).ok());
}

struct ChainTest : ::testing::Test {
    testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());
    proto::Asset asset = ladder();

    static proto::Asset ladder() {
        proto::Asset asset;
        asset.id = asset.name = "ladder";
        asset.status = proto::AssetStatus::ready;
        asset.bounds_min = {{1.0, 2.0, 3.0}};
        asset.bounds_max = {{3.0, 6.0, 13.0}};
        for (const double error : {0.0, 0.5, 0.25, 2.0}) {
            proto::Level level;
            level.max_error = error;
            level.url = "/v1/content/" + std::string(64, static_cast<char>('0' + asset.levels.size())) + ".glb";
            asset.levels.push_back(level);
        }
        return asset;
    }
};

TEST_F(ChainTest, IsTheLadderFromCoarsestToFinestAndErrorsNeverFallTowardsTheRoot) {
    const Result<TileTree> tree = load_tiles(store, asset);
    ASSERT_TRUE(tree.ok()) << tree.error().message;
    ASSERT_TRUE(scene::validate(tree->nodes).ok());
    ASSERT_EQ(tree->nodes.size(), 4u);
    const std::vector<double> errors{2.0, 0.5, 0.5, 0.0};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(tree->nodes[i].error, errors[i]);
        EXPECT_EQ(tree->hashes[i], std::string(64, static_cast<char>('3' - i)));
    }
}

TEST_F(ChainTest, NeedsAReadyAssetWithBoundsAndLevels) {
    asset.bounds_max.reset();
    EXPECT_EQ(load_tiles(store, asset).error().code, ErrorCode::conflict);
    asset = ladder();
    asset.levels.clear();
    EXPECT_EQ(load_tiles(store, asset).error().code, ErrorCode::conflict);
    asset = ladder();
    asset.status = proto::AssetStatus::baking;
    EXPECT_EQ(load_tiles(store, asset).error().code, ErrorCode::unavailable);
    asset.status = proto::AssetStatus::failed;
    asset.error = "lightning";
    EXPECT_NE(load_tiles(store, asset).error().message.find("lightning"), std::string::npos);
}

}  // namespace
}  // namespace lodestream::bake
