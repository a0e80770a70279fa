#include "common/scene/stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "common/scene/fade.h"
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
        EXPECT_EQ(now.requests.front(), 0u);
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
            const std::vector<View> coming(random.next() % 3, testing::made_view(random, tree[0].box));
            const StreamStep now = step(tree, residency, view, options, coming);
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

// The same with levels that fade, and with nodes that turn out to be larger than was said.
TEST(Stream, WhatFadesIsNotDroppedAndTheMemoryStillHolds) {
    Random random(28);
    const LodTree tree = testing::made_tree(400, random);
    for (const std::uint64_t max_bytes : {300'000ull, 1'000'000ull}) {
        Residency residency = nothing_here(tree);
        std::vector<std::uint64_t> true_bytes = residency.bytes;
        for (std::uint64_t& bytes : true_bytes) bytes *= 1 + random.next() % 2;
        StreamOptions options;
        options.max_bytes = max_bytes;
        Fading fading;
        View view = testing::made_view(random, tree[0].box);
        std::size_t faded = 0;
        for (int frame = 0; frame < 3'000; ++frame) {
            if (random.uniform() < 0.1) view = testing::made_view(random, tree[0].box);
            const StreamStep now = step(tree, residency, view, options, {}, shown_nodes(fading));
            const auto drawn = fade(tree, fading, now.drawn, view, 0.1);
            for (const FadingNode& node : drawn) ASSERT_TRUE(residency.has(node.node)) << "frame " << frame;
            for (const std::uint32_t node : now.dropped) ASSERT_FALSE(residency.has(node));
            std::uint64_t asked_for = 0;
            for (const std::uint32_t node : now.requests) asked_for += residency.bytes[node];
            ASSERT_LE(residency.held_bytes + asked_for, max_bytes);
            faded += fading.transitions.size();
            for (const std::uint32_t node : now.requests) {
                if (random.uniform() < 0.5) continue;
                residency.bytes[node] = true_bytes[node];
                arrive(tree, residency, node, options);
                ASSERT_LE(residency.held_bytes, max_bytes);
            }
        }
        EXPECT_GT(faded, 1'000u);
        // Once nothing fades any more, all that is wanted comes.
        for (int frame = 0; frame < 200; ++frame) {
            const StreamStep now = step(tree, residency, view, options, {}, shown_nodes(fading));
            fade(tree, fading, now.drawn, view, 0.5);
            for (const std::uint32_t node : now.requests) {
                residency.bytes[node] = true_bytes[node];
                arrive(tree, residency, node, options);
            }
        }
        EXPECT_EQ(step(tree, residency, view, options, {}, shown_nodes(fading)).missing, 0u);
        EXPECT_TRUE(fading.transitions.empty());
    }
}

TEST(Stream, WhatCannotBeHadIsCoveredByItsParentAndNotAskedForAgain) {
    Random random(29);
    const LodTree tree = testing::made_tree(200, random);
    View view = view_towards(tree[0].box.center() + Vec3d{0.0, 0.0, 100.0}, tree[0].box.center());
    view.near = 0.1;
    StreamOptions options;
    options.tolerance_px = 0.01;
    Residency residency = nothing_here(tree);
    std::vector<bool> is_broken(tree.size(), false), was_asked(tree.size(), false);
    for (std::uint32_t node = 1; node < tree.size(); ++node) is_broken[node] = random.uniform() < 0.1;
    StreamStep now = step(tree, residency, view, options);
    for (; !now.requests.empty(); now = step(tree, residency, view, options)) {
        for (const std::uint32_t node : now.requests) {
            ASSERT_FALSE(is_broken[node] && was_asked[node]) << "asked for again";
            was_asked[node] = true;
            if (is_broken[node])
                give_up(tree, residency, node);
            else
                arrive(tree, residency, node, options);
        }
    }
    EXPECT_TRUE(testing::covers_each_leaf_once(tree, now.drawn));
    EXPECT_EQ(now.missing, 0u);
    std::size_t covering = 0;
    for (const std::uint32_t node : now.drawn) {
        EXPECT_FALSE(is_broken[node]);
        for (std::uint32_t k = 0; k < tree[node].child_count; ++k)
            covering += is_broken[tree[node].first_child + k] ? 1 : 0;
    }
    EXPECT_GT(covering, 0u);
}

TEST(Stream, WithinTheTrianglesTheLargestErrorsAreRefined) {
    Random random(33);
    const LodTree tree = testing::made_tree(500, random);
    std::size_t bounded = 0;
    for (int round = 0; round < 40; ++round) {
        const View view = testing::made_view(random, tree[0].box);
        StreamOptions options;
        options.max_triangles = 20'000;
        const auto settled = [&](const StreamOptions& with) {
            Residency residency = nothing_here(tree);
            StreamStep now = step(tree, residency, view, with);
            for (; !now.requests.empty(); now = step(tree, residency, view, with))
                for (const std::uint32_t node : now.requests) EXPECT_TRUE(arrive(tree, residency, node, with));
            return now;
        };
        const StreamStep some = settled(options), all = settled({});
        EXPECT_TRUE(testing::covers_each_leaf_once(tree, some.drawn));
        EXPECT_LE(testing::triangles_seen(tree, some.drawn, view), options.max_triangles);
        EXPECT_EQ(some.bounded, testing::triangles_seen(tree, all.drawn, view) > options.max_triangles);
        if (!some.bounded) continue;
        ++bounded;
        // Not far from what select() makes of the same triangles, which looks around the place where they end.
        SelectOptions selection;
        selection.budget = options.max_triangles;
        const Projection projection(view);
        double largest_px = 0.0;
        for (const std::uint32_t node : some.drawn)
            largest_px = std::max(largest_px, projection.error_px(tree[node].box, tree[node].error));
        EXPECT_LE(largest_px, 4.0 * select(tree, view, selection).largest_error_px);
    }
    EXPECT_GT(bounded, 10u);
}

TEST(Stream, CountsWhatTheViewItselfIsMissing) {
    Random random(30);
    const LodTree tree = testing::made_tree(200, random);
    View view = view_towards(tree[0].box.center() + Vec3d{0.0, 0.0, 100.0}, tree[0].box.center());
    view.near = 0.1;
    StreamOptions options;
    options.tolerance_px = 0.01;
    options.max_requests = 1;
    Residency residency = nothing_here(tree);
    std::size_t before = step(tree, residency, view, options).missing;
    EXPECT_GT(before, 50u);
    for (StreamStep now = step(tree, residency, view, options); !now.requests.empty();) {
        ASSERT_TRUE(arrive(tree, residency, now.requests[0], options));
        now = step(tree, residency, view, options);
        ASSERT_EQ(now.missing, --before);
    }
    EXPECT_EQ(before, 0u);
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
        const std::vector<View> coming(jump % 2, testing::made_view(random, tree[0].box));
        StreamStep now = step(tree, residency, view, options, coming);
        for (int round = 0; !now.requests.empty(); ++round) {
            ASSERT_LT(round, 100) << "it stalls";
            for (const std::uint32_t node : now.requests) ASSERT_TRUE(arrive(tree, residency, node, options));
            now = step(tree, residency, view, options, coming);
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

TEST(Stream, WhatOnlyAComingViewRefinesIsFetchedLastAndNotDrawn) {
    Random random(26);
    const LodTree tree = testing::made_tree(500, random);
    for (int round = 0; round < 20; ++round) {
        const View view = testing::made_view(random, tree[0].box);
        const std::vector<View> coming{testing::made_view(random, tree[0].box)};
        StreamOptions options;
        Residency alone = nothing_here(tree), both = nothing_here(tree);
        StreamStep plain = step(tree, alone, view, options), now = step(tree, both, view, options, coming);
        while (!now.requests.empty() || !plain.requests.empty()) {
            const std::vector<std::uint32_t> urgent(now.requests.begin(),
                                                    now.requests.end() - std::ptrdiff_t(now.ahead));
            EXPECT_EQ(urgent, plain.requests);
            EXPECT_EQ(now.drawn, plain.drawn);
            for (const std::uint32_t node : plain.requests) ASSERT_TRUE(arrive(tree, alone, node, options));
            for (const std::uint32_t node : now.requests) ASSERT_TRUE(arrive(tree, both, node, options));
            plain = step(tree, alone, view, options);
            now = step(tree, both, view, options, coming);
        }
        const std::vector<std::uint32_t> drawn_later = step(tree, both, coming.front(), options).drawn;
        Residency there = nothing_here(tree);
        StreamStep later = step(tree, there, coming.front(), options);
        while (!later.requests.empty()) {
            for (const std::uint32_t node : later.requests) ASSERT_TRUE(arrive(tree, there, node, options));
            later = step(tree, there, coming.front(), options);
        }
        EXPECT_EQ(drawn_later, later.drawn) << "it is all there when it is wanted";
    }
}

// Frames of a camera that turns around and moves on, with room for half of the tree, over a network that takes ten
// frames for a tile: the sum of what the drawn cut is off beyond the tolerance, once the first tiles are there.
double missing_px(const LodTree& tree, bool looks_ahead) {
    const double radius = tree[0].box.radius();
    Residency residency = nothing_here(tree);
    StreamOptions options;
    options.max_requests = 32;
    options.max_bytes = std::accumulate(residency.bytes.begin(), residency.bytes.end(), std::uint64_t{0}) / 2;
    std::vector<View> path;
    for (int frame = 0; frame < 600; ++frame) {
        const double angle = 0.02 * frame;
        View view;
        view.eye = tree[0].box.center() + radius * Vec3d{0.3 * std::cos(0.2 * angle), 0.1, 0.3 * std::sin(0.2 * angle)};
        view.target = view.eye + Vec3d{std::sin(angle), -0.1, std::cos(angle)};
        view.near = 1e-3 * radius;
        path.push_back(view);
    }
    constexpr std::size_t latency = 10, settled = 100;
    std::map<std::uint32_t, std::size_t> in_flight;  // since which frame
    double missing = 0.0;
    for (std::size_t frame = 1; frame < path.size(); ++frame) {
        std::vector<View> coming;
        if (looks_ahead)
            for (const double steps : {10.0, 30.0}) coming.push_back(ahead_of(path[frame - 1], path[frame], steps));
        const StreamStep now = step(tree, residency, path[frame], options, coming);
        std::map<std::uint32_t, std::size_t> still;
        for (const std::uint32_t node : now.requests) still[node] = in_flight.emplace(node, frame).first->second;
        in_flight = std::move(still);
        for (const auto& [node, since] : in_flight)
            if (frame - since >= latency) arrive(tree, residency, node, options);
        if (frame < settled) continue;
        const Projection projection(path[frame]);
        for (const std::uint32_t node : now.drawn)
            missing += std::max(0.0, projection.error_px(tree[node].box, tree[node].error) - options.tolerance_px);
    }
    return missing;
}

TEST(Stream, LookingAheadAlongTheMotionHalvesWhatIsMissed) {
    Random random(27);
    for (int round = 0; round < 5; ++round) {
        const LodTree tree = testing::made_tree(400, random);
        EXPECT_LT(missing_px(tree, true), 0.5 * missing_px(tree, false));
    }
}

}  // namespace
}  // namespace lodestream::scene
