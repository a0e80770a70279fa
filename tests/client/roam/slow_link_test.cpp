#include "client/roam/slow_link.h"

#include <gtest/gtest.h>

#include "client/roam/http_tiles.h"
#include "tests/client/roam/plates.h"

namespace lodestream::roam {
namespace {

using testing::FakeTiles;

std::vector<std::uint32_t> nodes_of(const std::vector<Arrival>& arrivals) {
    std::vector<std::uint32_t> nodes;
    for (const Arrival& arrival : arrivals) nodes.push_back(arrival.node);
    return nodes;
}

using Nodes = std::vector<std::uint32_t>;

class SlowLinkTest : public ::testing::Test {
  protected:
    // 20 bytes a tile at 1,600 bits a second are 0.1 s.
    Nodes take(SlowLink& from, double now_s) { return nodes_of(from.take(now_s)); }
    proto::Tileset tileset = testing::plates(3);
    FakeTiles tiles{tileset};
    SlowLink link{tiles, {.downlink_mbps = 0.0016, .rtt_ms = 50.0}};

    void SetUp() override { link.adopt(tileset); }
};

TEST_F(SlowLinkTest, TilesComeOneAfterTheOtherAfterTheRoundTrip) {
    const Nodes all{0, 1, 2};
    link.want(all, 1.0);
    EXPECT_EQ(take(link, 1.149), Nodes{});
    EXPECT_EQ(take(link, 1.151), Nodes{0});
    EXPECT_EQ(take(link, 1.249), Nodes{});
    EXPECT_EQ(take(link, 1.4), (Nodes{1, 2}));
}

TEST_F(SlowLinkTest, WhatWaitsForAConnectionIsCancelledAndOvertaken) {
    ASSERT_EQ(connections, 6u);
    link.want(Nodes{0, 1, 2, 3, 4, 5, 6, 7, 8}, 0.0);
    link.want(Nodes{0, 1, 2, 3, 4, 5, 8, 7}, 0.01);
    EXPECT_EQ(take(link, 0.651), (Nodes{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ(take(link, 10.0), (Nodes{8, 7}));
}

TEST_F(SlowLinkTest, WhatWasSentForComesThoughItIsCancelled) {
    link.want(Nodes{0, 1}, 0.0);
    link.want(Nodes{1}, 0.01);
    EXPECT_EQ(take(link, 0.16), Nodes{0});
    EXPECT_EQ(take(link, 0.26), Nodes{1});
}

TEST_F(SlowLinkTest, AConnectionThatIsFreeAgainPaysTheRoundTripAnew) {
    SlowLink far(tiles, {.downlink_mbps = 0.0, .rtt_ms = 100.0});
    far.adopt(tileset);
    far.want(Nodes{0, 1, 2, 3, 4, 5, 6, 7}, 0.0);
    EXPECT_EQ(take(far, 0.11), (Nodes{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ(take(far, 0.19), Nodes{});
    EXPECT_EQ(take(far, 0.21), (Nodes{6, 7}));
}

TEST_F(SlowLinkTest, AskedForAgainItWaitsAgain) {
    link.want(Nodes{0}, 0.0);
    EXPECT_EQ(take(link, 0.2), Nodes{0});
    link.want(Nodes{0}, 0.2);
    EXPECT_EQ(take(link, 0.34), Nodes{});
    EXPECT_EQ(take(link, 0.36), Nodes{0});
}

TEST_F(SlowLinkTest, NothingComesBeforeItIsHereInTruth) {
    tiles.delay = 1.0;
    link.want(Nodes{0}, 0.0);
    EXPECT_EQ(take(link, 10.0), Nodes{});
    tiles.delay = 0.0;
    EXPECT_EQ(take(link, 10.1), Nodes{0});
}

TEST_F(SlowLinkTest, WithoutLimitsTilesComeAsTheyDo) {
    SlowLink fast(tiles, {});
    fast.adopt(tileset);
    fast.want(Nodes{3, 1}, 0.0);
    EXPECT_EQ(take(fast, 0.0), (Nodes{3, 1}));
}

}  // namespace
}  // namespace lodestream::roam
