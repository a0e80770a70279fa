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

void paint(render::Image& image, std::uint32_t x, std::uint32_t y) {
    image.rgba[4 * (std::size_t{y} * image.width + x)] = 7;
}

TEST(Pictures, TheShownPartHoldsWhatEitherPictureShowsAndItsMarginStaysInside) {
    std::array<render::Image, 2> images = {render::solid(10, 8, 255, 255, 255), render::solid(10, 8, 255, 255, 255)};
    paint(images[0], 3, 4);
    paint(images[1], 9, 5);
    const Rectangle part = shown_part(images, 2);
    EXPECT_EQ(part.left, 1u);
    EXPECT_EQ(part.top, 2u);
    EXPECT_EQ(part.right, 10u);
    EXPECT_EQ(part.bottom, 8u);
    const render::Image crop = cropped(images[0], part);
    EXPECT_EQ(crop.width, 9u);
    EXPECT_EQ(crop.height, 6u);
    EXPECT_EQ(crop.rgba[4 * (2 * 9 + 2)], 7);
}

TEST(Pictures, OfAnEmptyViewTheWholePictureIsShown) {
    const std::array<render::Image, 1> images = {render::solid(10, 8, 255, 255, 255)};
    const Rectangle part = shown_part(images, 2);
    EXPECT_EQ(part.right - part.left, 10u);
    EXPECT_EQ(part.bottom - part.top, 8u);
}

}  // namespace
}  // namespace lodestream::report
