#include "common/scene/stream.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/scene/select.h"
#include "tests/common/scene/trees.h"

namespace lodestream::scene {
namespace {

Residency nothing_here(const LodTree& tree) {
    std::vector<std::uint64_t> bytes;
    for (const LodNode& node : tree) bytes.push_back(10 * node.triangles);
    return Residency(std::move(bytes));
}

TEST(Stream, FillsInFromTheRootToWhatTheViewSelects) {
    Random random(21);
    const LodTree tree = testing::made_tree(500, random);
    for (int round = 0; round < 20; ++round) {
        const View view = testing::made_view(random, tree[0].box);
        Residency residency = nothing_here(tree);
        StreamOptions options;
        StreamStep now = step(tree, residency, view, options);
        EXPECT_TRUE(now.drawn.empty());
        EXPECT_EQ(now.requests, std::vector<std::uint32_t>{0});
        while (!now.requests.empty()) {
            for (const std::uint32_t node : now.requests) ASSERT_TRUE(arrive(tree, residency, node, options));
            now = step(tree, residency, view, options);
            ASSERT_TRUE(testing::covers_each_leaf_once(tree, now.drawn));
        }
        SelectOptions selection;
        selection.tolerance_px = options.tolerance_px;
        std::vector<std::uint32_t> wanted = select(tree, view, selection).nodes;
        std::sort(wanted.begin(), wanted.end());
        std::sort(now.drawn.begin(), now.drawn.end());
        EXPECT_EQ(now.drawn, wanted);
        EXPECT_FALSE(now.bounded);
    }
}

// A camera that jumps, a network that loses, delays and reorders, and a memory that is too small.
TEST(Stream, NeverAHoleNeverBothNeverBeyondTheMemoryWhateverArrives) {
    Random random(22);
    const LodTree tree = testing::made_tree(400, random);
    for (const std::uint64_t max_bytes : {20'000ull, 100'000ull, 1'000'000ull}) {
        Residency residency = nothing_here(tree);
        StreamOptions options;
        options.max_bytes = max_bytes;
        std::vector<std::uint32_t> in_flight;
        View view = testing::made_view(random, tree[0].box);
        bool had_root = false;
        for (int frame = 0; frame < 3'000; ++frame) {
            if (random.uniform() < 0.1) view = testing::made_view(random, tree[0].box);
            const StreamStep now = step(tree, residency, view, options);
            if (had_root) {
                ASSERT_TRUE(testing::covers_each_leaf_once(tree, now.drawn));
            }
            for (const std::uint32_t node : now.drawn) ASSERT_TRUE(residency.has(node));
            for (const std::uint32_t node : now.dropped) ASSERT_FALSE(residency.has(node));
            ASSERT_LE(now.requests.size(), options.max_requests);
            std::uint64_t held = 0;
            for (std::uint32_t node = 0; node < tree.size(); ++node) {
                if (!residency.has(node)) continue;
                held += residency.bytes[node];
                if (node > 0) {
                    ASSERT_TRUE(residency.has(tree[node].parent));
                }
            }
            ASSERT_EQ(held, residency.held_bytes);
            ASSERT_LE(held, max_bytes);
            // Some of what was cancelled comes all the same.
            for (const std::uint32_t node : now.requests) in_flight.push_back(node);
            for (std::size_t k = random.next() % 4; k > 0 && !in_flight.empty(); --k) {
                const std::size_t which = random.next() % in_flight.size();
                const std::uint32_t node = in_flight[which];
                in_flight.erase(in_flight.begin() + static_cast<std::ptrdiff_t>(which));
                if (arrive(tree, residency, node, options) && node == 0) had_root = true;
            }
        }
        ASSERT_TRUE(had_root);
    }
}

TEST(Stream, WhatIsWantedAlwaysFindsRoom) {
    Random random(23);
    const LodTree tree = testing::made_tree(400, random);
    Residency residency = nothing_here(tree);
    StreamOptions options;
    options.max_bytes = 60'000;
    bool was_bounded = false;
    for (int jump = 0; jump < 200; ++jump) {
        const View view = testing::made_view(random, tree[0].box);
        StreamStep now = step(tree, residency, view, options);
        for (int round = 0; !now.requests.empty(); ++round) {
            ASSERT_LT(round, 100) << "it stalls";
            for (const std::uint32_t node : now.requests) ASSERT_TRUE(arrive(tree, residency, node, options));
            now = step(tree, residency, view, options);
        }
        was_bounded = was_bounded || now.bounded;
    }
    EXPECT_TRUE(was_bounded);
}

TEST(Stream, ARootLargerThanTheMemoryIsHeldAlone) {
    Random random(24);
    const LodTree tree = testing::made_tree(50, random);
    Residency residency = nothing_here(tree);
    StreamOptions options;
    options.max_bytes = 1;
    const View view = testing::made_view(random, tree[0].box);
    EXPECT_EQ(step(tree, residency, view, options).requests, std::vector<std::uint32_t>{0});
    EXPECT_TRUE(arrive(tree, residency, 0, options));
    const StreamStep now = step(tree, residency, view, options);
    EXPECT_EQ(now.drawn, std::vector<std::uint32_t>{0});
    EXPECT_TRUE(now.requests.empty());
    EXPECT_FALSE(arrive(tree, residency, tree[0].first_child, options));
}

TEST(Stream, AnOrphanIsNotKept) {
    Random random(25);
    const LodTree tree = testing::made_tree(50, random);
    Residency residency = nothing_here(tree);
    EXPECT_FALSE(arrive(tree, residency, tree[0].first_child, {}));
    EXPECT_EQ(residency.held_bytes, 0u);
}

}  // namespace
}  // namespace lodestream::scene
