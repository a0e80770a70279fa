#include "server/live/live_scenes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "common/base/random.h"
#include "tests/server/live/moving_scene.h"

namespace lodestream::live {
namespace {

using lodestream::testing::spheres;
using testing::by;
using testing::moving;
using testing::with_nodes;
using namespace std::chrono_literals;
using LiveScenesTest = testing::MovingScene;

TEST_F(LiveScenesTest, MakesTrueByItselfWhatAChangeMadeUntrue) {
    bake(with_nodes(spheres(4, 16)));
    LiveScenes scenes(store);
    EXPECT_EQ(*scenes.find_changed(asset), nullptr) << "nobody has changed it";
    EXPECT_EQ(scenes.revision(asset.id), 0u);
    ASSERT_TRUE(scenes.change(asset, moving(3, by(0, 1, 0))));
    const auto scene = *scenes.find_changed(asset);
    ASSERT_NE(scene, nullptr);
    const auto end = std::chrono::steady_clock::now() + 200s;
    const auto is_whole = [&] {
        const proto::Tileset now = scene->tileset();
        return std::ranges::all_of(now.scene_nodes, [](std::uint32_t n) { return n == proto::no_scene_node; }) &&
               now.nodes[0].error < 0.9;
    };
    while (!is_whole() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(20ms);
    EXPECT_TRUE(is_whole());
    EXPECT_FALSE(scene->is_behind());
}

TEST_F(LiveScenesTest, ManyMayChangeAndReadAtOnce) {
    bake(with_nodes(spheres(4, 12)));
    LiveScenes scenes(store);
    std::atomic<bool> stop{false};
    std::vector<std::thread> threads;
    for (std::uint64_t k = 0; k < 2; ++k)
        threads.emplace_back([&, k] {
            Random random{k};
            for (int i = 0; i < 40; ++i) {
                const auto node = static_cast<std::uint32_t>(1 + 16 * random.uniform());
                EXPECT_TRUE(scenes.change(asset, moving(node, by(0, random.uniform(), 0))));
            }
        });
    threads.emplace_back([&] {
        std::uint64_t before = 0;
        while (!stop) {
            const auto scene = scenes.find_changed(asset);
            ASSERT_TRUE(scene);
            if (!*scene) continue;
            const proto::Tileset now = (*scene)->tileset();
            EXPECT_TRUE(scene::validate(now.nodes));
            EXPECT_GE(now.revision, before);
            before = now.revision;
            EXPECT_EQ((*scene)->nodes(0, 100).nodes.size(), 17u);
        }
    });
    for (std::size_t k = 0; k < 2; ++k) threads[k].join();
    stop = true;
    threads.back().join();
}

TEST_F(LiveScenesTest, AForgottenSceneIsOpenedAgain) {
    bake(with_nodes(spheres(3, 12)));
    LiveScenes scenes(store);
    ASSERT_TRUE(scenes.change(asset, moving(3, by(0, 1, 0))));
    const std::uint64_t revision = scenes.revision(asset.id);
    scenes.forget(asset.id);
    EXPECT_EQ(scenes.revision(asset.id), 0u);
    const auto again = scenes.find_changed(asset);
    ASSERT_TRUE(again);
    EXPECT_GE((*again)->revision(), revision);
    EXPECT_EQ((*again)->moved_objects(), 1u);
    ASSERT_TRUE(store.remove_asset(asset.id));
    scenes.forget(asset.id);
    EXPECT_FALSE(scenes.find(asset));
}

TEST_F(LiveScenesTest, OfANewBakeTheOldSceneIsForgotten) {
    bake(with_nodes(spheres(3, 12)));
    LiveScenes scenes(store);
    ASSERT_TRUE(scenes.change(asset, moving(3, by(0, 1, 0))));
    const auto old = *scenes.find(asset);
    ASSERT_TRUE(store.remove_asset(asset.id));
    bake(with_nodes(spheres(4, 12)));
    EXPECT_EQ(*scenes.find_changed(asset), nullptr);
    const auto now = scenes.find(asset);
    ASSERT_TRUE(now);
    EXPECT_NE(*now, old);
    EXPECT_EQ((*now)->nodes(0, 100).count, 17u);
    EXPECT_EQ((*now)->moved_objects(), 0u);
}

}  // namespace
}  // namespace lodestream::live
