#include "server/bake/points.h"

#include <gtest/gtest.h>

#include <atomic>

#include "server/bake/bake.h"
#include "server/bake/surface_colors.h"
#include "server/bake/tile_tree.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::bake {
namespace {

struct PointsTest : ::testing::Test {
    testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());

    codec::Points baked(mesh::Model model) {
        proto::Asset asset;
        asset.id = asset.name = "model";
        const auto done = bake(store, asset, std::move(model));
        EXPECT_TRUE(done) << (done ? "" : done.error().message);
        auto points = load_points(store, "model");
        EXPECT_TRUE(points) << (points ? "" : points.error().message);
        return points ? *std::move(points) : codec::Points{};
    }
};

mesh::Model sphere_model(std::uint32_t n) {
    mesh::Model model;
    model.mesh = testing::sphere(n);
    model.materials.resize(1);
    model.materials[0].base_color = {0.5f, 0.25f, 1.0f, 1.0f};
    return model;
}

TEST_F(PointsTest, ABakeLeavesOrderedPointsWithTheirErrors) {
    const codec::Points points = baked(sphere_model(40));  // 3,120 triangles
    EXPECT_EQ(points.cloud.positions.size(), 3120u);
    EXPECT_EQ(points.cloud.normals.size(), 3120u);
    EXPECT_TRUE(points.cloud.colors.empty());
    EXPECT_EQ(points.base_color, Vec4f(0.5f, 0.25f, 1.0f, 1.0f));
    ASSERT_GT(points.levels.size(), 4u);
    EXPECT_EQ(points.levels.front().points, 3120u);
    EXPECT_GT(points.levels.back().error.max, points.levels.front().error.max);
}

TEST_F(PointsTest, AModelFarAwayKeepsItsPlace) {
    mesh::Model model = sphere_model(8);
    model.origin = {1e7, -2e6, 5};
    const codec::Points points = baked(std::move(model));
    for (const Vec3f& p : points.cloud.positions)
        ASSERT_LT(glm::length(points.origin + Vec3d(p) - Vec3d(1e7, -2e6, 5)), 1.01);
}

TEST_F(PointsTest, EveryCutCanBeReadAgain) {
    mesh::Model needle = sphere_model(30);
    for (Vec3f& p : needle.mesh.positions) p *= Vec3f(1.0f, 0.02f, 0.02f);
    const codec::Points points = baked(needle);
    for (std::uint64_t count = 1; count <= points.cloud.positions.size(); count += 1 + count / 16) {
        const auto encoded = codec::encode_points(cut_points(points, count));
        ASSERT_TRUE(encoded) << count;
        const auto decoded = codec::decode_points(encoded->glb);
        ASSERT_TRUE(decoded) << count << ": " << decoded.error().message;
        EXPECT_EQ(decoded->points, count);
    }
}

TEST_F(PointsTest, CutsAreLevelsOfTheirOwn) {
    const codec::Points points = baked(sphere_model(40));
    for (const std::uint64_t count : {0u, 1u, 64u, 1000u, 3120u, 1'000'000u}) {
        const codec::Points cut = cut_points(points, count);
        const std::uint64_t expected = std::min<std::uint64_t>(count, 3120);
        EXPECT_EQ(cut.cloud.positions.size(), expected);
        EXPECT_EQ(cut.levels.front().points, expected);
        const auto encoded = codec::encode_points(cut);
        ASSERT_TRUE(encoded) << encoded.error().message;
        const auto decoded = codec::decode_points(encoded->glb);
        ASSERT_TRUE(decoded) << count << ": " << decoded.error().message;
        EXPECT_EQ(decoded->points, expected);
        for (std::size_t i = 0; i < expected; i += 37)  // the asset's grid: no second rounding
            ASSERT_EQ(decoded->content.cloud.positions[i], points.cloud.positions[i]);
    }
}

TEST_F(PointsTest, AssetWithoutPoints) {
    EXPECT_EQ(load_points(store, "nobody").error().code, ErrorCode::not_found);
}

TEST(SurfaceColors, MaterialsTexelsAndVertexColoursAreMultiplied) {
    mesh::Model model;
    model.mesh = testing::single_triangle();
    model.materials.resize(1);
    model.materials[0].base_color = {1.0f, 0.5f, 1.0f, 1.0f};
    EXPECT_EQ(SurfaceColors(model, model.mesh).constant(), model.materials[0].base_color);

    model.mesh.texture_coordinates = {{0.25f, 0.5f}, {0.75f, 0.5f}, {-0.25f, 0.5f}};  // left, right, right again
    image::Pixels pixels{2, 1, {255, 255, 255, 255, 0, 0, 255, 255}};
    model.images.push_back({"image/png", *image::encode_png(pixels), 2, 1});
    model.materials[0].base_color_texture.image = 0;
    const SurfaceColors textured(model, model.mesh);
    EXPECT_FALSE(textured.constant());
    EXPECT_EQ(textured.at(0, {1, 0, 0}), Rgba8(255, 128, 255, 255));
    EXPECT_EQ(textured.at(0, {0, 1, 0}), Rgba8(0, 0, 255, 255));
    EXPECT_EQ(textured.at(0, {0, 0, 1}), Rgba8(0, 0, 255, 255));

    model.mesh.colors.assign(3, Rgba8(51, 255, 255, 255));
    EXPECT_EQ(SurfaceColors(model, model.mesh).at(0, {1, 0, 0}), Rgba8(51, 128, 255, 255));
}

TEST(SurfaceColors, ABrokenImageIsWhite) {
    mesh::Model model;
    model.mesh = testing::single_triangle();
    model.mesh.texture_coordinates.assign(3, Vec2f(std::numeric_limits<float>::quiet_NaN()));
    model.materials.resize(1);
    model.materials[0].base_color_texture.image = 0;
    model.images.push_back({"image/png", std::vector<std::byte>(9), 1, 1});
    EXPECT_EQ(SurfaceColors(model, model.mesh).at(0, {1, 0, 0}), Rgba8(255, 255, 255, 255));
}

mesh::Model cloud_model(std::uint32_t n) {
    mesh::Model model = sphere_model(n);
    model.kind = mesh::Kind::points;
    model.mesh.triangles.clear();
    model.mesh.colors.assign(model.mesh.positions.size(), {10, 20, 30, 255});
    model.mesh.colors.front() = {200, 20, 30, 255};
    return model;
}

TEST_F(PointsTest, ACloudIsBakedAsItself) {
    const mesh::Model model = cloud_model(40);
    const std::size_t count = model.mesh.positions.size();
    const codec::Points points = baked(model);
    EXPECT_EQ(points.cloud.positions.size(), count);
    EXPECT_EQ(points.cloud.normals.size(), count);
    EXPECT_EQ(points.cloud.colors.size(), count);
    ASSERT_GT(points.levels.size(), 3u);
    EXPECT_LT(points.levels.front().error.max, 1e-3);
    EXPECT_GT(points.levels.back().error.max, 0.5);
    const proto::Asset asset = *store.asset("model");
    EXPECT_EQ(asset.kind, "points");
    EXPECT_EQ(asset.triangles, 0u);
    EXPECT_EQ(asset.vertices, count);
    EXPECT_EQ(asset.status, proto::AssetStatus::ready);
    ASSERT_TRUE(asset.bounds_max);
    EXPECT_NEAR((*asset.bounds_max)[1], 1.0, 1e-6);
}

TEST_F(PointsTest, OnePointAndManyInOnePlaceAreClouds) {
    mesh::Model one;
    one.kind = mesh::Kind::points;
    one.materials.resize(1);
    one.mesh.positions = {{3, 4, 5}};
    EXPECT_EQ(baked(one).cloud.positions.size(), 1u);
    one.mesh.positions.assign(1000, {3, 4, 5});
    EXPECT_EQ(baked(one).cloud.positions.size(), 1u);
}

TEST_F(PointsTest, AnEmptyCloudIsRefused) {
    mesh::Model none;
    none.kind = mesh::Kind::points;
    none.materials.resize(1);
    proto::Asset asset;
    asset.id = asset.name = "none";
    EXPECT_FALSE(bake(store, asset, none));
}

TEST_F(PointsTest, MakingThemCanBeCancelledAtEveryStep) {
    const mesh::Model model = sphere_model(20);
    const metric::SurfaceIndex original(model.mesh);
    std::atomic<int> steps = 0;
    ASSERT_TRUE(store.put_asset([] {
        proto::Asset asset;
        asset.id = asset.name = "model";
        return asset;
    }()));
    ASSERT_TRUE(make_points(store, "model", {model, model.mesh, original}, [&](double) { return ++steps > 0; }));
    EXPECT_GT(steps, 4);
    for (int allowed = 0; allowed < steps; ++allowed) {
        std::atomic<int> seen = 0;
        const Status made =
            make_points(store, "model", {model, model.mesh, original}, [&](double) { return ++seen <= allowed; });
        ASSERT_FALSE(made) << allowed;
        EXPECT_EQ(made.error().code, ErrorCode::unavailable);
    }
}

TEST_F(PointsTest, ACloudIsStoredAsTilesThatAddUpToIt) {
    mesh::Model model;
    model.kind = mesh::Kind::points;
    model.mesh = testing::sphere(160);
    model.mesh.triangles.clear();
    model.materials.resize(1);
    model.origin = {1000, 0, 0};
    const std::size_t points = baked(model).cloud.positions.size();
    const Result<proto::Asset> asset = store.asset("model");
    ASSERT_TRUE(asset) << asset.error().message;
    const Result<TileTree> tree = load_tiles(store, *asset);
    ASSERT_TRUE(tree) << tree.error().message;
    EXPECT_TRUE(tree->is_additive);
    ASSERT_GT(tree->nodes.size(), 1u);
    std::size_t sum = 0;
    for (std::size_t i = 0; i < tree->nodes.size(); ++i) {
        const auto bytes = store::read_file(store.file(tree->hashes[i], "glb")->path, 1 << 30);
        ASSERT_TRUE(bytes) << bytes.error().message;
        const auto tile = codec::decode_points(*bytes);
        ASSERT_TRUE(tile) << tile.error().message;
        sum += tile->points;
        const scene::LodNode& node = tree->nodes[i];
        EXPECT_EQ(node.error > 0.0, node.child_count > 0);
        for (const Vec3f& p : tile->content.cloud.positions) {
            const Vec3d at = Vec3d(p) + tile->content.origin;
            EXPECT_LT(length(at - clamp(at, node.box.min, node.box.max)), 1e-4);
        }
    }
    EXPECT_EQ(sum, points);
}

}  // namespace
}  // namespace lodestream::bake
