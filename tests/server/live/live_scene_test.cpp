#include "server/live/live_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "common/base/random.h"
#include "common/metric/surface_distance.h"
#include "server/bake/bake.h"
#include "tests/server/live/moving_scene.h"

namespace lodestream::live {
namespace {

using lodestream::testing::spheres;
using testing::by;
using ::testing::HasSubstr;
using testing::moving;
using testing::showing;
using testing::with_nodes;
using LiveSceneTest = testing::MovingScene;

double two_sided(const mesh::Mesh& a, const mesh::Mesh& b) {
    return metric::measure(metric::SurfaceIndex(a), a, b).max;
}

// The model with objects where nodes put them; hidden ones left out.
mesh::Mesh expected(const mesh::Model& model, const std::map<std::uint32_t, scene::Placement>& of_objects) {
    mesh::Mesh all;
    for (std::uint32_t object = 0; object < model.graph.object_nodes.size(); ++object) {
        std::vector<std::uint32_t> triangles;
        for (std::uint32_t t = 0; t < model.mesh.triangles.size(); ++t)
            if (model.mesh.triangle_objects[t] == object) triangles.push_back(t);
        mesh::Mesh part = mesh::part(model.mesh, triangles);
        part.normals.clear();
        part.triangle_objects.clear();
        const auto placement = of_objects.find(object);
        if (placement != of_objects.end() && !placement->second.visible) continue;
        if (placement != of_objects.end()) part = mesh::placed(part, model.origin, placement->second.matrix);
        mesh::append(all, part);
    }
    return all;
}

std::uint32_t tile_of_node(const proto::Tileset& tileset, std::uint32_t node) {
    const auto found = std::ranges::find(tileset.scene_nodes, node);
    return found == tileset.scene_nodes.end() ? scene::none
                                              : static_cast<std::uint32_t>(found - tileset.scene_nodes.begin());
}

TEST_F(LiveSceneTest, UntouchedItIsTheBakedTree) {
    bake(with_nodes(spheres(4, 20)));
    const auto scene = open();
    const auto baked = *bake::load_tiles(store, asset);
    const proto::Tileset now = scene->tileset();
    ASSERT_EQ(now.nodes.size(), baked.nodes.size());
    for (std::size_t i = 0; i < now.nodes.size(); ++i) {
        EXPECT_EQ(now.nodes[i].error, baked.nodes[i].error);
        EXPECT_THAT(now.uris[i], HasSubstr(baked.hashes[i]));
    }
    EXPECT_EQ(now.revision, 0u);
    EXPECT_FALSE(scene->make_rest());
    EXPECT_FALSE(scene->make_above([] { return true; }));
}

TEST_F(LiveSceneTest, AMovedObjectIsDrawnAtItsPlaceAndTheRestAtTheirs) {
    const mesh::Model model = with_nodes(spheres(4, 16));
    bake(model);
    const auto scene = open();
    const Mat4d place = matrix_of({0.4, 2.5, -0.3}, {0.1, 0.2, 0.3, 0.9}, {1.2, 0.8, 1.0});
    change(*scene, moving(6, place));
    make_rests(*scene);
    const proto::Tileset now = scene->tileset();
    ASSERT_TRUE(scene::validate(now.nodes));
    EXPECT_LT(two_sided(expected(model, {{5, {place, true}}}), finest_below(now, 0)), 0.01);
    const std::uint32_t own = tile_of_node(now, 6);
    ASSERT_NE(own, scene::none);
    EXPECT_EQ(now.nodes[own].error, 0.0);
    EXPECT_LT(distance(now.matrix(own)[3], place[3]), 1e-12);
}

TEST_F(LiveSceneTest, MovingAnObjectAgainChangesItsTransformAlone) {
    bake(with_nodes(spheres(4, 16)));
    const auto scene = open();
    change(*scene, moving(6, by(0, 1, 0)));
    make_rests(*scene);
    const proto::Tileset before = scene->tileset();
    change(*scene, moving(6, by(0, 1.5, 0)));
    EXPECT_FALSE(scene->make_rest()) << "nothing has to be encoded";
    const proto::Tileset after = scene->tileset();
    EXPECT_GT(after.revision, before.revision);
    EXPECT_EQ(after.uris, before.uris);
    const std::uint32_t own = tile_of_node(after, 6);
    for (std::size_t i = 0; i < after.nodes.size(); ++i) EXPECT_EQ(after.matrix(i) == before.matrix(i), i != own) << i;
}

// The law of the whole: at any time a tile is off from what it stands for by no more than it says.
TEST_F(LiveSceneTest, AtAnyMomentErrorsBoundWhatTilesAreOff) {
    const mesh::Model model = with_nodes(spheres(5, 16));
    bake(model);
    const auto scene = open();
    Random random{3};
    std::map<std::uint32_t, scene::Placement> places;
    for (int round = 0; round < 12; ++round) {
        std::vector<proto::NodeChange> changes;
        for (int k = 0; k < 3; ++k) {
            const auto object = static_cast<std::uint32_t>(random.uniform() * 25);
            if (std::ranges::count(changes, object + 1, &proto::NodeChange::node) > 0) continue;
            const auto part = [&] { return 0.8 * random.uniform() - 0.4; };  // less than its extent
            places[object] = {by(part(), part(), part()), true};
            changes.push_back({object + 1, places[object].matrix, std::nullopt});
        }
        change(*scene, changes);
        for (int made = round % 4; made > 0; --made) scene->make_above([] { return true; });
        if (round % 2 == 0) make_rests(*scene);
        const proto::Tileset now = scene->tileset();
        ASSERT_TRUE(scene::validate(now.nodes));
        const mesh::Mesh truth = expected(model, places);
        EXPECT_LE(two_sided(truth, content(now, 0)), 1.05 * now.nodes[0].error + 0.01) << round;
        double finest_error = 0.0;
        for (const scene::LodNode& node : now.nodes)
            if (node.child_count == 0) finest_error = std::max(finest_error, node.error);
        EXPECT_LE(two_sided(truth, finest_below(now, 0)), 1.05 * finest_error + 0.01) << round;
        EXPECT_EQ(finest_error == 0.0, !scene->is_behind()) << round;
        for (std::uint32_t i = 0; i < now.nodes.size(); ++i) {
            if (scene->is_behind() || now.nodes[i].child_count == 0) continue;
            const mesh::Mesh below = finest_below(now, i);
            EXPECT_LE(two_sided(below, content(now, i)), 1.05 * now.nodes[i].error + 0.01) << round << ' ' << i;
        }
    }
}

TEST_F(LiveSceneTest, AtRestTilesAreWholeAgainAndAsGoodAsBaked) {
    bake(with_nodes(spheres(5, 16)));
    const auto scene = open();
    const proto::Tileset before = scene->tileset();
    change(*scene, {{3, by(0.2, 0.3, 0), std::nullopt}, {9, by(0, 0.4, 0), std::nullopt}});
    EXPECT_GT(scene->tileset().nodes[0].error, before.nodes[0].error + 0.3);
    make_true(*scene);
    const proto::Tileset after = scene->tileset();
    EXPECT_EQ(after.nodes.size(), before.nodes.size());
    EXPECT_TRUE(std::ranges::all_of(after.scene_nodes, [](std::uint32_t n) { return n == proto::no_scene_node; }));
    EXPECT_LT(after.nodes[0].error, 1.5 * before.nodes[0].error + 0.05);
    change(*scene, {{3, Mat4d(1.0), std::nullopt}, {9, Mat4d(1.0), std::nullopt}});
    make_true(*scene);
    EXPECT_EQ(scene->moved_objects(), 0u);
    EXPECT_LT(scene->tileset().nodes[0].error, 1.5 * before.nodes[0].error + 0.05);
}

TEST_F(LiveSceneTest, ATileOfOneObjectMovesAsItIsWithItsLevels) {
    mesh::Model model = lodestream::testing::empty_scene();
    for (int i = 0; i < 4; ++i)
        lodestream::testing::add_object(
            model, lodestream::testing::moved(lodestream::testing::sphere(90), {3.0f * static_cast<float>(i), 0, 0}));
    bake(with_nodes(model));
    const auto scene = open();
    const proto::Tileset before = scene->tileset();
    change(*scene, moving(2, by(0, 0, 7)));
    EXPECT_FALSE(scene->make_rest());
    const proto::Tileset after = scene->tileset();
    EXPECT_EQ(after.uris, before.uris);
    std::size_t moved = 0;
    for (std::size_t i = 1; i < after.nodes.size(); ++i) {
        moved += after.matrix(i) != Mat4d(1.0) ? 1 : 0;
        if (after.scene_nodes[i] != proto::no_scene_node) {
            EXPECT_NEAR(after.nodes[i].error, before.nodes[i].error, 1e-12);
        }
    }
    EXPECT_GE(moved, 2u) << "of 16,020 triangles, so it has levels";
    EXPECT_GT(after.nodes[0].error, before.nodes[0].error + 1.9) << "as far as the object is wide";
    EXPECT_LT(after.nodes[0].error, before.nodes[0].error + 3.6);
}

TEST_F(LiveSceneTest, AnInstanceKeepsItsContentWhereverItIsMoved) {
    mesh::Model model = lodestream::testing::instanced_spheres(4, 16);
    model.graph = mesh::flat_graph(model.objects);
    bake(model);
    const auto scene = open();
    const proto::Tileset before = scene->tileset();
    change(*scene, moving(7, by(0, 9, 0)));
    EXPECT_FALSE(scene->make_rest());
    const proto::Tileset after = scene->tileset();
    EXPECT_EQ(after.uris, before.uris);
    const std::uint32_t tile = tile_of_node(after, 7);
    ASSERT_NE(tile, scene::none);
    EXPECT_EQ(after.matrix(tile), by(0, 9, 0) * before.matrix(tile));
    for (mesh::Instance& instance : model.instances)
        if (instance.object == 6) instance.matrix = by(0, 9, 0) * instance.matrix;
    mesh::Mesh meant = mesh::flattened(model, model.shapes);
    meant.normals.clear();
    EXPECT_LT(two_sided(meant, finest_below(after, 0)), 0.01);

    make_true(*scene);
    const proto::Tileset rested = scene->tileset();
    EXPECT_LT(rested.nodes[0].error, after.nodes[0].error);
    EXPECT_LE(two_sided(meant, content(rested, 0)), 1.05 * rested.nodes[0].error + 0.01);
}

TEST_F(LiveSceneTest, HiddenObjectsAreNotThereAndComeBack) {
    const mesh::Model model = with_nodes(spheres(3, 16));
    bake(model);
    const auto scene = open();
    change(*scene, showing(5, false));
    make_rests(*scene);
    EXPECT_LT(two_sided(expected(model, {{4, {Mat4d(1.0), false}}}), finest_below(scene->tileset(), 0)), 0.01);
    EXPECT_EQ(tile_of_node(scene->tileset(), 5), scene::none);
    make_true(*scene);
    EXPECT_LT(two_sided(expected(model, {{4, {Mat4d(1.0), false}}}), finest_below(scene->tileset(), 0)), 0.01);
    EXPECT_LT(two_sided(expected(model, {{4, {Mat4d(1.0), false}}}), content(scene->tileset(), 0)),
              scene->tileset().nodes[0].error + 0.01);
    change(*scene, showing(5, true));
    make_true(*scene);
    EXPECT_LT(two_sided(expected(model, {}), finest_below(scene->tileset(), 0)), 0.01);
}

TEST_F(LiveSceneTest, AllOfABranchMayBeHiddenButNotAllOfTheScene) {
    const mesh::Model model = with_nodes(spheres(4, 24));
    bake(model);
    const auto scene = open();
    std::map<std::uint32_t, scene::Placement> hidden;
    for (std::uint32_t object = 0; object < 15; ++object) {
        change(*scene, showing(object + 1, false));
        hidden[object] = {Mat4d(1.0), false};
    }
    make_true(*scene);
    const proto::Tileset now = scene->tileset();
    ASSERT_TRUE(scene::validate(now.nodes));
    EXPECT_LT(two_sided(expected(model, hidden), finest_below(now, 0)), 0.01);
    const auto refused = scene->change(showing(0, false));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::conflict);
    EXPECT_EQ(scene->tileset().uris, now.uris);
}

TEST_F(LiveSceneTest, NodesMoveWhatIsBelowThem) {
    mesh::Model model = spheres(3, 16);
    // 0 – 1 – 2, with three objects each.
    model.graph = {{mesh::no_parent, 0, 1}, {0, 0, 0, 1, 1, 1, 2, 2, 2}};
    bake(model);
    const auto scene = open();
    const Mat4d outer = by(1, 0, 0), inner = matrix_of({0, 0, 0}, {0, 1, 0, 0}, {1, 1, 1});
    change(*scene, {{2, inner, std::nullopt}, {1, outer, std::nullopt}});
    make_rests(*scene);
    std::map<std::uint32_t, scene::Placement> places;
    for (std::uint32_t object = 3; object < 6; ++object) places[object] = {outer, true};
    for (std::uint32_t object = 6; object < 9; ++object) places[object] = {outer * inner, true};
    EXPECT_LT(two_sided(expected(model, places), finest_below(scene->tileset(), 0)), 0.01);
    const proto::SceneNodes nodes = scene->nodes(1, 5);
    ASSERT_EQ(nodes.nodes.size(), 2u);
    EXPECT_EQ(nodes.count, 3u);
    EXPECT_EQ(nodes.nodes[1].parent, 1u);
    EXPECT_EQ(nodes.nodes[1].objects, 3u);
    EXPECT_EQ(nodes.nodes[1].placement.matrix, inner);
    EXPECT_TRUE(scene->nodes(3, 5).nodes.empty());
}

TEST_F(LiveSceneTest, RefusedChangesChangeNothing) {
    bake(with_nodes(spheres(3, 16)));
    const auto scene = open();
    const auto unknown = scene->change(std::vector<proto::NodeChange>{{3, by(0, 1, 0), {}}, {10, by(0, 1, 0), {}}});
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().code, ErrorCode::not_found);
    EXPECT_THAT(unknown.error().message, HasSubstr("no node 10, the scene has 10"));
    const Mat4d large = matrix_of({0, 0, 0}, {0, 0, 0, 1}, {1e5, 1e5, 1e5});
    const auto too_large = scene->change(std::vector<proto::NodeChange>{{0, large, {}}, {4, large, {}}});
    ASSERT_FALSE(too_large);
    EXPECT_THAT(too_large.error().message, HasSubstr("node 4: its place, with the nodes above, scales by more"));
    EXPECT_EQ(scene->revision(), 0u);
    EXPECT_EQ(scene->moved_objects(), 0u);
    EXPECT_FALSE(*store.has_nodes(asset.id));
}

TEST_F(LiveSceneTest, PlacesSurviveARestart) {
    const mesh::Model model = with_nodes(spheres(3, 16));
    bake(model);
    std::uint64_t revision = 0;
    {
        const auto scene = open();
        change(*scene, moving(5, by(0, 1, 0)));
        change(*scene, showing(2, false));
        make_rests(*scene);
        revision = scene->revision();
    }
    const auto scene = open();
    EXPECT_GT(scene->revision(), revision);
    EXPECT_EQ(scene->moved_objects(), 2u);
    make_rests(*scene);
    EXPECT_LT(two_sided(expected(model, {{4, {by(0, 1, 0), true}}, {1, {Mat4d(1.0), false}}}),
                        finest_below(scene->tileset(), 0)),
              0.01);
}

// An asset that nodes may show: a small sphere at the origin.
struct AddedTest : LiveSceneTest {
    void SetUp() override {
        put("crate", lodestream::testing::moved(lodestream::testing::sphere(12), {0, 0, 0}, 0.5f));
    }

    void put(const std::string& name, const mesh::Mesh& mesh) {
        mesh::Model model;
        model.mesh = mesh;
        model.materials.resize(1);
        proto::Asset small;
        small.id = small.name = name;
        const auto baked = lodestream::bake::bake(store, small, model);
        ASSERT_TRUE(baked) << baked.error().message;
        shown[name] = mesh;
        shown[name].normals.clear();
    }
    mesh::Mesh crate_at(const Mat4d& matrix, const std::string& name = "crate") const {
        return mesh::placed(shown.at(name), Vec3d(0.0), matrix);
    }
    static std::vector<proto::NodeChange> showing_asset(std::uint32_t node, const std::string& name,
                                                        const Mat4d& matrix) {
        return {{node, matrix, std::nullopt, name}};
    }
    static std::vector<proto::NodeChange> adding(std::uint32_t parent, const Mat4d& matrix) {
        return {{proto::next_node, matrix, std::nullopt, "crate", parent}};
    }
    static mesh::Mesh both(mesh::Mesh a, const mesh::Mesh& b) {
        mesh::append(a, b);
        return a;
    }
    // The finest tiles show this; where they are true, so is what the coarsest says that it is off.
    void expect_shows(LiveScene& scene, const mesh::Mesh& meant, bool is_true = false) const {
        const proto::Tileset now = scene.tileset();
        ASSERT_TRUE(scene::validate(now.nodes));
        EXPECT_LT(two_sided(meant, finest_below(now, 0)), 0.02);
        if (!is_true) return;
        EXPECT_LE(two_sided(meant, content(now, 0)), 1.05 * now.nodes[0].error + 0.02);
    }

    std::map<std::string, mesh::Mesh> shown;
};

TEST_F(AddedTest, ANodeShowsAnAssetInPlaceOfItsOwnObjects) {
    const mesh::Model model = with_nodes(spheres(3, 16));
    bake(model);
    const auto scene = open();
    const Mat4d place = by(4, 2, 1);
    change(*scene, showing_asset(5, "crate", place));
    const double coarse = scene->tileset().nodes[0].error;
    EXPECT_GT(coarse, 1.9) << "a sphere is missing where the coarse tile has one";
    make_rests(*scene);
    const mesh::Mesh meant = both(expected(model, {{4, {Mat4d(1.0), false}}}), crate_at(place));
    expect_shows(*scene, meant);
    make_true(*scene);
    expect_shows(*scene, meant, true);
    EXPECT_LT(scene->tileset().nodes[0].error, coarse);
    const proto::SceneNode node = scene->nodes(5, 1).nodes.front();
    EXPECT_EQ(node.asset, "crate");
    EXPECT_EQ(node.objects, 1u);
    EXPECT_NEAR(node.bounds.min.x, 3.5, 1e-3);

    change(*scene, moving(5, by(0, 5, 0)));
    expect_shows(*scene, both(expected(model, {{4, {Mat4d(1.0), false}}}), crate_at(by(0, 5, 0))));
    change(*scene, showing_asset(5, "", Mat4d(1.0)));
    make_true(*scene);
    expect_shows(*scene, expected(model, {}), true);
    EXPECT_EQ(scene->moved_objects(), 0u);
}

TEST_F(AddedTest, AnotherAssetTakesThePlaceOfTheFirst) {
    put("box", lodestream::testing::moved(lodestream::testing::sphere(6), {0, 0, 0}, 0.8f));
    const mesh::Model model = with_nodes(spheres(3, 16));
    bake(model);
    const auto scene = open();
    change(*scene, showing_asset(5, "crate", by(4, 2, 1)));
    make_true(*scene);
    change(*scene, showing_asset(5, "box", by(4, 2, 1)));
    make_rests(*scene);
    const mesh::Mesh meant = both(expected(model, {{4, {Mat4d(1.0), false}}}), crate_at(by(4, 2, 1), "box"));
    expect_shows(*scene, meant);
    make_true(*scene);
    expect_shows(*scene, meant, true);
}

TEST_F(AddedTest, ANewNodeIsThereAndMovesWithThoseAbove) {
    const mesh::Model model = with_nodes(spheres(3, 16));
    bake(model);
    const auto scene = open();
    const auto added = scene->change(adding(0, by(3, 4, 3)));
    ASSERT_TRUE(added) << added.error().message;
    EXPECT_EQ(added->added, std::vector<std::uint32_t>{10});
    EXPECT_EQ(scene->change(adding(10, by(0, 2, 0)))->added, std::vector<std::uint32_t>{11});
    make_rests(*scene);
    const mesh::Mesh first = both(crate_at(by(3, 4, 3)), crate_at(by(3, 6, 3)));
    expect_shows(*scene, both(expected(model, {}), first));
    change(*scene, moving(10, by(0, 7, 0)));
    expect_shows(*scene, both(expected(model, {}), both(crate_at(by(0, 7, 0)), crate_at(by(0, 9, 0)))));
    EXPECT_EQ(scene->nodes(0, 100).count, 12u);
    EXPECT_EQ(scene->nodes(11, 1).nodes.front().parent, 10u);
    change(*scene, showing(10, false));
    make_true(*scene);
    expect_shows(*scene, expected(model, {}), true);
    EXPECT_EQ(scene->moved_objects(), 0u) << "hidden, they are as they were before they were added";
}

TEST_F(AddedTest, ATileOfOneObjectTakesInAnother) {
    mesh::Model model = lodestream::testing::empty_scene();
    for (int i = 0; i < 3; ++i)
        lodestream::testing::add_object(
            model, lodestream::testing::moved(lodestream::testing::sphere(90), {3.0f * static_cast<float>(i), 0, 0}));
    model = with_nodes(model);
    bake(model);
    const auto scene = open();
    change(*scene, moving(2, by(0, 0, 7)));  // which leaves the tile that the new one is put beside
    change(*scene, adding(0, by(3, 3, 0)));
    make_rests(*scene);
    const mesh::Mesh meant = both(expected(model, {{1, {by(0, 0, 7), true}}}), crate_at(by(3, 3, 0)));
    expect_shows(*scene, meant);
    make_true(*scene);
    expect_shows(*scene, meant, true);
}

TEST_F(AddedTest, WhatWasAddedSurvivesARestartAndTheEndOfItsAsset) {
    const mesh::Model model = with_nodes(spheres(3, 16));
    bake(model);
    {
        const auto scene = open();
        change(*scene, showing_asset(5, "crate", by(4, 2, 1)));
        change(*scene, adding(0, by(3, 4, 3)));
    }
    ASSERT_TRUE(store.remove_asset("crate"));
    const auto scene = open();
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->nodes(0, 100).count, 11u);
    EXPECT_EQ(scene->nodes(5, 1).nodes.front().asset, "crate");
    make_true(*scene);
    const mesh::Mesh crates = both(crate_at(by(4, 2, 1)), crate_at(by(3, 4, 3)));
    expect_shows(*scene, both(expected(model, {{4, {Mat4d(1.0), false}}}), crates), true);
    change(*scene, moving(10, by(0, 9, 0)));
}

TEST_F(AddedTest, RefusalsChangeNothing) {
    bake(with_nodes(spheres(3, 16)));
    const auto scene = open();
    const auto refusal = [&](const std::vector<proto::NodeChange>& changes) {
        const auto changed = scene->change(changes);
        return changed ? ErrorCode::internal : changed.error().code;
    };
    EXPECT_EQ(refusal(showing_asset(5, "barrel", Mat4d(1.0))), ErrorCode::not_found);
    EXPECT_EQ(refusal(adding(10, Mat4d(1.0))), ErrorCode::not_found) << "no such parent";
    EXPECT_EQ(refusal({{12, Mat4d(1.0), std::nullopt, "crate", 0u}}), ErrorCode::conflict) << "10 is next";
    proto::Asset baking;
    baking.id = baking.name = "baking";
    ASSERT_TRUE(store.put_asset(baking));
    EXPECT_EQ(refusal(showing_asset(5, "baking", Mat4d(1.0))), ErrorCode::conflict);
    EXPECT_EQ(refusal({{proto::next_node, Mat4d(1.0), std::nullopt, "crate", 0u}, {77, Mat4d(1.0), std::nullopt}}),
              ErrorCode::not_found);
    EXPECT_EQ(scene->nodes(0, 100).count, 10u);
    EXPECT_EQ(scene->revision(), 0u);
    EXPECT_FALSE(*store.has_nodes(asset.id));
}

TEST_F(LiveSceneTest, FarAwayAnObjectKeepsItsPrecision) {
    const mesh::Model model = with_nodes(spheres(3, 16));
    bake(model);
    const auto scene = open();
    change(*scene, moving(5, by(1e7, 0, 0)));
    make_true(*scene);
    const proto::Tileset now = scene->tileset();
    ASSERT_TRUE(scene::validate(now.nodes));
    const std::uint32_t own = tile_of_node(now, 5);
    ASSERT_NE(own, scene::none) << "one grid for all would be too coarse";
    EXPECT_NEAR(now.nodes[own].box.min.x, 1e7 + 2.0, 0.01);
    EXPECT_NEAR(now.nodes[own].box.extent().x, 2.0, 0.01);
}

TEST_F(LiveSceneTest, WhatHasNoObjectsCannotBeMoved) {
    asset.id = asset.name = "teapot";
    asset.status = proto::AssetStatus::ready;
    ASSERT_TRUE(store.put_asset(asset));
    const auto single = LiveScene::open(store, asset, files);
    ASSERT_FALSE(single);
    EXPECT_EQ(single.error().code, ErrorCode::conflict);
    EXPECT_THAT(single.error().message, HasSubstr("it is one object"));
    asset.status = proto::AssetStatus::baking;
    EXPECT_EQ(LiveScene::open(store, asset, files).error().code, ErrorCode::unavailable);
}

TEST_F(LiveSceneTest, OfAnOlderBakeItSaysSo) {
    bake(with_nodes(spheres(3, 16)));
    ASSERT_TRUE(store.remove_content(asset.id, bake::objects_key));
    EXPECT_THAT(LiveScene::open(store, asset, files).error().message, HasSubstr("baked by an older version"));
}

TEST_F(LiveSceneTest, DamagedObjectsAreAnError) {
    bake(with_nodes(spheres(3, 16)));
    const auto stored = *store.content(asset.id, bake::objects_key);
    std::vector<std::byte> bytes = *store::read_file(stored.file.path, stored.file.bytes);
    for (const std::size_t size : {0ul, 7ul, 40ul, bytes.size() / 2, bytes.size() - 1}) {
        ASSERT_TRUE(store.put_content(asset.id, bake::objects_key, "objects", std::span(bytes).first(size)));
        EXPECT_FALSE(LiveScene::open(store, asset, files)) << size;
    }
}

}  // namespace
}  // namespace lodestream::live
