// A baked scene in a store, and what a tileset of it shows.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "common/base/transform.h"
#include "common/codec/level_codec.h"
#include "common/mesh/instances.h"
#include "common/mesh/operations.h"
#include "server/bake/hlod.h"
#include "server/live/live_scene.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::live::testing {

inline Mat4d by(double x, double y, double z) {
    return matrix_of({x, y, z}, {0, 0, 0, 1}, {1, 1, 1});
}

inline std::vector<proto::NodeChange> moving(std::uint32_t node, const Mat4d& matrix) {
    return {{node, matrix, std::nullopt}};
}
inline std::vector<proto::NodeChange> showing(std::uint32_t node, bool visible) {
    return {{node, std::nullopt, visible}};
}

// A node for each object below node 0.
inline mesh::Model with_nodes(mesh::Model model) {
    model.graph = mesh::flat_graph(model.objects);
    return model;
}

struct MovingScene : ::testing::Test {
    lodestream::testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());
    std::shared_ptr<TransientFiles> files = std::make_shared<TransientFiles>(store);
    proto::Asset asset;

    void bake(const mesh::Model& model) {
        asset.id = asset.name = "scene";
        asset.status = proto::AssetStatus::ready;
        asset.hierarchy.emplace();
        ASSERT_TRUE(store.put_asset(asset));
        const auto shapes = bake::make_shape_levels(model, [] { return true; });
        ASSERT_TRUE(shapes);
        const mesh::Mesh whole = mesh::flattened(model, model.shapes);
        const auto tree = bake::make_tiles(store, asset.id, {model, *shapes, whole}, {}, [](double) { return true; });
        ASSERT_TRUE(tree) << tree.error().message;
    }
    std::shared_ptr<LiveScene> open() {
        auto scene = LiveScene::open(store, asset, files);
        EXPECT_TRUE(scene) << scene.error().message;
        return scene ? *scene : nullptr;
    }
    static void change(LiveScene& scene, const std::vector<proto::NodeChange>& changes) {
        const auto changed = scene.change(changes);
        EXPECT_TRUE(changed) << changed.error().message;
    }
    static void make_rests(LiveScene& scene) {
        while (scene.make_rest()) continue;
    }
    static void make_aboves(LiveScene& scene) {
        while (scene.make_above([] { return true; })) continue;
    }
    // Everything, once all objects are at rest.
    static void make_true(LiveScene& scene) {
        make_rests(scene);
        std::this_thread::sleep_for(rest_time);
        make_aboves(scene);
        EXPECT_FALSE(scene.make_rest());
    }

    // In world coordinates.
    mesh::Mesh content(const proto::Tileset& tileset, std::size_t tile) const {
        const std::string hash = tileset.uris[tile].substr(std::string("/v1/content/").size(), 64);
        const auto file = store.file(hash, "glb");
        EXPECT_TRUE(file) << tileset.uris[tile];
        mesh::Mesh all;
        if (!file) return all;
        const codec::Decoded decoded = *codec::decode_level(*store::read_file(file->path, file->bytes));
        for (const codec::Primitive& primitive : decoded.primitives) {
            mesh::Mesh bare;
            bare.positions = primitive.mesh.positions;
            bare.triangles = primitive.mesh.triangles;
            bare = mesh::placed(std::move(bare), decoded.origin, tileset.matrix(tile));
            for (Vec3f& p : bare.positions) p = Vec3f(Vec3d(p) + decoded.origin);
            mesh::append(all, bare);
        }
        return all;
    }
    mesh::Mesh finest_below(const proto::Tileset& tileset, std::uint32_t tile) const {
        const scene::LodNode& node = tileset.nodes[tile];
        if (node.child_count == 0) return content(tileset, tile);
        mesh::Mesh all;
        for (std::uint32_t i = 0; i < node.child_count; ++i)
            mesh::append(all, finest_below(tileset, node.first_child + i));
        return all;
    }
};

}  // namespace lodestream::live::testing
