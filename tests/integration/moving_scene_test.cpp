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
