#include "common/motion/motion.h"

#include <gtest/gtest.h>

#include <limits>

namespace lodestream::motion {
namespace {

Sample at(double t_s, double yaw_deg, double pitch_deg = 0.0) {
    return {t_s, {std::nullopt, yaw_deg, pitch_deg}};
}

TEST(Motion, PosesAreLinearBetweenSamplesAndHeldOutside) {
    const Trace trace{at(1.0, 10.0, 0.0), at(2.0, 20.0, 8.0)};
    EXPECT_DOUBLE_EQ(pose_at(trace, 1.25).yaw_deg, 12.5);
    EXPECT_DOUBLE_EQ(pose_at(trace, 1.25).pitch_deg, 2.0);
    EXPECT_DOUBLE_EQ(pose_at(trace, 0.0).yaw_deg, 10.0);
    EXPECT_DOUBLE_EQ(pose_at(trace, 99.0).yaw_deg, 20.0);
    EXPECT_DOUBLE_EQ(pose_at(trace, std::numeric_limits<double>::quiet_NaN()).yaw_deg, 10.0);
}

TEST(Motion, AHeadingTurnsTheShortWayRound) {
    const Trace trace{at(0.0, 170.0), at(1.0, -170.0)};
    EXPECT_DOUBLE_EQ(pose_at(trace, 0.5).yaw_deg, 180.0);
    EXPECT_NEAR(speed_deg_s(trace, 0.5), 20.0, 1e-9);
}

TEST(Motion, HeadingZeroLooksAlongMinusZAndTurnsLeft) {
    EXPECT_NEAR(length(direction({}) - Vec3d(0, 0, -1)), 0.0, 1e-15);
    EXPECT_NEAR(length(direction({std::nullopt, 90.0, 0.0}) - Vec3d(-1, 0, 0)), 0.0, 1e-15);
    EXPECT_NEAR(length(direction({std::nullopt, 0.0, 90.0}) - Vec3d(0, 1, 0)), 0.0, 1e-15);
}

TEST(Motion, SpeedIsTheAngleBetweenDirectionsOverTime) {
    EXPECT_NEAR(speed_deg_s({at(0.0, 0.0), at(1.0, 100.0)}, 0.5), 100.0, 1e-9);
    EXPECT_NEAR(speed_deg_s({at(0.0, 0.0, -10.0), at(1.0, 0.0, 20.0)}, 0.5), 30.0, 1e-9);
    // Straight up, a heading changes nothing that is seen.
    EXPECT_NEAR(speed_deg_s({at(0.0, 0.0, 90.0), at(1.0, 100.0, 90.0)}, 0.5), 0.0, 1e-9);
    EXPECT_EQ(speed_deg_s({at(0.0, 0.0)}, 3.0), 0.0);
}

TEST(Motion, APositionIsInterpolatedWhereBothSamplesHaveOne) {
    Trace trace{at(0.0, 0.0), at(1.0, 0.0)};
    trace[0].pose.position = Vec3d(0, 0, 0);
    EXPECT_EQ(*pose_at(trace, 0.5).position, Vec3d(0, 0, 0));
    trace[1].pose.position = Vec3d(2, 4, 6);
    EXPECT_EQ(*pose_at(trace, 0.5).position, Vec3d(1, 2, 3));
}

TEST(LookingAt, IsTheInverseOfADirection) {
    const Vec3d eye{5.0, -2.0, 1e6};
    for (const Vec3d& way :
         {Vec3d{1, 0, 0}, Vec3d{-3, 4, 0.5}, Vec3d{0, -1, 0}, Vec3d{1e-3, 2, -1e-3}, Vec3d{0, 0, 9}}) {
        const Pose pose = looking_at(eye, eye + way);
        EXPECT_EQ(pose.position, eye);
        EXPECT_LT(length(direction(pose) - normalize(way)), 1e-6);
    }
}

}  // namespace
}  // namespace lodestream::motion
