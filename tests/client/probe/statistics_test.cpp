#include "client/probe/statistics.h"

#include <gtest/gtest.h>

namespace lodestream::probe {
namespace {

TEST(Statistics, MedianOfOddEvenAndNone) {
    EXPECT_EQ(median({3, 1, 2}), 2.0);
    EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
    EXPECT_EQ(median({}), 0.0);
}

TEST(Statistics, ARateIsTheMedianAndNotMovedByADisturbedRun) {
    const Rate rate = rate_of({100, 101, 99, 100, 1});
    EXPECT_EQ(rate.per_second, 100.0);
    EXPECT_EQ(rate.runs, 5u);
    // The median deviation is 1: 1.96 * 1.2533 * 1.4826 / √5
    EXPECT_NEAR(rate.uncertainty_percent, 1.6287, 1e-3);
}

TEST(Statistics, UncertaintyShrinksWithTheRuns) {
    std::vector<double> few, many;
    for (int i = 0; i < 10; ++i) few.push_back(100.0 + i % 5);
    for (int i = 0; i < 1000; ++i) many.push_back(100.0 + i % 5);
    EXPECT_NEAR(rate_of(few).uncertainty_percent / rate_of(many).uncertainty_percent, 10.0, 1e-9);
}

TEST(Statistics, OneRunSaysNothingOfItsSpreadAndNoRunNothingAtAll) {
    EXPECT_EQ(rate_of({5.0}).uncertainty_percent, 100.0);
    EXPECT_EQ(rate_of({}).per_second, 0.0);
    EXPECT_EQ(rate_of({}).uncertainty_percent, 100.0);
    EXPECT_EQ(rate_of({0.0, 0.0, 3.0}).uncertainty_percent, 100.0);
}

TEST(Statistics, ATimingIsThatOfTheFastRunsHoweverManyWereDisturbed) {
    std::vector<TimedRun> runs;
    for (int i = 0; i < 60; ++i) runs.push_back({8.0 + 0.1 * i, 3.0});
    for (int i = 0; i < 40; ++i) runs.push_back({5.0 + 0.001 * i, 0.0});
    const Timing timing = timing_of(runs);
    EXPECT_NEAR(timing.ms, 5.0, 0.02);
    EXPECT_LT(timing.off_ms, 0.05);
    EXPECT_EQ(timing.runs, 100u);
    EXPECT_EQ(timing.calm, 40u);
}

TEST(Statistics, ATimingTellsWhenItsFastRunsAreFew) {
    std::vector<TimedRun> runs(97, TimedRun{10.0, 5.0});
    runs.insert(runs.end(), 3, TimedRun{5.0, 0.0});
    EXPECT_GE(timing_of(runs).off_ms, 5.0);
    EXPECT_EQ(timing_of({}).ms, 0.0);
    EXPECT_EQ(timing_of({}).runs, 0u);
}

TEST(Statistics, AMarginalRateLeavesOutWhatBothTake) {
    const Rate rate = marginal_rate(1000.0, {7.0, 0.03, 20, 20}, {5.0, 0.04, 30, 30});
    EXPECT_NEAR(rate.per_second, 500'000.0, 1e-6);
    EXPECT_NEAR(rate.uncertainty_percent, 2.5, 1e-9);
    EXPECT_EQ(rate.runs, 20u);
}

TEST(Statistics, AWidenedRateIsOffByBoth) {
    EXPECT_DOUBLE_EQ(widened({7.0, 3.0, 5}, 4.0).uncertainty_percent, 5.0);
    EXPECT_EQ(widened({7.0, 100.0, 1}, 8.0).uncertainty_percent, 100.0);
    EXPECT_EQ(widened({7.0, 3.0, 5}, 4.0).per_second, 7.0);
}

TEST(Statistics, AMarginalRateOfTimesThatDoNotTellIsNone) {
    EXPECT_EQ(marginal_rate(1000.0, {5.0, 0.1, 9, 9}, {5.0, 0.1, 9, 9}).per_second, 0.0);
    EXPECT_EQ(marginal_rate(1000.0, {5.0, 0.1, 9, 9}, {7.0, 0.1, 9, 9}).uncertainty_percent, 100.0);
    EXPECT_EQ(marginal_rate(1000.0, {7.0, 0.0, 1, 1}, {5.0, 0.0, 9, 9}).uncertainty_percent, 100.0);
}

}  // namespace
}  // namespace lodestream::probe
