#include "common/scene/select.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/common/scene/trees.h"

namespace lodestream::scene {
namespace {

using testing::covers_each_leaf_once;
using testing::made_tree;
using testing::made_view;

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> nodes) {
    std::sort(nodes.begin(), nodes.end());
    return nodes;
}

double error_px(const LodTree& tree, std::uint32_t node, const View& view) {
    return Projection(view).error_px(tree[node].box, tree[node].error);
}

TEST(Select, QualityModeMeetsTheToleranceWithNoNodeToSpare) {
    Random random(11);
    for (int round = 0; round < 500; ++round) {
        const LodTree tree = made_tree(2'000, random);
        const View view = made_view(random, tree[0].box);
        SelectOptions options;
        options.tolerance_px = random.log_uniform(0.1, 100.0);
        const Selection selection = select(tree, view, options);
        ASSERT_TRUE(covers_each_leaf_once(tree, selection.nodes));
        ASSERT_LE(selection.largest_error_px, options.tolerance_px);
        for (const std::uint32_t node : selection.nodes)
            if (node != 0) {
                ASSERT_GT(error_px(tree, tree[node].parent, view), options.tolerance_px);
            }
    }
}

TEST(Select, TheBudgetIsNeverExceededInTenThousandViews) {
    Random random(12);
    const LodTree tree = made_tree(3'000, random);
    double start_px = unlimited_px;
    for (int round = 0; round < 10'000; ++round) {
        const View view = made_view(random, tree[0].box);
        SelectOptions options;
        options.budget = static_cast<std::uint64_t>(random.log_uniform(1'000, 1e6));
        options.start_px = start_px;
        const Selection selection = select(tree, view, options);
        ASSERT_TRUE(covers_each_leaf_once(tree, selection.nodes));
        ASSERT_EQ(selection.spent, testing::triangles_seen(tree, selection.nodes, view));
        ASSERT_TRUE(selection.feasible);
        ASSERT_LE(selection.spent, options.budget);
        start_px = selection.threshold_px;
    }
}

TEST(Select, TheLastFramesThresholdChangesNothingButTheTime) {
    Random random(13);
    for (int round = 0; round < 500; ++round) {
        const LodTree tree = made_tree(1'000, random);
        const View view = made_view(random, tree[0].box);
        SelectOptions options;
        options.budget = static_cast<std::uint64_t>(random.log_uniform(1'000, 1e6));
        options.tolerance_px = random.uniform() < 0.5 ? 0.0 : 1.0;
        const Selection from_root = select(tree, view, options);
        for (const double start : {0.0, random.log_uniform(1e-3, 1e9), from_root.threshold_px}) {
            options.start_px = start;
            const Selection started = select(tree, view, options);
            ASSERT_EQ(sorted(started.nodes), sorted(from_root.nodes));
            ASSERT_EQ(started.threshold_px, from_root.threshold_px);
        }
    }
}

TEST(Select, StoppedAnywhereTheCutIsValidAndErrorsDoNotGrow) {
    Random random(14);
    const LodTree tree = made_tree(500, random);
    for (int round = 0; round < 20; ++round) {
        const View view = made_view(random, tree[0].box);
        double last_px = unlimited_px;
        for (std::uint64_t steps = 0; steps < 100; ++steps) {
            SelectOptions options;
            options.max_refinements = steps;
            const Selection unlimited = select(tree, view, options);
            ASSERT_TRUE(covers_each_leaf_once(tree, unlimited.nodes));
            ASSERT_LE(unlimited.largest_error_px, last_px);
            last_px = unlimited.largest_error_px;
            options.budget = 100'000;
            const Selection bounded = select(tree, view, options);
            ASSERT_TRUE(covers_each_leaf_once(tree, bounded.nodes));
            ASSERT_LE(bounded.spent, options.budget);
        }
    }
}

TEST(Select, ABudgetBelowTheRootDrawsItAndSaysSo) {
    Random random(15);
    const LodTree tree = made_tree(100, random);
    View view;
    view.eye = tree[0].box.center() + Vec3d{0, 0, 300};
    view.target = tree[0].box.center();
    SelectOptions options;
    options.budget = 999;
    const Selection selection = select(tree, view, options);
    EXPECT_EQ(selection.nodes, std::vector<std::uint32_t>{0});
    EXPECT_FALSE(selection.feasible);
}

TEST(Select, WhatIsBehindTheCameraStaysCoarse) {
    Random random(16);
    const LodTree tree = made_tree(1'000, random);
    View view;
    view.eye = tree[0].box.min - Vec3d{10.0};
    view.target = view.eye - Vec3d{1.0, 0.0, 0.0};
    EXPECT_EQ(select(tree, view, {}).nodes, std::vector<std::uint32_t>{0});
}

// Every cut of the branch below a node: triangles seen; the errors on the screen, the largest and their sum; the error
// of the picture, which is what each pixel is off by, summed.
struct Choice {
    std::uint64_t triangles = 0;
    double largest_px = 0.0, sum_px = 0.0, picture = 0.0;
};

double picture_error(const LodTree& tree, std::uint32_t node, const View& view) {
    return Projection(view).picture_error(tree[node].box, tree[node].error);
}

std::vector<Choice> all_cuts(const LodTree& tree, std::uint32_t node, const View& view) {
    std::vector<Choice> cuts;
    if (tree[node].child_count > 0) cuts.emplace_back();
    for (std::uint32_t k = 0; k < tree[node].child_count; ++k) {
        std::vector<Choice> joined;
        for (const Choice& right : all_cuts(tree, tree[node].first_child + k, view))
            for (const Choice& left : cuts)
                joined.push_back({left.triangles + right.triangles, std::max(left.largest_px, right.largest_px),
                                  left.sum_px + right.sum_px, left.picture + right.picture});
        cuts = std::move(joined);
    }
    const double error = error_px(tree, node, view);
    cuts.push_back({testing::triangles_seen(tree, {node}, view), error, error, picture_error(tree, node, view)});
    return cuts;
}

// Steps are coarse where a tree is small: one that is a third of the budget fits or does not.
TEST(Select, IsWithinFivePercentOfTheBestOfAllCutsOfSmallTrees) {
    Random random(17);
    constexpr int rounds = 1'000;
    int near_least_sum = 0, near_least_largest = 0;
    double sum = 0.0, best_sum = 0.0, picture = 0.0, best_picture = 0.0;  // as shares of the root's
    for (int round = 0; round < rounds;) {
        const LodTree tree = made_tree(18, random, 100.0, Vec3d{0.0}, 0.0);
        const View view = made_view(random, tree[0].box);
        const double root = picture_error(tree, 0, view), root_px = error_px(tree, 0, view);
        SelectOptions options;
        options.budget = 1'000 + random.next() % 8'000;
        const Selection selection = select(tree, view, options);
        if (!selection.feasible || root == 0.0) continue;
        ++round;
        Choice best{0, unlimited_px, unlimited_px, unlimited_px}, chosen;
        for (const Choice& cut : all_cuts(tree, 0, view)) {
            if (cut.triangles > options.budget) continue;
            best.largest_px = std::min(best.largest_px, cut.largest_px);
            best.sum_px = std::min(best.sum_px, cut.sum_px);
            best.picture = std::min(best.picture, cut.picture);
        }
        for (const std::uint32_t node : selection.nodes) {
            chosen.sum_px += error_px(tree, node, view);
            chosen.picture += picture_error(tree, node, view);
        }
        sum += chosen.sum_px / root_px;
        best_sum += best.sum_px / root_px;
        picture += chosen.picture / root;
        best_picture += best.picture / root;
        near_least_sum += chosen.sum_px <= 1.05 * best.sum_px ? 1 : 0;
        near_least_largest += selection.largest_error_px <= 1.05 * best.largest_px ? 1 : 0;
    }
    RecordProperty("sum_over_best_percent", std::to_string(100.0 * sum / best_sum));
    RecordProperty("picture_error_over_best_percent", std::to_string(100.0 * picture / best_picture));
    RecordProperty("near_least_sum", near_least_sum);
    RecordProperty("near_least_largest", near_least_largest);
    EXPECT_LE(sum, 1.01 * best_sum);
    EXPECT_LE(picture, 1.05 * best_picture);
    EXPECT_GE(near_least_sum, 97 * rounds / 100);
    EXPECT_GE(near_least_largest, 9 * rounds / 10);
}

}  // namespace
}  // namespace lodestream::scene
