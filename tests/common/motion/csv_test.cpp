#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/motion/motion.h"

namespace lodestream::motion {
namespace {

using ::testing::HasSubstr;

std::string error_of(std::string_view text) {
    const auto trace = parse_csv(text);
    return trace ? "" : trace.error().message;
}

TEST(MotionCsv, ReadsRowsWithAndWithoutAPosition) {
    const auto trace = parse_csv("t_s,x,y,z,yaw_deg,pitch_deg\n0,,,,10,-5\r\n\n0.5, 1, 2.5 ,-3,20,5");
    ASSERT_TRUE(trace) << trace.error().message;
    ASSERT_EQ(trace->size(), 2u);
    EXPECT_FALSE((*trace)[0].pose.position);
    EXPECT_EQ((*trace)[0].pose.yaw_deg, 10.0);
    EXPECT_EQ((*trace)[0].pose.pitch_deg, -5.0);
    EXPECT_EQ((*trace)[1].t_s, 0.5);
    EXPECT_EQ(*(*trace)[1].pose.position, Vec3d(1.0, 2.5, -3.0));
}

TEST(MotionCsv, NeedsNoHeading) {
    const auto trace = parse_csv("1e-1,,,,0,0");
    ASSERT_TRUE(trace);
    EXPECT_EQ(trace->front().t_s, 0.1);
}

TEST(MotionCsv, NamesTheLineThatIsWrong) {
    EXPECT_THAT(error_of("0,,,,0,0\n1,,,,0"), HasSubstr("line 2: a row is t_s,x,y,z,yaw_deg,pitch_deg"));
    EXPECT_THAT(error_of("0,,,,0,0\n1,,,,0,0,0"), HasSubstr("line 2: a row is"));
    EXPECT_THAT(error_of("0,1,,2,0,0"), HasSubstr("line 1: x, y and z are three finite numbers or all empty"));
    EXPECT_THAT(error_of("0,,,,nan,0"), HasSubstr("must be finite"));
    EXPECT_THAT(error_of("0,,,,inf,0"), HasSubstr("must be finite"));
    EXPECT_THAT(error_of(",,,,0,0"), HasSubstr("must be finite"));
    EXPECT_THAT(error_of("0,,,,1x,0"), HasSubstr("must be finite"));
    EXPECT_THAT(error_of("0,,,,0,90.5"), HasSubstr("pitch_deg must lie between -90 and 90"));
}

TEST(MotionCsv, RefusesTimesThatDoNotRise) {
    EXPECT_THAT(error_of("0,,,,0,0\n0,,,,1,0"), HasSubstr("line 2: t_s must be larger"));
    EXPECT_THAT(error_of("5,,,,0,0\n4,,,,1,0"), HasSubstr("line 2: t_s must be larger"));
}

TEST(MotionCsv, RefusesWhatHoldsNoRow) {
    EXPECT_THAT(error_of(""), HasSubstr("no row"));
    EXPECT_THAT(error_of("t_s,x,y,z,yaw_deg,pitch_deg\n"), HasSubstr("no row"));
    EXPECT_THAT(error_of("\n \n"), HasSubstr("no row"));
}

}  // namespace
}  // namespace lodestream::motion
