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

}  // namespace
}  // namespace lodestream::probe
