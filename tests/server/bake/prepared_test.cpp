// The two parts of a bake: what lies in the store between them, and how the second one ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/codec/level_codec.h"
#include "server/bake/bake.h"
#include "server/bake/first_levels.h"
#include "server/bake/source_model.h"
#include "tests/common/texture/textured.h"
#include "tests/support/meshes.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::bake {
namespace {

using ::testing::HasSubstr;

mesh::Model sphere_model(std::uint32_t n) {
    mesh::Model model;
    model.mesh = lodestream::testing::sphere(n);
    model.materials.resize(1);
    return model;
}

proto::Asset named(const std::string& name) {
    proto::Asset asset;
    asset.id = asset.name = name;
    return asset;
}

struct PreparedTest : ::testing::Test {
    lodestream::testing::TemporaryFolder folder;
    std::optional<store::Store> store = *store::Store::open(folder.path());

    void reopen() {
        store.reset();
        store = *store::Store::open(folder.path());
    }
    bool keeps_the_model() { return store->content("sphere", imported_key).ok(); }
};

TEST(SourceModel, InstancesComeBackAndOlderModelsHaveNone) {
    mesh::Model model = lodestream::testing::instanced_spheres(3, 6);
    const Result<mesh::Model> back = open_source_model(serialize(model));
    ASSERT_TRUE(back.ok()) << back.error().message;
    ASSERT_EQ(back->shapes.size(), 1u);
    EXPECT_EQ(back->shapes[0].positions, model.shapes[0].positions);
    ASSERT_EQ(back->instances.size(), model.instances.size());
    for (std::size_t i = 0; i < model.instances.size(); ++i) {
        EXPECT_EQ(back->instances[i].object, model.instances[i].object);
        EXPECT_EQ(back->instances[i].matrix, model.instances[i].matrix);
    }
    model.shapes.clear();
    model.instances.clear();
    std::vector<std::byte> older = serialize(model);
    older.resize(older.size() - 2 * sizeof(std::uint64_t));  // the counts of none
    older[7] = std::byte{'2'};
    ASSERT_TRUE(open_source_model(older).ok());
    EXPECT_EQ(open_source_model(older)->mesh.positions, model.mesh.positions);
}

TEST(SourceModel, RefusesInstancesOfNothing) {
    const mesh::Model sound = lodestream::testing::instanced_spheres(2, 6);
    const auto refuses = [&](auto damage) {
        mesh::Model model = sound;
        damage(model.instances.front());
        return !open_source_model(serialize(model)).ok();
    };
    EXPECT_FALSE(refuses([](mesh::Instance&) {}));
    EXPECT_TRUE(refuses([](mesh::Instance& instance) { instance.shape = 1; }));
    EXPECT_TRUE(refuses([](mesh::Instance& instance) { instance.object = 4; }));
    EXPECT_TRUE(refuses([](mesh::Instance& instance) { instance.matrix = Mat4d(0.0); }));
}

TEST_F(PreparedTest, InstancesCountInTheAssetAndInItsFirstLevels) {
    const mesh::Model model = lodestream::testing::instanced_spheres(4, 8);
    const Result<proto::Asset> asset = prepare(*store, named("spheres"), model);
    ASSERT_TRUE(asset.ok()) << asset.error().message;
    EXPECT_EQ(asset->triangles, 16 * model.shapes[0].triangles.size());
    EXPECT_DOUBLE_EQ((*asset->bounds_max)[2], 10.0);
    EXPECT_EQ(asset->levels.front().triangles, asset->triangles);
    const Result<proto::Asset> baked = bake_prepared(*store, "spheres");
    ASSERT_TRUE(baked.ok()) << baked.error().message;
    EXPECT_EQ(baked->triangles, asset->triangles);
    EXPECT_EQ(baked->levels.front().triangles, asset->triangles);
    EXPECT_EQ(baked->levels.front().max_error, 0.0);
}

TEST(SourceModel, ComesBackAsItWent) {
    mesh::Model model = texture::square_with(texture::jpeg_of(texture::noise(16, 16)));
    model.origin = {1e7, 2, 3};
    model.kind = mesh::Kind::scene;
    model.objects = 7;
    model.mesh.triangle_materials.assign(model.mesh.triangles.size(), 0);
    const Result<mesh::Model> back = open_source_model(serialize(model));
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->origin, model.origin);
    EXPECT_EQ(back->kind, model.kind);
    EXPECT_EQ(back->objects, 7u);
    EXPECT_EQ(back->images[0].bytes, model.images[0].bytes);
    EXPECT_EQ(back->mesh.positions, model.mesh.positions);
    EXPECT_EQ(back->mesh.normals, model.mesh.normals);
    EXPECT_EQ(back->mesh.texture_coordinates, model.mesh.texture_coordinates);
    EXPECT_EQ(back->mesh.triangles, model.mesh.triangles);
    EXPECT_EQ(back->mesh.triangle_materials, model.mesh.triangle_materials);
}

TEST(SourceModel, RefusesTruncationsAndSurvivesFlippedBytes) {
    const std::vector<std::byte> bytes = serialize(sphere_model(5));
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(open_source_model(std::span(bytes).first(size)).ok()) << size;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        std::vector<std::byte> damaged = bytes;
        damaged[i] ^= std::byte{0xff};
        const Result<mesh::Model> back = open_source_model(damaged);
        if (!back) continue;
        for (const mesh::Triangle& t : back->mesh.triangles)
            for (const std::uint32_t v : t) ASSERT_LT(v, back->mesh.positions.size());
    }
}

TEST_F(PreparedTest, FirstLevelsAreServedWhileItBakes) {
    const Result<proto::Asset> asset = prepare(*store, named("sphere"), sphere_model(80));
    ASSERT_TRUE(asset.ok()) << asset.error().message;
    EXPECT_EQ(asset->status, proto::AssetStatus::baking);
    EXPECT_EQ(asset->triangles, 12640u);
    ASSERT_EQ(asset->levels.size(), std::size(first_level_triangles));
    for (std::size_t i = 0; i < asset->levels.size(); ++i) {
        const proto::Level& level = asset->levels[i];
        EXPECT_LE(level.triangles, first_level_triangles[i]);
        EXPECT_GT(level.rms_error, 0.0);
        const std::string hash = level.url.substr(level.url.rfind('/') + 1, 64);
        const auto bytes = store::read_file(store->file(hash, "glb")->path, level.bytes);
        ASSERT_TRUE(bytes.ok());
        const Result<codec::Decoded> decoded = codec::decode_level(*bytes);
        ASSERT_TRUE(decoded.ok()) << decoded.error().message;
        EXPECT_EQ(decoded->primitives[0].mesh.triangles.size(), level.triangles);
    }
    EXPECT_EQ(store->asset("sphere")->levels.size(), asset->levels.size());
}

TEST_F(PreparedTest, ASmallModelIsItsOwnFirstLevel) {
    const Result<proto::Asset> asset = prepare(*store, named("sphere"), sphere_model(20));
    ASSERT_TRUE(asset.ok());
    EXPECT_EQ(asset->levels.front().triangles, 760u);
    EXPECT_EQ(asset->levels.front().rms_error, 0.0);
    EXPECT_EQ(asset->levels.size(), 2u);
}

TEST_F(PreparedTest, TheBakeReplacesFirstLevelsAndDropsTheModel) {
    ASSERT_TRUE(prepare(*store, named("sphere"), sphere_model(40)).ok());
    EXPECT_TRUE(keeps_the_model());
    const Result<proto::Asset> asset = bake_prepared(*store, "sphere");
    ASSERT_TRUE(asset.ok()) << asset.error().message;
    EXPECT_EQ(asset->status, proto::AssetStatus::ready);
    EXPECT_EQ(asset->levels.front().triangles, 3120u);
    EXPECT_EQ(asset->levels.front().rms_error, 0.0);
    EXPECT_FALSE(keeps_the_model());
    EXPECT_FALSE(bake_prepared(*store, "nobody").ok());
    EXPECT_FALSE(store->asset("nobody").ok());
}

TEST_F(PreparedTest, PausedItGoesOnAfterARestart) {
    ASSERT_TRUE(prepare(*store, named("sphere"), sphere_model(40)).ok());
    BakeOptions options;
    options.pause = [] { return true; };
    for (std::uint32_t i = 0; i < 2 * max_bake_starts; ++i) {  // a stop is no crash, however often
        EXPECT_EQ(bake_prepared(*store, "sphere", options).error().code, ErrorCode::unavailable);
        EXPECT_EQ(store->asset("sphere")->status, proto::AssetStatus::baking);
        reopen();
        EXPECT_EQ(*recover(*store), std::vector<std::string>{"sphere"});
    }
    EXPECT_TRUE(bake_prepared(*store, "sphere").ok());
    reopen();
    EXPECT_TRUE(recover(*store)->empty());
}

TEST_F(PreparedTest, GoesOnOnceAfterACrashButNotTwice) {
    ASSERT_TRUE(prepare(*store, named("sphere"), sphere_model(40)).ok());
    struct Crash {};  // no std::exception: leaves the store as an end of the program would
    BakeOptions options;
    options.progress = [](double share) -> bool { return share > 0.0 ? throw Crash() : true; };
    EXPECT_THROW((void)bake_prepared(*store, "sphere", options), Crash);
    reopen();
    EXPECT_EQ(recover(*store)->size(), 1u);
    EXPECT_THROW((void)bake_prepared(*store, "sphere", options), Crash);
    reopen();
    EXPECT_TRUE(recover(*store)->empty());
    EXPECT_EQ(store->asset("sphere")->status, proto::AssetStatus::failed);
    EXPECT_THAT(store->asset("sphere")->error, HasSubstr("ended the program 2 times"));
    EXPECT_TRUE(store->asset("sphere")->levels.empty());
    EXPECT_FALSE(keeps_the_model());
}

TEST_F(PreparedTest, WhatAnotherProcessBakesIsLeftToIt) {
    ASSERT_TRUE(prepare(*store, named("sphere"), sphere_model(20)).ok());
    store::Store second = *store::Store::open(folder.path());
    EXPECT_TRUE(recover(second)->empty());
    EXPECT_EQ(second.asset("sphere")->status, proto::AssetStatus::baking);
}

TEST_F(PreparedTest, ABakeThatTakesTooLongFails) {
    BakeOptions options;
    options.limits.max_bake_s = 1e-9;
    const Result<proto::Asset> asset = bake(*store, named("sphere"), sphere_model(40), options);
    ASSERT_FALSE(asset.ok());
    EXPECT_EQ(asset.error().code, ErrorCode::limit_exceeded);
    EXPECT_THAT(store->asset("sphere")->error, HasSubstr("longer than the limit"));
}

TEST_F(PreparedTest, AModelThatNeedsTooMuchMemoryIsRefusedAndNotKept) {
    BakeOptions options;
    options.limits.max_memory_bytes = 100'000;
    const Result<proto::Asset> asset = bake(*store, named("sphere"), sphere_model(40), options);
    ASSERT_FALSE(asset.ok());
    EXPECT_EQ(asset.error().code, ErrorCode::limit_exceeded);
    EXPECT_THAT(asset.error().message, HasSubstr("more than the limit of 1 MB"));
    EXPECT_FALSE(store->asset("sphere").ok());
    options.limits.max_memory_bytes = bake_memory_bytes(sphere_model(40));
    EXPECT_TRUE(bake(*store, named("sphere"), sphere_model(40), options).ok());
}

TEST_F(PreparedTest, ProgressRisesFromTheRecordingOn) {
    std::vector<double> shares;
    BakeOptions options;
    options.progress = [&](double share) {
        shares.push_back(share);
        return true;
    };
    ASSERT_TRUE(bake(*store, named("sphere"), sphere_model(300), options).ok());
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    EXPECT_EQ(shares.back(), 1.0);
    const std::set<double> different(shares.begin(), shares.end());
    const auto while_recording = std::distance(different.upper_bound(0.0), different.lower_bound(0.5));
    EXPECT_GE(while_recording, 4);
}

}  // namespace
}  // namespace lodestream::bake
