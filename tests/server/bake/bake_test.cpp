#include "server/bake/bake.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/base/transform.h"
#include "common/mesh/operations.h"
#include "server/bake/textures.h"
#include "server/bake/tile_tree.h"
#include "tests/common/texture/textured.h"
#include "tests/support/meshes.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::bake {
namespace {

mesh::Model sphere_model(std::uint32_t n) {
    mesh::Model model;
    model.mesh = testing::sphere(n);
    model.materials.resize(1);
    return model;
}

proto::Asset named(const std::string& name) {
    proto::Asset asset;
    asset.id = asset.name = name;
    return asset;
}

BakedModel small_baked() {
    mesh::Model model = sphere_model(6);
    model.materials[0].name = "clay";
    model.materials[0].base_color_texture.image = 0;
    model.images = {{"image/png", std::vector<std::byte>(5, std::byte{7}), 1, 1}};
    model.origin = {1e7, 2, 3};
    BakedModel baked = describe_model(model);
    set_history(baked, *simplify::record_history(std::move(model.mesh)));
    baked.errors = {{60, {0.0, 0.0, 0.0}}, {30, {0.1, 0.2, 3.0}}};
    return baked;
}

struct BakeTest : ::testing::Test {
    testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());
};

// As an importer makes it of a file whose nodes all show one mesh.
TEST_F(BakeTest, ASceneOfInstancesAloneIsBaked) {
    mesh::Model model = testing::empty_scene();
    model.kind = mesh::Kind::scene;
    model.shapes.push_back(testing::sphere(10));
    for (std::uint32_t i = 0; i < 8; ++i) {
        model.instances.push_back({i, 0, translation({3.0 * i, 0, 0})});
        model.graph.object_nodes.push_back(0);
    }
    model.objects = 8;
    const std::uint64_t triangles = 8 * model.shapes[0].triangles.size();
    const Result<proto::Asset> baked = bake(store, named("row"), model);
    ASSERT_TRUE(baked.ok()) << baked.error().message;
    EXPECT_EQ(baked->triangles, triangles);
    EXPECT_EQ(baked->levels.front().triangles, triangles);
    const Result<TileTree> tree = load_tiles(store, *baked);
    ASSERT_TRUE(tree.ok()) << tree.error().message;
    EXPECT_EQ(std::ranges::count(tree->hashes, tree->hashes.back()), 8);
}

TEST(BakedModel, ComesBackAsItWent) {
    const BakedModel baked = small_baked();
    const std::vector<std::byte> bytes = serialize(baked);
    const Result<BakedView> back = open_baked_model(bytes);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->model.origin, baked.model.origin);
    EXPECT_EQ(back->model.materials[0].name, "clay");
    EXPECT_EQ(back->grid_bounds.max, baked.grid_bounds.max);
    EXPECT_EQ(back->errors[1].error.max, 0.2);
    EXPECT_EQ(back->errors[1].error.normal_degrees, 3.0);
    for (const std::uint64_t n : {1u, 17u, 60u}) {
        const mesh::Mesh before = simplify::cut(baked.history, n), after = simplify::cut(back->history, n);
        EXPECT_EQ(after.triangles, before.triangles);
        EXPECT_EQ(after.positions, before.positions);
        EXPECT_EQ(after.normals, before.normals);
    }
}

// As servers stored it before normals were measured.
std::vector<std::byte> as_older(const BakedModel& baked, std::vector<std::byte> bytes) {
    bytes[7] = std::byte{'2'};
    std::vector<std::byte> errors, older_errors;
    const auto add = [](std::vector<std::byte>& to, const auto& value) {
        const auto* data = reinterpret_cast<const std::byte*>(&value);
        to.insert(to.end(), data, data + sizeof value);
    };
    for (const ErrorSample& sample : baked.errors) {
        add(errors, sample);
        add(older_errors, sample.triangles);
        add(older_errors, sample.error.rms);
        add(older_errors, sample.error.max);
    }
    const auto begin = std::search(bytes.begin(), bytes.end(), errors.begin(), errors.end());
    const auto after = bytes.erase(begin, begin + static_cast<std::ptrdiff_t>(errors.size()));
    bytes.insert(after, older_errors.begin(), older_errors.end());
    return bytes;
}

TEST(BakedModel, ReadsWhatAnOlderServerStored) {
    const BakedModel baked = small_baked();
    // Two errors of eight bytes less each: what follows stays at multiples of eight.
    const std::vector<std::byte> bytes = as_older(baked, serialize(baked));
    const Result<BakedView> back = open_baked_model(bytes);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->errors[1].triangles, 30u);
    EXPECT_EQ(back->errors[1].error.max, 0.2);
    EXPECT_EQ(back->errors[1].error.normal_degrees, 0.0);
    EXPECT_EQ(simplify::cut(back->history, 17).triangles, simplify::cut(baked.history, 17).triangles);
}

TEST(BakedModel, RefusesEveryTruncation) {
    const std::vector<std::byte> bytes = serialize(small_baked());
    for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 64)
        EXPECT_FALSE(open_baked_model(std::span(bytes).first(size)).ok()) << size;
    std::vector<std::byte> longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(open_baked_model(longer).ok());
}

TEST(BakedModel, SurvivesEveryFlippedByte) {
    const std::vector<std::byte> bytes = serialize(small_baked());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        std::vector<std::byte> damaged = bytes;
        damaged[i] ^= std::byte{0xff};
        const Result<BakedView> back = open_baked_model(damaged);
        if (!back) continue;
        for (const std::uint64_t n : {1u, 17u, 60u}) EXPECT_LE(simplify::cut(back->history, n).triangles.size(), n);
    }
}

TEST(ErrorOf, IsWhatWasMeasuredWhereItWas) {
    const std::vector<ErrorSample> errors{{100, {0, 0}}, {50, {1, 3}}, {25, {2, 5}}};
    EXPECT_EQ(error_of(errors, 100).rms, 0.0);
    EXPECT_EQ(error_of(errors, 50).rms, 1.0);
    EXPECT_EQ(error_of(errors, 25).max, 5.0);
}

TEST(ErrorOf, IsTheCoarserOnesBetweenWhatWasMeasuredAndNeverFalls) {
    const std::vector<ErrorSample> errors{{100, {0, 0}}, {50, {1, 3}}, {25, {2, 5}}, {1, {5, 9}}};
    EXPECT_EQ(error_of(errors, 35).rms, 2.0);
    EXPECT_EQ(error_of(errors, 35).max, 5.0);
    EXPECT_EQ(error_of(errors, 99).rms, 1.0);
    double before = 0;
    for (std::uint64_t n = 100; n > 0; --n) {
        EXPECT_GE(error_of(errors, n).rms, before);
        before = error_of(errors, n).rms;
    }
    EXPECT_EQ(error_of(errors, 0).max, 9.0);
}

TEST(ErrorOf, NormalsAreBetweenThoseOfTheLevelsAround) {
    const std::vector<ErrorSample> errors{{100, {0, 0, 0}}, {25, {2, 5, 8}}, {1, {5, 9, 0}}};
    EXPECT_EQ(error_of(errors, 200).normal_degrees, 0.0);
    EXPECT_EQ(error_of(errors, 100).normal_degrees, 0.0);
    EXPECT_NEAR(error_of(errors, 50).normal_degrees, 4.0, 1e-9);
    EXPECT_EQ(error_of(errors, 25).normal_degrees, 8.0);
    EXPECT_NEAR(error_of(errors, 5).normal_degrees, 4.0, 1e-9);
    EXPECT_EQ(error_of(errors, 0).normal_degrees, 0.0);
}

TEST_F(BakeTest, LadderHalvesDownToItsFloorAndErrorsGrow) {
    const Result<proto::Asset> asset = bake(store, named("sphere"), sphere_model(40));
    ASSERT_TRUE(asset.ok()) << asset.error().message;
    ASSERT_GE(asset->levels.size(), 5u);
    EXPECT_EQ(asset->levels.front().triangles, 3120u);
    EXPECT_EQ(asset->levels.front().rms_error, 0.0);
    for (std::size_t i = 1; i < asset->levels.size(); ++i) {
        const proto::Level &finer = asset->levels[i - 1], &level = asset->levels[i];
        EXPECT_LE(level.triangles, finer.triangles / 2 + 1);
        EXPECT_GT(level.rms_error, finer.rms_error);
        EXPECT_GE(level.max_error, level.rms_error);
        EXPECT_LT(level.bytes, finer.bytes);
        EXPECT_GE(level.triangles, ladder_floor / 2);
    }
    EXPECT_EQ(store.asset("sphere")->status, proto::AssetStatus::ready);
}

TEST_F(BakeTest, EveryRungIsInTheStoreUnderItsUrl) {
    const Result<proto::Asset> asset = bake(store, named("sphere"), sphere_model(20));
    ASSERT_TRUE(asset.ok());
    for (const proto::Level& level : asset->levels) {
        const Result<store::Store::Content> content = store.content("sphere", ladder_key(level.triangles));
        ASSERT_TRUE(content.ok());
        EXPECT_EQ(content_url(content->file.hash), level.url);
        EXPECT_EQ(content->file.bytes, level.bytes);
    }
}

mesh::Model textured_model() {
    mesh::Model model = texture::square_with(texture::jpeg_of(texture::noise(256, 256)));
    model.mesh = testing::sphere(24);
    for (const Vec3f& p : model.mesh.positions) model.mesh.texture_coordinates.emplace_back(32 * p.x, 32 * p.y);
    return model;
}

TEST_F(BakeTest, TexturesShrinkWithTheLevelsErrorAndComeBackFromTheStore) {
    const mesh::Model model = textured_model();
    const Result<proto::Asset> asset = bake(store, named("textured"), model);
    ASSERT_TRUE(asset.ok()) << asset.error().message;
    EXPECT_EQ(asset->levels.front().texture_bytes, model.images[0].bytes.size());
    EXPECT_LT(asset->levels.back().texture_bytes, model.images[0].bytes.size() / 4);
    const Result<texture::Ladder> stored = load_textures(store, "textured", 1);
    const Result<texture::Ladder> made = texture::make_ladder(model);
    ASSERT_TRUE(stored.ok() && made.ok());
    ASSERT_EQ((*stored)[0].size(), (*made)[0].size());
    for (std::size_t i = 0; i < (*made)[0].size(); ++i) {
        EXPECT_EQ((*stored)[0][i].halvings, (*made)[0][i].halvings);
        EXPECT_EQ((*stored)[0][i].image.bytes, (*made)[0][i].image.bytes);
        EXPECT_EQ((*stored)[0][i].image.media_type, (*made)[0][i].image.media_type);
        EXPECT_EQ((*stored)[0][i].image.width, (*made)[0][i].image.width);
    }
}

TEST_F(BakeTest, ADamagedImageIsKeptWithAWarning) {
    mesh::Model model = textured_model();
    model.images[0].bytes.resize(300);
    const Result<proto::Asset> asset = bake(store, named("damaged"), model);
    ASSERT_TRUE(asset.ok()) << asset.error().message;
    ASSERT_FALSE(asset->warnings.empty());
    EXPECT_NE(asset->warnings.back().find("image 0 is sent as it is"), std::string::npos);
    EXPECT_EQ(asset->levels.back().texture_bytes, 300u);
}

TEST_F(BakeTest, OneTriangleIsALadderOfOne) {
    mesh::Model model;
    model.mesh = mesh::with_normals(testing::single_triangle(), 60.0);
    model.materials.resize(1);
    const Result<proto::Asset> asset = bake(store, named("one"), model);
    ASSERT_TRUE(asset.ok()) << asset.error().message;
    EXPECT_EQ(asset->levels.size(), 1u);
}

TEST_F(BakeTest, NothingIsRefusedAndNotKept) {
    EXPECT_FALSE(bake(store, named("empty"), mesh::Model{}).ok());
    EXPECT_FALSE(store.asset("empty").ok());
}

TEST_F(BakeTest, CancelledLeavesTheAssetFailed) {
    BakeOptions options;
    options.progress = [](double) { return false; };
    EXPECT_FALSE(bake(store, named("sphere"), sphere_model(40), options).ok());
    EXPECT_EQ(store.asset("sphere")->status, proto::AssetStatus::failed);
    EXPECT_NE(store.asset("sphere")->error.find("cancelled"), std::string::npos);
}

TEST_F(BakeTest, TwiceGivesTheSameBytes) {
    ASSERT_TRUE(bake(store, named("a"), sphere_model(24)).ok());
    ASSERT_TRUE(bake(store, named("b"), sphere_model(24)).ok());
    EXPECT_EQ(store.content("a", baked_key)->file.hash, store.content("b", baked_key)->file.hash);
    for (std::size_t i = 0; i < store.asset("a")->levels.size(); ++i)
        EXPECT_EQ(store.asset("a")->levels[i].url, store.asset("b")->levels[i].url);
}

TEST(AssetId, IsSafeInAUrl) {
    EXPECT_EQ(*asset_id("Bunny 69k.v2"), "bunny-69k.v2");
    EXPECT_EQ(*asset_id("../../etc"), "-.-..-etc");
    EXPECT_EQ(*asset_id("ü"), "--");
    EXPECT_FALSE(asset_id("").ok());
    EXPECT_FALSE(asset_id(std::string(max_name_length + 1, 'a')).ok());
}

}  // namespace
}  // namespace lodestream::bake
