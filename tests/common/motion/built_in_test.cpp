#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "common/motion/motion.h"

namespace lodestream::motion {
namespace {

double fastest(const Trace& trace) {
    double speed = 0.0;
    for (const Sample& sample : trace) speed = std::max(speed, speed_deg_s(trace, sample.t_s));
    return speed;
}

TEST(BuiltInMotion, EveryOneKeepsToItsLengthAndSpeed) {
    for (const Kind kind : kinds) {
        const auto trace = built_in({kind, 8.0, 240.0, 3});
        ASSERT_TRUE(trace);
        EXPECT_NEAR(duration_s(*trace), 8.0, 0.01) << kind_name(kind);
        EXPECT_LE(fastest(*trace), 240.0 * 1.001) << kind_name(kind);
        EXPECT_GE(fastest(*trace), kind == Kind::still ? 0.0 : 120.0) << kind_name(kind);
        for (std::size_t i = 1; i < trace->size(); ++i) ASSERT_GT((*trace)[i].t_s, (*trace)[i - 1].t_s);
    }
}

TEST(BuiltInMotion, NamesGoBothWays) {
    for (const Kind kind : kinds) EXPECT_EQ(*parse_kind(kind_name(kind)), kind);
    EXPECT_THAT(parse_kind("dance").error().message, ::testing::HasSubstr("there are still, start"));
}

TEST(BuiltInMotion, AStartIsStillThenFastAndAStopTheOtherWay) {
    const Trace start = *built_in({Kind::start, 8.0, 200.0, 1}), stop = *built_in({Kind::stop, 8.0, 200.0, 1});
    EXPECT_NEAR(speed_deg_s(start, 1.0), 0.0, 1e-6);
    EXPECT_NEAR(speed_deg_s(start, 7.0), 200.0, 0.01);
    EXPECT_NEAR(speed_deg_s(stop, 1.0), 200.0, 0.01);
    EXPECT_NEAR(speed_deg_s(stop, 7.0), 0.0, 1e-6);
}

TEST(BuiltInMotion, AReversalComesBack) {
    const Trace trace = *built_in({Kind::reversal, 10.0, 200.0, 1});
    EXPECT_GT(pose_at(trace, 3.0).yaw_deg, pose_at(trace, 2.0).yaw_deg);
    EXPECT_LT(pose_at(trace, 7.0).yaw_deg, pose_at(trace, 6.0).yaw_deg);
    EXPECT_NEAR(speed_deg_s(trace, 9.9), 0.0, 1e-6);
}

TEST(BuiltInMotion, AMixIsItsSeeds) {
    const Trace a = *built_in({Kind::mix, 5.0, 240.0, 1}), b = *built_in({Kind::mix, 5.0, 240.0, 1}),
                c = *built_in({Kind::mix, 5.0, 240.0, 2});
    EXPECT_EQ(a.back().pose.yaw_deg, b.back().pose.yaw_deg);
    EXPECT_NE(a.back().pose.yaw_deg, c.back().pose.yaw_deg);
    EXPECT_TRUE(std::any_of(a.begin(), a.end(), [&](const Sample& s) { return speed_deg_s(a, s.t_s) < 1.0; }));
}

TEST(BuiltInMotion, RefusesLengthsAndSpeedsOutOfRange) {
    EXPECT_FALSE(built_in({Kind::mix, 0.5, 240.0, 1}));
    EXPECT_FALSE(built_in({Kind::mix, 601.0, 240.0, 1}));
    EXPECT_FALSE(built_in({Kind::mix, 8.0, 0.0, 1}));
    EXPECT_FALSE(built_in({Kind::mix, 8.0, 1e5, 1}));
}

}  // namespace
}  // namespace lodestream::motion
