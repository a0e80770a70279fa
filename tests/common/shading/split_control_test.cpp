#include "common/shading/split_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/shading/hybrid_split.h"

namespace lodestream::shading {
namespace {

constexpr std::uint32_t steps = 8;
constexpr double radius = 1.0;
constexpr std::uint64_t triangles = 10'000;

// Errors that fall like 1/k, as a real level's do.
std::vector<double> falling_curve(double scale = 1e-6) {
    std::vector<double> left(triangles + 1, 0.0);
    for (std::size_t k = triangles; k-- > 0;) left[k] = left[k + 1] + scale / static_cast<double>(k + 1);
    return left;
}

double allowed(const SplitControlOptions& options) {
    return options.max_change * options.max_change * pi * radius * radius;
}

TEST(SplitControl, AStepHoldsUntilItsEdgeIsPassedByTheMargin) {
    const std::vector<double> left = falling_curve(1e-12);  // so little that the border follows at once
    const SplitCurve curve{left, radius};
    SplitState state = settled_split(0.499, steps, triangles);
    ASSERT_EQ(state.step, 4u);
    for (const double d : {0.501, 0.49, 0.52, 0.499, 0.53, 0.36}) {
        state = move_split(state, d, steps, curve).state;
        EXPECT_EQ(state.step, 4u) << d;
    }
    state = move_split(state, 0.54, steps, curve).state;
    EXPECT_EQ(state.step, 5u);
    state = move_split(state, 0.48, steps, curve).state;
    EXPECT_EQ(state.step, 5u);  // and back only past the margin on the other side
    state = move_split(state, 0.46, steps, curve).state;
    EXPECT_EQ(state.step, 4u);
    EXPECT_EQ(state.gouraud, gouraud_count(triangles, 0.5));
}

TEST(SplitControl, AnotherLevelKeepsTheStepAndTheShare) {
    EXPECT_EQ(on_level({3, 500}, 1000, 80).gouraud, 40u);
    EXPECT_EQ(on_level({3, 500}, 1000, 80).step, 3u);
    EXPECT_EQ(on_level({0, 1000}, 1000, 7).gouraud, 7u);
    EXPECT_EQ(on_level({8, 0}, 1000, 7).gouraud, 0u);
    EXPECT_EQ(on_level({0, 9}, 3, 10).gouraud, 10u);
    EXPECT_EQ(on_level({0, 0}, 0, 10).gouraud, 0u);
    EXPECT_EQ(on_level({0, 5}, 5, 0).gouraud, 0u);
}

TEST(SplitControl, JitterAtAnEdgeChangesTheStepOnce) {
    const std::vector<double> left = falling_curve();
    SplitState state = settled_split(0.25, steps, triangles);
    std::size_t changes = 0;
    for (int frame = 0; frame < 1000; ++frame) {
        const SplitState next = move_split(state, 0.25 + 0.03 * std::sin(frame), steps, {left, radius}).state;
        changes += next.step != state.step ? 1 : 0;
        state = next;
    }
    EXPECT_LE(changes, 1u);
}

TEST(SplitControl, NoFrameMovesMoreThanTheBoundAndTheBorderArrives) {
    const std::vector<double> left = falling_curve();
    const SplitControlOptions options{.max_change = 0.2 / 255.0};
    for (const auto& [from, to] : {std::pair{0.0, 1.0}, std::pair{1.0, 0.0}}) {
        SplitState state = settled_split(from, steps, triangles);
        const SplitState end = settled_split(to, steps, triangles);
        int frames = 0;
        while (state.gouraud != end.gouraud) {
            const SplitMove move = move_split(state, to, steps, {left, radius}, options);
            const double moved = std::abs(left[state.gouraud] - left[move.state.gouraud]);
            EXPECT_DOUBLE_EQ(move.squared_change, moved);
            ASSERT_NE(move.state.gouraud, state.gouraud);
            const std::uint64_t places =
                std::max(move.state.gouraud, state.gouraud) - std::min(move.state.gouraud, state.gouraud);
            EXPECT_TRUE(moved <= allowed(options) || places == 1) << moved;
            state = move.state;
            ASSERT_LT(++frames, 10'000);
        }
        EXPECT_GE(frames, 5);
    }
}

TEST(SplitControl, OneTriangleAboveTheBoundMovesAlone) {
    const std::vector<double> left{3.0, 2.0, 1.0, 0.0};
    const SplitMove up = move_split({2, 0}, 0.0, 2, {left, radius});
    EXPECT_EQ(up.state.gouraud, 1u);
    EXPECT_EQ(up.squared_change, 1.0);
    const SplitMove down = move_split({0, 3}, 1.0, 2, {left, radius});
    EXPECT_EQ(down.state.gouraud, 2u);
}

TEST(SplitControl, StandingStillChangesNothing) {
    const std::vector<double> left = falling_curve();
    SplitState state = settled_split(0.4, steps, triangles);
    const SplitMove move = move_split(state, 0.4, steps, {left, radius});
    EXPECT_EQ(move.state.gouraud, state.gouraud);
    EXPECT_EQ(move.squared_change, 0.0);
}

TEST(SplitControl, SurvivesDistancesThatAreNoneAndLevelsWithoutTriangles) {
    const std::vector<double> left = falling_curve(), empty{0.0};
    for (const double d : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e300}) {
        const SplitMove move = move_split({77, ~0ull}, d, 0, {left, radius});
        EXPECT_LE(move.state.gouraud, triangles);
        EXPECT_TRUE(std::isfinite(move.squared_change));
        EXPECT_LE(settled_split(d, 0, triangles).gouraud, triangles);
    }
    EXPECT_EQ(move_split({0, 5}, 0.5, steps, {empty, 0.0}).state.gouraud, 0u);
    EXPECT_EQ(move_split({0, 5}, 0.5, steps, {}).state.gouraud, 5u);
}

}  // namespace
}  // namespace lodestream::shading
