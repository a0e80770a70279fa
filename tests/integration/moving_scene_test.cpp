// A scene that changes while it is served, by real processes over real sockets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>

#include "client/sdk/client.h"
#include "common/base/transform.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace lodestream {
namespace {

using namespace std::chrono_literals;

std::vector<proto::NodeChange> lifting(std::uint32_t node, double by) {
    return {{node, matrix_of({0, by, 0}, {0, 0, 0, 1}, {1, 1, 1}), std::nullopt}};
}

double height_of(const proto::Tileset& tileset, std::uint32_t node) {
    const auto found = std::ranges::find(tileset.scene_nodes, node);
    return found == tileset.scene_nodes.end()
               ? 0.0
               : tileset.matrix(static_cast<std::size_t>(found - tileset.scene_nodes.begin()))[3].y;
}

class MovingScene : public ::testing::Test {
  protected:
    void SetUp() override {
        store = (folder.path() / "store").string();
        const std::string bake =
            std::string(LODESTREAM_SERVER " bake sample:ship:60 --store ") + store + " >" + store + ".txt";
        ASSERT_EQ(std::system(bake.c_str()), 0);
    }
    static sdk::Client open(const std::string& url) {
        auto client = sdk::Client::open(url);
        if (!client) throw std::runtime_error(client.error().message);
        return *std::move(client);
    }

    const testing::TemporaryFolder folder;
    std::string store;
};

TEST_F(MovingScene, AWaitingClientHearsOfAChangeAndEveryTileThatItIsToldOfIsThere) {
    const testing::ServerProgram server(LODESTREAM_SERVER, store);
    sdk::Client changing = open(server.url), watching = open(server.url);
    proto::Tileset now = *watching.tileset("ship");
    EXPECT_EQ(now.revision, 0u);
    for (int step = 1; step <= 5; ++step) {
        std::thread change([&] {
            std::this_thread::sleep_for(50ms);
            EXPECT_TRUE(changing.change_nodes("ship", lifting(30, 0.5 * step)));
        });
        while (height_of(now, 30) != 0.5 * step) {
            const auto newer = watching.newer_tileset("ship", now.revision);
            ASSERT_TRUE(newer) << newer.error().message;
            ASSERT_TRUE(*newer) << "nothing came";
            EXPECT_GT((*newer)->revision, now.revision);
            now = **newer;
            for (std::size_t i = 0; i < now.uris.size(); ++i)
                EXPECT_TRUE(watching.fetch(now.uris[i], now.bytes[i])) << now.uris[i];
        }
        change.join();
    }
}

// The whole life of a node: it comes, moves, shows another asset and is taken away, as a client that waits is told it.
TEST_F(MovingScene, AnAddedNodeComesMovesChangesAndGoes) {
    const std::string bake =
        std::string(LODESTREAM_SERVER " bake sample:teapot:800 --store ") + store + " >" + store + ".txt";
    ASSERT_EQ(std::system(bake.c_str()), 0);
    const testing::ServerProgram server(LODESTREAM_SERVER, store);
    sdk::Client changing = open(server.url), watching = open(server.url);
    const proto::Tileset before = *watching.tileset("ship");
    proto::Tileset now = before;
    std::uint64_t revision = 0;
    const auto change = [&](proto::NodeChange one) {
        const auto changed = changing.change_nodes("ship", {std::move(one)});
        ASSERT_TRUE(changed) << changed.error().message;
        EXPECT_GT(changed->revision, revision);
        revision = changed->revision;
    };
    // Waits for a tileset with the change in it in which this holds of the tile of a node, or of its having none.
    const auto wait_for = [&](std::uint32_t node, auto holds) {
        for (int turn = 0; turn < 200; ++turn) {
            const auto newer = watching.newer_tileset("ship", now.revision);
            ASSERT_TRUE(newer) << newer.error().message;
            ASSERT_TRUE(*newer) << "nothing came";
            now = **newer;
            for (std::size_t i = 0; i < now.uris.size(); ++i)
                ASSERT_TRUE(watching.fetch(now.uris[i], now.bytes[i])) << now.uris[i];
            const auto found = std::ranges::find(now.scene_nodes, node);
            const auto tile = static_cast<std::size_t>(found - now.scene_nodes.begin());
            if (now.revision >= revision && holds(tile)) return;
        }
        FAIL() << "it never came";
    };
    const auto is_gone = [&](std::size_t tile) { return tile == now.nodes.size(); };
    const auto is_at = [&](double y) {
        return [&now, y](std::size_t tile) { return tile < now.nodes.size() && now.matrix(tile)[3].y == y; };
    };
    const auto uri_of = [&](std::uint32_t node) {
        return now.uris[static_cast<std::size_t>(std::ranges::find(now.scene_nodes, node) - now.scene_nodes.begin())];
    };
    change({proto::next_node, translation({0, 50, 0}), std::nullopt, "teapot", 0u});
    wait_for(61, is_at(50.0));
    EXPECT_GT(now.nodes.front().box.max.y, 50.0);
    const std::string teapot = uri_of(61);

    change({61, translation({0, 70, 0}), std::nullopt});
    wait_for(61, is_at(70.0));
    EXPECT_EQ(uri_of(61), teapot) << "what it shows need not be fetched again";

    change({61, std::nullopt, std::nullopt, "ship"});
    wait_for(61, [&](std::size_t tile) { return tile < now.nodes.size() && now.uris[tile] != teapot; });

    change({proto::next_node, translation({0, 1, 0}), std::nullopt, "teapot", 61u});  // the first one carries it
    wait_for(62, is_at(71.0));
    EXPECT_EQ(uri_of(62), teapot);

    change({62, std::nullopt, std::nullopt, ""});  // nothing to show any more
    wait_for(62, is_gone);
    change({61, std::nullopt, std::nullopt, ""});
    wait_for(61, is_gone);
    for (int turn = 0; turn < 100 && now.nodes.front().error > before.nodes.front().error + 1e-9; ++turn)
        if (const auto newer = watching.newer_tileset("ship", now.revision); newer && *newer) now = **newer;
    EXPECT_LT(now.nodes.front().error, before.nodes.front().error + 1e-9) << "nothing of it is told any more";
    const auto nodes = changing.nodes("ship");
    ASSERT_TRUE(nodes);
    EXPECT_EQ(nodes->count, 63u) << "numbers of nodes are not given twice";
    EXPECT_EQ(nodes->nodes.at(61).asset + nodes->nodes.at(62).asset, "");
    const auto refused = changing.change_nodes("ship", {{64, std::nullopt, std::nullopt, "teapot", 0u}});
    ASSERT_FALSE(refused) << "the next one is 63";
    const auto unknown = changing.change_nodes("ship", {{proto::next_node, std::nullopt, std::nullopt, "kettle", 0u}});
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find("kettle"), std::string::npos) << unknown.error().message;
}

TEST_F(MovingScene, AKilledServerHasEveryChangeThatItAnsweredAndTheSceneIsWhole) {
    std::uint64_t revision = 0;
    int answered = 0;
    {
        testing::ServerProgram server(LODESTREAM_SERVER, store);
        std::thread killer([&] {
            std::this_thread::sleep_for(700ms);
            server.signal(SIGKILL);
        });
        sdk::Client client = open(server.url);
        for (int step = 1;; ++step) {
            const auto changed =
                client.change_nodes("ship", lifting(static_cast<std::uint32_t>(1 + step % 60), 0.01 * step));
            if (!changed) break;
            revision = changed->revision;
            answered = step;
        }
        killer.join();
        EXPECT_EQ(server.wait(), -SIGKILL);
    }
    ASSERT_GT(answered, 3);
    const testing::ServerProgram server(LODESTREAM_SERVER, store);
    sdk::Client client = open(server.url);
    const auto nodes = client.nodes("ship");
    ASSERT_TRUE(nodes) << nodes.error().message;
    for (int step = std::max(1, answered - 59); step <= answered; ++step) {
        const double y = nodes->nodes.at(static_cast<std::size_t>(1 + step % 60)).placement.matrix[3].y;
        EXPECT_TRUE(y == 0.01 * step || y == 0.01 * (step + 60) ||
                    (step == answered - 59 && y == 0.01 * (answered + 1)))
            << step << ": " << y;
    }
    const auto now = client.tileset("ship");
    ASSERT_TRUE(now) << now.error().message;
    EXPECT_GT(now->revision, revision);
    for (std::size_t i = 0; i < now->uris.size(); ++i)
        EXPECT_TRUE(client.fetch(now->uris[i], now->bytes[i])) << now->uris[i];
}

TEST_F(MovingScene, AKilledServerHasEveryNodeThatItAnsweredToHaveAdded) {
    std::uint32_t last = 60;
    {
        testing::ServerProgram server(LODESTREAM_SERVER, store);
        std::thread killer([&] {
            std::this_thread::sleep_for(900ms);
            server.signal(SIGKILL);
        });
        sdk::Client client = open(server.url);
        for (;;) {
            const Mat4d place = matrix_of({0, 3.0 * last, 0}, {0, 0, 0, 1}, {0.1, 0.1, 0.1});
            const auto changed = client.change_nodes("ship", {{proto::next_node, place, std::nullopt, "ship", 0u}});
            if (!changed) break;
            ASSERT_EQ(changed->added, std::vector<std::uint32_t>{last + 1});
            ++last;
        }
        killer.join();
        EXPECT_EQ(server.wait(), -SIGKILL);
    }
    ASSERT_GT(last, 61u);
    const testing::ServerProgram server(LODESTREAM_SERVER, store);
    sdk::Client client = open(server.url);
    const auto nodes = client.nodes("ship");
    ASSERT_TRUE(nodes) << nodes.error().message;
    EXPECT_GE(nodes->count, last + 1u);
    EXPECT_LE(nodes->count, last + 2u);
    for (std::uint32_t node = 61; node <= last; ++node) {
        EXPECT_EQ(nodes->nodes.at(node).asset, "ship");
        EXPECT_EQ(nodes->nodes.at(node).placement.matrix[3].y, 3.0 * (node - 1));
    }
    const auto now = client.tileset("ship");
    ASSERT_TRUE(now) << now.error().message;
    for (std::size_t i = 0; i < now->uris.size(); ++i)
        EXPECT_TRUE(client.fetch(now->uris[i], now->bytes[i])) << now->uris[i];
}

}  // namespace
}  // namespace lodestream
