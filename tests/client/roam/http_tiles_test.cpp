#include "client/roam/http_tiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>

#include "common/codec/level_codec.h"
#include "tests/client/roam/plates.h"
#include "tests/client/sdk/canned_server.h"
#include "tests/support/meshes.h"

namespace lodestream::roam {
namespace {

using lodestream::testing::CannedReply;
using lodestream::testing::CannedServer;
using lodestream::testing::http_reply;
using ::testing::HasSubstr;
using Nodes = std::vector<std::uint32_t>;

std::string encoded_tile() {
    mesh::Model model;
    model.mesh = lodestream::testing::sphere(6);
    model.materials.emplace_back();
    const std::vector<std::uint8_t> gouraud(model.mesh.triangles.size(), 1);
    const auto encoded = codec::encode_level(model, model.mesh, gouraud, {});
    EXPECT_TRUE(encoded) << encoded.error().message;
    return {reinterpret_cast<const char*>(encoded->glb.data()), encoded->glb.size()};
}

CannedReply glb_reply(const std::string& glb) {
    return {http_reply(200, "model/gltf-binary", glb, "Connection: close\r\n"), true};
}

class HttpTilesTest : public ::testing::Test {
  protected:
    void open(const CannedServer& server) {
        auto opened = HttpTiles::open(server.url(), tileset.nodes.front().box);
        ASSERT_TRUE(opened) << opened.error().message;
        tiles = *std::move(opened);
        tiles->adopt(tileset);
    }
    Arrival wait_for(std::uint32_t node) {
        tiles->want(Nodes{node}, 0.0);
        for (;;) {
            auto arrivals = tiles->take(0.0);
            if (!arrivals.empty()) return std::move(arrivals.front());
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }

    proto::Tileset tileset = testing::plates(2);
    std::unique_ptr<HttpTiles> tiles;
};

TEST_F(HttpTilesTest, ATileComesDecodedAndReadyForTheGpu) {
    const std::string glb = encoded_tile();
    tileset.bytes.assign(tileset.bytes.size(), glb.size());
    const CannedServer server({glb_reply(glb), glb_reply(glb)});
    open(server);
    for (const std::uint32_t node : {2u, 2u}) {  // once more where it is wanted once more
        const Arrival arrival = wait_for(node);
        EXPECT_EQ(arrival.node, node);
        ASSERT_TRUE(arrival.part) << arrival.part.error().message;
        EXPECT_EQ(arrival.part->triangles, 2u * 6 * 5);
    }
    EXPECT_THAT(server.requests()[0], HasSubstr("GET /2 "));
}

TEST_F(HttpTilesTest, WhatIsWrongIsTheTilesErrorAndNamesIt) {
    const std::string glb = encoded_tile(), broken = "glTF" + std::string(glb.size() - 4, 'x');
    tileset.bytes.assign(tileset.bytes.size(), glb.size());
    const CannedServer server({glb_reply(broken),
                               {http_reply(404, "text/plain", "gone"), true},
                               {http_reply(200, "model/gltf-binary", glb.substr(1)), true},
                               glb_reply(glb)});
    open(server);
    const Arrival undecodable = wait_for(1), missing = wait_for(2), short_of_a_byte = wait_for(3), fine = wait_for(4);
    ASSERT_FALSE(undecodable.part);
    EXPECT_THAT(undecodable.part.error().message, HasSubstr("/1: "));
    EXPECT_NE(undecodable.part.error().code, ErrorCode::io) << "it would be asked for again";
    ASSERT_FALSE(missing.part);
    EXPECT_EQ(missing.part.error().code, ErrorCode::not_found);
    ASSERT_FALSE(short_of_a_byte.part);
    EXPECT_EQ(short_of_a_byte.part.error().code, ErrorCode::io);
    EXPECT_TRUE(fine.part);
}

TEST_F(HttpTilesTest, AStalledServerKeepsNobodyWaitingAndWhatIsQueuedCanBeCancelled) {
    const CannedServer server({{"HTTP/1.1 200 Fine\r\nContent-Length: 1000\r\n\r\nhalf of"}});
    tileset = testing::plates(3);
    tileset.bytes.assign(tileset.bytes.size(), 1'000);
    open(server);
    const auto start = std::chrono::steady_clock::now();
    Nodes all(tileset.nodes.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    tiles->want(all, 0.0);
    while (server.requests().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    tiles->want({}, 0.0);
    EXPECT_TRUE(tiles->take(0.0).empty());
    tiles.reset();
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
    EXPECT_LE(server.requests().size(), connections) << "of " << all.size();
}

TEST_F(HttpTilesTest, WhatHasMovedIsPutThereWithoutFetchingItAgain) {
    const std::string glb = encoded_tile();
    tileset.bytes.assign(tileset.bytes.size(), glb.size());
    const CannedServer server({glb_reply(glb)});
    open(server);
    ASSERT_TRUE(wait_for(2).part);
    proto::Tileset moved = tileset;
    moved.matrices.assign(moved.nodes.size(), Mat4d(1.0));
    moved.matrices[3][3] = {0, 1, 0, 1};
    moved.uris[3] = moved.uris[2];
    tiles->adopt(moved);
    EXPECT_TRUE(tiles->take(0.0).empty());
    const Arrival arrival = wait_for(3);
    EXPECT_EQ(arrival.node, 3u);
    EXPECT_TRUE(arrival.part);
    EXPECT_EQ(server.requests().size(), 1u);
}

TEST_F(HttpTilesTest, AWrongAddressIsRefusedAtOnce) {
    EXPECT_FALSE(HttpTiles::open("ftp://nowhere", tileset.nodes.front().box));
}

}  // namespace
}  // namespace lodestream::roam
