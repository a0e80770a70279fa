#include "client/report/pictures.h"

#include <gtest/gtest.h>

#include <array>

namespace lodestream::report {
namespace {

TEST(Pictures, AScaledPictureKeepsItsShapeAndEachPixelIsAMean) {
    render::Image image = render::solid(4, 2, 0, 0, 0);
    for (std::size_t i = 0; i < 4; ++i) image.rgba[i] = 200;  // one bright pixel of the four that become the first
    const render::Image half = scaled_down(image, 2);
    EXPECT_EQ(half.width, 2u);
    EXPECT_EQ(half.height, 1u);
    EXPECT_EQ(half.rgba[0], 50);
    EXPECT_EQ(half.rgba[4], 0);
}

TEST(Pictures, NeverScalesUpAndNeverToNothing) {
    EXPECT_EQ(scaled_down(render::solid(3, 2, 1, 2, 3), 10).width, 3u);
    EXPECT_EQ(scaled_down(render::solid(1000, 1, 1, 2, 3), 10).height, 1u);
    EXPECT_EQ(scaled_down(render::Image{}, 10).width, 0u);
}

TEST(Pictures, StackedPicturesKeepTheirPixels) {
    const std::array<render::Image, 2> images = {render::solid(2, 1, 10, 20, 30), render::solid(1, 2, 40, 50, 60)};
    const render::Image out = stacked(images, 3);
    EXPECT_EQ(out.width, 2u);
    EXPECT_EQ(out.height, 6u);
    const auto red = [&](std::size_t x, std::size_t y) { return int{out.rgba[4 * (y * 2 + x)]}; };
    EXPECT_EQ(red(1, 0), 10);
    EXPECT_EQ(red(0, 2), 255);
    EXPECT_EQ(red(0, 4), 40);
    EXPECT_EQ(red(0, 5), 40);
    EXPECT_EQ(red(1, 5), 255);
}

}  // namespace
}  // namespace lodestream::report
