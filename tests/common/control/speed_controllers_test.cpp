// The speed-based controllers against tables worked out by hand from the pseudocode (seeds-digest §2). With α = 1/32 a
// level, LOD_est is 1 at 32 degrees/s and 2 at 64, both exact.
#include "common/control/speed_controllers.h"

#include <gtest/gtest.h>

#include <vector>

#include "common/control/reactive.h"

namespace lodestream::control {
namespace {

const SpeedOptions by_hand{5.0, 1.0 / 32.0, 1.0 / 128.0};
const std::vector<Level> three{{4000, 0.0}, {1000, 1.0}, {250, 2.0}};

Options options() {
    Options out;
    out.speed = by_hand;
    return out;
}

std::vector<std::uint32_t> levels(Kind kind, const std::vector<Level>& ladder, const std::vector<double>& speeds) {
    std::vector<std::uint32_t> out;
    State state;
    for (const double speed : speeds) {
        Measurement now;
        now.interval_s = 0.25;
        now.speed_deg_s = speed;
        Step taken = step(kind, ladder, options(), state, now);
        state = taken.state;
        out.push_back(taken.decision.level);
    }
    return out;
}

using Levels = std::vector<std::uint32_t>;

TEST(Isblc, FollowsTheTableWorkedOutByHand) {
    // still: 0 | at S_min: still | moving, est 0.16 > 0: 1 | est = LOD_curr = 1: held | est 1.03: 2 | est = 2: held |
    // est 3.1, but LOD_max: 2 | slower: held, twice | at S_min: 1 | still: 0 | still: LOD_min
    EXPECT_EQ(levels(Kind::isblc, three, {0, 5, 5.1, 32, 33, 64, 100, 40, 6, 5, 1, 0}),
              (Levels{0, 0, 1, 1, 2, 2, 2, 2, 2, 1, 0, 0}));
}

TEST(Isblc, CoarsensOneStepAFrameHoweverFast) {
    EXPECT_EQ(levels(Kind::isblc, three, {0, 1e6, 1e6, 1e6, 0, 1e6}), (Levels{0, 1, 2, 2, 1, 2}));
}

TEST(Isblc, HoldsAcrossAReversal) {
    // 70 one way, through 20, 70 the other way: the level is that of the fastest until the view is still.
    EXPECT_EQ(levels(Kind::isblc, three, {70, 70, 20, 20, 70, 70, 3, 3}), (Levels{1, 2, 2, 2, 2, 2, 1, 0}));
}

TEST(Isblc, AnEstimateEqualToTheLevelHoldsIt) {
    EXPECT_EQ(isblc(1, 32.0, 2, by_hand), 1u);
    EXPECT_EQ(isblc(1, 32.0000001, 2, by_hand), 2u);
    EXPECT_EQ(isblc(2, 5.0, 2, by_hand), 1u);
    EXPECT_EQ(isblc(2, 5.0000001, 2, by_hand), 2u);
}

TEST(Sblc, FollowsTheTableWorkedOutByHand) {
    // 0 | S_min: 0 | ⌈0.19⌉ | ⌈1⌉ | ⌈1.03⌉ | unchanged | ⌈2⌉ | LOD_max | ⌈1.25⌉ | ⌈0.63⌉ | still
    EXPECT_EQ(levels(Kind::sblc, three, {0, 5, 6, 32, 33, 33, 64, 1000, 40, 20, 5}),
              (Levels{0, 0, 1, 1, 2, 2, 2, 2, 2, 1, 0}));
}

TEST(Sblc, JumpsSeveralLevelsAtOnceBothWays) {
    EXPECT_EQ(levels(Kind::sblc, three, {0, 64, 0, 64}), (Levels{0, 2, 0, 2}));
}

TEST(Sblc, LooksAtTheSpeedOnlyWhenItChanges) {
    EXPECT_EQ(sblc(0, 64.0, 64.0, 2, by_hand), 0u);
    EXPECT_EQ(sblc(0, 64.0, 63.0, 2, by_hand), 2u);
}

TEST(Acceleration, FollowsTheTableWorkedOutByHand) {
    // Steps of 0.25 s and 1/128 level per degree/s²: 0 | +32/0.25 = 128: est 1 > 0: 1 | +32: est 1 = 1: held |
    // +64: est 2 > 1: 2 | even: held | falls: held | still: 1 | still: 0
    EXPECT_EQ(levels(Kind::acceleration, three, {0, 32, 64, 128, 128, 40, 4, 0}), (Levels{0, 1, 1, 2, 2, 2, 1, 0}));
}

TEST(Acceleration, CoarsensAtALowerSpeedThanIsblcWouldNeed) {
    EXPECT_EQ(isblc(1, 20.0, 2, by_hand), 1u);
    EXPECT_EQ(acceleration(1, 20.0, 300.0, 2, by_hand), 2u);
}

TEST(Acceleration, SlowingDownHolds) {
    EXPECT_EQ(acceleration(1, 50.0, -1e6, 2, by_hand), 1u);
    EXPECT_EQ(acceleration(0, 50.0, 0.0, 2, by_hand), 0u);
}

TEST(SpeedControllers, ALadderOfOneLevelStaysThere) {
    const std::vector<Level> one{{10, 0.5}};
    for (const Kind kind : kinds) EXPECT_EQ(levels(kind, one, {0, 5, 50, 1e6, 0}), (Levels{0, 0, 0, 0, 0}));
}

TEST(SpeedControllers, TheCoarsestOfAnyLadderIsTakenAtTheSameSpeed) {
    const SpeedOptions three_levels = speed_options(3), nine_levels = speed_options(9);
    EXPECT_EQ(three_levels.levels_per_deg_s, SpeedOptions{}.levels_per_deg_s);
    EXPECT_EQ(sblc(0, 150.0, 0.0, 2, three_levels), 2u);
    EXPECT_EQ(sblc(0, 150.0, 0.0, 8, nine_levels), 8u);
    EXPECT_EQ(sblc(0, 70.0, 0.0, 8, nine_levels), 4u);
    for (const std::size_t few : {1u, 2u}) EXPECT_GT(speed_options(few).levels_per_deg_s, 0.0);
}

TEST(None, NeverLeavesTheFinest) {
    EXPECT_EQ(levels(Kind::none, three, {0, 1e6, 50}), (Levels{0, 0, 0}));
}

TEST(Reactive, MovesTheAcceptedErrorByFivePercentAFrame) {
    EXPECT_DOUBLE_EQ(react(1.0, 20.0, 10.0, three).error_px, 1.05);
    EXPECT_DOUBLE_EQ(react(1.0, 5.0, 10.0, three).error_px, 1.0 / 1.05);
    EXPECT_DOUBLE_EQ(react(1.0, 10.4, 10.0, three).error_px, 1.0);
    EXPECT_DOUBLE_EQ(react(1.0, 9.6, 10.0, three).error_px, 1.0);
    EXPECT_DOUBLE_EQ(react(1.0, -1.0, 10.0, three).error_px, 1.0);
}

TEST(Reactive, TakesTheCoarsestLevelWithNoMoreErrorThanAccepted) {
    EXPECT_EQ(react(0.99, 10.0, 10.0, three).level, 0u);
    EXPECT_EQ(react(1.0, 10.0, 10.0, three).level, 1u);
    EXPECT_EQ(react(2.0, 10.0, 10.0, three).level, 2u);
}

TEST(Reactive, KeepsTheAcceptedErrorWithinTheLadder) {
    EXPECT_DOUBLE_EQ(react(0.0, 10.0, 10.0, three).error_px, 0.5);
    EXPECT_DOUBLE_EQ(react(1e9, 20.0, 10.0, three).error_px, 2.1);
}

TEST(Control, KindsHaveNames) {
    for (const Kind kind : kinds) EXPECT_EQ(*parse_kind(kind_name(kind)), kind);
    EXPECT_FALSE(parse_kind("best"));
}

TEST(Control, RefusesLaddersAndOptionsThatAreWrong) {
    EXPECT_TRUE(check(three, Options{}));
    EXPECT_FALSE(check({}, Options{}));
    EXPECT_FALSE(check(std::vector<Level>(max_levels + 1, Level{1, 0.0}), Options{}));
    EXPECT_FALSE(check(std::vector<Level>{{10, 0.0}, {10, 1.0}}, Options{}));
    EXPECT_FALSE(check(std::vector<Level>{{10, 1.0}, {5, 0.5}}, Options{}));
    Options zero;
    zero.target_fps = 0.0;
    EXPECT_FALSE(check(three, zero));
    Options crossed;
    crossed.predictive.refine_share = 2.0;
    EXPECT_FALSE(check(three, crossed));
}

TEST(MotionBlur, HasOneExposureWhenStillThenTwoThenFour) {
    const BlurOptions blur{true, 10.0, 90.0};
    EXPECT_EQ(exposures(0.0, blur), 1u);
    EXPECT_EQ(exposures(10.0, blur), 1u);
    EXPECT_EQ(exposures(10.1, blur), 2u);
    EXPECT_EQ(exposures(90.0, blur), 2u);
    EXPECT_EQ(exposures(1e9, blur), 4u);
    EXPECT_EQ(exposures(std::numeric_limits<double>::quiet_NaN(), blur), 1u);
    EXPECT_EQ(exposures(1e9, BlurOptions{false}), 1u);
}

}  // namespace
}  // namespace lodestream::control
