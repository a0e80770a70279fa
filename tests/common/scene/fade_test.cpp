#include "common/scene/fade.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/scene/select.h"
#include "tests/common/scene/trees.h"

namespace lodestream::scene {
namespace {

std::vector<std::uint32_t> drawn_at(const std::vector<FadingNode>& drawn, double threshold) {
    std::vector<std::uint32_t> nodes;
    for (const FadingNode& node : drawn)
        if (node.from <= threshold && threshold < node.to) nodes.push_back(node.node);
    return nodes;
}

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> nodes) {
    std::sort(nodes.begin(), nodes.end());
    return nodes;
}

std::vector<std::uint32_t> cut_of(const LodTree& tree, const View& view, double tolerance_px) {
    SelectOptions options;
    options.tolerance_px = tolerance_px;
    return select(tree, view, options).nodes;
}

// Sees the whole tree.
View overview(const Box& box) {
    View view = view_towards(box.center() + Vec3d{0.0, 0.0, 3.0 * box.diagonal()}, box.center());
    view.near = 1e-3 * box.diagonal();
    return view;
}

class TwoLevels : public ::testing::Test {
  protected:
    TwoLevels() : tree(3) {
        tree[0].box = {Vec3d{0.0}, Vec3d{2.0, 1.0, 1.0}};
        tree[0].first_child = 1;
        tree[0].child_count = 2;
        for (std::uint32_t k : {1u, 2u}) {
            tree[k].parent = 0;
            tree[k].box = {Vec3d{k - 1.0, 0.0, 0.0}, Vec3d{1.0 * k, 1.0, 1.0}};
        }
        view = overview(tree[0].box);
    }
    const std::vector<std::uint32_t> coarse{0}, fine{1, 2};
    LodTree tree;
    View view;
    Fading fading;
};

TEST_F(TwoLevels, WhatComesFirstIsThereAtOnce) {
    EXPECT_TRUE(fade(tree, fading, {}, view, 0.1).empty());
    const auto drawn = fade(tree, fading, coarse, view, 0.1);
    ASSERT_EQ(drawn.size(), 1u);
    EXPECT_EQ(drawn[0].from, 0.0);
    EXPECT_EQ(drawn[0].to, 1.0);
}

TEST_F(TwoLevels, GoOverInAsManyFramesAsAreAsked) {
    fade(tree, fading, coarse, view, 0.25);
    for (const double progress : {0.25, 0.5, 0.75}) {
        const auto drawn = fade(tree, fading, fine, view, 0.25);
        EXPECT_EQ(sorted(drawn_at(drawn, progress - 0.01)), fine);
        EXPECT_EQ(drawn_at(drawn, progress), coarse);
        EXPECT_EQ(sorted(shown_nodes(fading)), (std::vector<std::uint32_t>{0, 1, 2}));
    }
    EXPECT_EQ(sorted(drawn_at(fade(tree, fading, fine, view, 0.25), 0.999)), fine);
    EXPECT_EQ(sorted(shown_nodes(fading)), fine);
}

TEST_F(TwoLevels, ATransitionEndsBeforeItsPartTurnsBack) {
    fade(tree, fading, coarse, view, 0.25);
    fade(tree, fading, fine, view, 0.25);
    for (const double progress : {0.5, 0.75}) {
        const auto drawn = fade(tree, fading, coarse, view, 0.25);
        EXPECT_EQ(sorted(drawn_at(drawn, progress - 0.01)), fine);
        EXPECT_EQ(drawn_at(drawn, progress), coarse);
    }
    const auto back = fade(tree, fading, coarse, view, 0.25);
    EXPECT_EQ(drawn_at(back, 0.2), coarse);
    EXPECT_EQ(sorted(drawn_at(back, 0.3)), fine);
}

TEST_F(TwoLevels, OutOfSightOrWithoutTimeTheyGoOverAtOnce) {
    fade(tree, fading, coarse, view, 0.25);
    View away = view_towards(view.eye, view.eye + Vec3d{0.0, 0.0, 1.0});
    away.near = view.near;
    EXPECT_EQ(sorted(drawn_at(fade(tree, fading, fine, away, 0.25), 0.999)), fine);
    EXPECT_EQ(drawn_at(fade(tree, fading, coarse, view, 1.0), 0.999), coarse);
}

TEST_F(TwoLevels, WhatComesIntoViewGoesOverAtOnceAndIsTold) {
    View away = view_towards(view.eye, view.eye + Vec3d{0.0, 0.0, 1.0});
    away.near = view.near;
    fade(tree, fading, coarse, away, 0.25);
    EXPECT_EQ(sorted(drawn_at(fade(tree, fading, fine, view, 0.25), 0.999)), fine);
    ASSERT_EQ(fading.unseen.size(), 1u);
    EXPECT_EQ(fading.unseen[0].going, coarse);
    EXPECT_EQ(sorted(fading.unseen[0].coming), fine);
    EXPECT_EQ(fade(tree, fading, coarse, view, 0.25).size(), 3u) << "seen in both, it fades";
    EXPECT_TRUE(fading.unseen.empty());
}

// Cuts that jump about faster than they can fade, of a camera that jumps too.
TEST(Fade, AtEveryThresholdACutWhateverIsAskedFor) {
    Random random(31);
    for (int round = 0; round < 5; ++round) {
        const LodTree tree = testing::made_tree(300, random);
        Fading fading;
        View view = overview(tree[0].box);
        std::size_t fades = 0;
        for (int frame = 0; frame < 500; ++frame) {
            if (random.uniform() < 0.3) view = testing::made_view(random, tree[0].box);
            const auto cut = cut_of(tree, view, random.log_uniform(0.5, 500.0));
            const auto drawn = fade(tree, fading, cut, view, random.uniform(0.01, 0.5));
            for (const double t : {0.0, random.uniform(), random.uniform(), 0.999999})
                ASSERT_TRUE(testing::covers_each_leaf_once(tree, drawn_at(drawn, t))) << "frame " << frame;
            const auto shown = shown_nodes(fading);
            EXPECT_EQ(std::set(shown.begin(), shown.end()).size(), shown.size()) << "each is shown once";
            for (const FadingNode& node : drawn) {
                ASSERT_GE(node.from, 0.0);
                ASSERT_LE(node.to, 1.0);
                ASSERT_NE(std::ranges::count(shown, node.node), 0);
                fades += node.to < 1.0 ? 1 : 0;
            }
        }
        EXPECT_GT(fades, 100u);
    }
}

TEST(Fade, SettlesOnACutThatStays) {
    Random random(32);
    for (int round = 0; round < 20; ++round) {
        const LodTree tree = testing::made_tree(300, random);
        const View view = overview(tree[0].box);
        Fading fading;
        for (int frame = 0; frame < 10; ++frame)
            fade(tree, fading, cut_of(tree, view, random.log_uniform(0.01, 50.0)), view, 0.2);
        const auto cut = cut_of(tree, view, 0.1);
        // What is under way, and then what waited for it.
        for (int frame = 0; frame < 12; ++frame) fade(tree, fading, cut, view, 0.2);
        EXPECT_TRUE(fading.transitions.empty());
        EXPECT_EQ(sorted(fading.settled), sorted(cut));
    }
}

}  // namespace
}  // namespace lodestream::scene
