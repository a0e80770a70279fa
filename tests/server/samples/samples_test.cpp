#include "server/samples/samples.h"

#include <gmock/gmock.h>

namespace lodestream::samples {
namespace {

TEST(MakeSample, ReadsNameAndCount) {
    EXPECT_EQ(make_sample("teapot")->mesh.triangles.size(), teapot_triangles);
    EXPECT_EQ(make_sample("teapot:800")->mesh.triangles.size(), 800u);
    EXPECT_EQ(make_sample("terrain:1000")->mesh.positions.size(), 1'000u);
    EXPECT_EQ(make_sample("ship")->objects, ship_objects);
    EXPECT_EQ(make_sample("ship:5")->objects, 5u);
    EXPECT_EQ(make_sample("fine-ship:500")->objects, 500u);
}

TEST(MakeSample, NamesWhatIsAllowedWhereASpecIsWrong) {
    for (const char* spec : {"", ":", "teapots", "teapot:", "teapot:many", "teapot:-1", "teapot:800x", "teapot: 800",
                             "teapot:800:1", "Teapot", "ship:99999999999999999999"}) {
        const auto model = make_sample(spec);
        ASSERT_FALSE(model.ok()) << spec;
        EXPECT_EQ(model.error().code, ErrorCode::invalid_input);
        EXPECT_THAT(
            model.error().message,
            ::testing::HasSubstr("teapot[:triangles], terrain[:vertices], ship[:objects] or fine-ship[:objects]"));
    }
}

TEST(MakeSample, PassesOnTheLimitsOfTheSample) {
    EXPECT_EQ(make_sample("ship:0").error().code, ErrorCode::invalid_input);
    EXPECT_EQ(make_sample("terrain:99999999999").error().code, ErrorCode::limit_exceeded);
}

}  // namespace
}  // namespace lodestream::samples
