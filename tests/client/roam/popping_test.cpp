#include "client/roam/popping.h"

#include <gtest/gtest.h>

namespace lodestream::roam {
namespace {

TEST(Popping, SamePicturesHaveNone) {
    const render::Image grey = render::solid(20, 10, 90, 90, 90);
    const auto none = popping_between(grey, grey);
    ASSERT_TRUE(none);
    EXPECT_EQ(none->largest, 0.0);
    EXPECT_EQ(none->p999, 0.0);
    EXPECT_EQ(none->rms, 0.0);
}

TEST(Popping, CountsTheChannelThatChangesMostInBothDirections) {
    const render::Image before = render::solid(100, 100, 90, 90, 90);
    render::Image after = before;
    after.rgba[4 * 7] = 100;
    after.rgba[4 * 7 + 1] = 60;
    const auto popping = popping_between(before, after);
    ASSERT_TRUE(popping);
    EXPECT_EQ(popping->largest, 30.0);
    EXPECT_EQ(popping->p999, 0.0) << "one pixel of ten thousand";
    EXPECT_DOUBLE_EQ(popping->rms, 30.0 / 100.0);
}

TEST(Popping, OneOfAThousandPixelsAndOneMoreIsTheQuantile) {
    const render::Image before = render::solid(100, 100, 0, 0, 0);
    render::Image after = before;
    for (std::size_t i = 0; i < 10; ++i) after.rgba[4 * i] = 200;
    EXPECT_EQ(popping_between(before, after)->p999, 0.0);
    after.rgba[4 * 10] = 50;
    EXPECT_EQ(popping_between(before, after)->p999, 50.0);
    after.rgba[4 * 11] = 70;
    EXPECT_EQ(popping_between(before, after)->p999, 70.0);
}

TEST(Popping, OtherSizesAndNothingAreRefused) {
    EXPECT_FALSE(popping_between(render::solid(4, 4, 0, 0, 0), render::solid(4, 5, 0, 0, 0)));
    EXPECT_FALSE(popping_between({}, {}));
}

}  // namespace
}  // namespace lodestream::roam
