// The sweep's smaller version; tests/common/simulate/sweep_devices.cpp is the whole.
#include "common/simulate/sweep.h"

#include <gtest/gtest.h>

#include <set>

namespace lodestream::simulate {
namespace {

constexpr std::size_t predictive = std::size(control::kinds) - 1;

TEST(Sweep, HasTwentyDifferentMotions) {
    std::set<std::string> names;
    for (const NamedTrace& trace : sweep_traces(4.0)) {
        names.insert(trace.name);
        EXPECT_NEAR(motion::duration_s(trace.trace), 4.0, 0.011) << trace.name;
    }
    EXPECT_EQ(names.size(), trace_count);
}

TEST(Sweep, PredictiveKeepsTheDeadlineAtLeastAsOftenAsEveryOtherOnEveryMotion) {
    const auto traces = sweep_traces(8.0);
    const auto flown = sweep({}, traces, 5000, 30);
    ASSERT_TRUE(flown);
    ASSERT_EQ(flown->size(), 30u);
    for (std::size_t t = 0; t < trace_count; ++t) {
        std::array<double, predictive + 1> kept{};
        for (const auto& device : *flown)
            for (std::size_t kind = 0; kind < kept.size(); ++kind) kept[kind] += device[t][kind].within_deadline / 30.0;
        for (std::size_t kind = 0; kind < predictive; ++kind)
            EXPECT_GE(kept[predictive], kept[kind])
                << traces[t].name << ", " << control::kind_name(control::kinds[kind]);
        EXPECT_GE(kept[predictive], 0.99) << traces[t].name;
    }
}

TEST(Sweep, RangesOfDevicesJoin) {
    const auto traces = sweep_traces(1.0);
    const auto all = sweep({}, traces, 0, 2), second = sweep({}, traces, 1, 1);
    ASSERT_TRUE(all && second);
    for (std::size_t kind = 0; kind <= predictive; ++kind)
        EXPECT_EQ((*all)[1][3][kind].average_fps, (*second)[0][3][kind].average_fps);
}

TEST(Sweep, SaysWhatCannotBeFlown) {
    SweepOptions options;
    options.ladder.clear();
    EXPECT_FALSE(sweep(options, sweep_traces(1.0), 0, 1));
}

}  // namespace
}  // namespace lodestream::simulate
