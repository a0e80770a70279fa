#include "common/image/resample.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace lodestream::image {
namespace {

using Color = std::array<std::uint8_t, 4>;

constexpr Color black{0, 0, 0, 255}, white{255, 255, 255, 255}, red{255, 0, 0, 255}, invisible_green{0, 255, 0, 0};

Pixels row_of(const std::vector<Color>& colors) {
    Pixels pixels{static_cast<std::uint32_t>(colors.size()), 1, {}};
    for (const Color& color : colors) pixels.rgba.insert(pixels.rgba.end(), color.begin(), color.end());
    return pixels;
}

Pixels column_of(const std::vector<Color>& colors) {
    Pixels pixels = row_of(colors);
    std::swap(pixels.width, pixels.height);
    return pixels;
}

Color at(const Pixels& pixels, std::size_t i) {
    return {pixels.rgba[4 * i], pixels.rgba[4 * i + 1], pixels.rgba[4 * i + 2], pixels.rgba[4 * i + 3]};
}

Pixels shrunk(const Pixels& source, Content content, std::uint32_t width, std::uint32_t height) {
    return to_pixels(shrink(source, content, width, height), content);
}

TEST(Shrink, BlackAndWhiteAverageAsLightAndDataAsNumbers) {
    const Pixels source = row_of({black, white});
    EXPECT_EQ(at(shrunk(source, Content::color, 1, 1), 0), (Color{188, 188, 188, 255}));  // half the light
    EXPECT_EQ(at(shrunk(source, Content::data, 1, 1), 0), (Color{128, 128, 128, 255}));
    EXPECT_EQ(at(shrunk(column_of({black, white}), Content::color, 1, 1), 0), (Color{188, 188, 188, 255}));
}

TEST(Shrink, InvisiblePixelsLendNoColor) {
    const Pixels source = row_of({red, invisible_green});
    EXPECT_EQ(at(shrunk(source, Content::color_under_alpha, 1, 1), 0), (Color{255, 0, 0, 128}));
    EXPECT_EQ(at(shrunk(source, Content::color, 1, 1), 0), (Color{188, 188, 0, 128}));
}

TEST(Shrink, NothingVisibleIsBlackAndInvisible) {
    const Pixels result = shrunk(row_of({invisible_green, invisible_green}), Content::color_under_alpha, 1, 1);
    EXPECT_EQ(at(result, 0), (Color{0, 0, 0, 0}));
}

TEST(Shrink, SidesThatDoNotDivideShareTheirPixels) {
    // Three pixels to two: each target takes one whole and half of the middle.
    const Pixels result = shrunk(row_of({{90, 0, 0, 255}, {60, 0, 0, 255}, {30, 0, 0, 255}}), Content::data, 2, 1);
    EXPECT_EQ(at(result, 0)[0], 80);
    EXPECT_EQ(at(result, 1)[0], 40);
}

TEST(Shrink, EveryByteSurvivesTheSameSize) {
    std::vector<Color> colors;
    for (int i = 0; i < 256; ++i)
        colors.push_back(
            {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(255 - i), static_cast<std::uint8_t>(i / 2), 255});
    const Pixels source = row_of(colors);
    for (const Content content : {Content::color, Content::color_under_alpha, Content::data})
        EXPECT_EQ(shrunk(source, content, 256, 1).rgba, source.rgba);
}

TEST(Shrink, AFilledPictureKeepsItsColorAtEverySize) {
    Pixels source{37, 23, {}};
    for (std::size_t i = 0; i < source.pixels(); ++i)
        for (const int channel : {12, 130, 251, 77}) source.rgba.push_back(static_cast<std::uint8_t>(channel));
    for (const auto& [width, height] : {std::pair{36u, 22u}, {19u, 23u}, {37u, 1u}, {2u, 3u}, {1u, 1u}}) {
        const Pixels result = shrunk(source, Content::color_under_alpha, width, height);
        ASSERT_EQ(result.pixels(), std::size_t{width} * height);
        for (std::size_t i = 0; i < result.pixels(); ++i) ASSERT_EQ(at(result, i), (Color{12, 130, 251, 77}));
    }
}

TEST(Shrink, StepByStepIsTheSameAsAtOnce) {
    Pixels source{16, 16, {}};
    for (std::size_t i = 0; i < source.pixels() * 4; ++i)
        source.rgba.push_back(static_cast<std::uint8_t>(i * 73 % 256));
    const Pixels at_once = shrunk(source, Content::color_under_alpha, 2, 2);
    const LinearPixels half = shrink(source, Content::color_under_alpha, 8, 8);
    const Pixels stepwise = to_pixels(shrink(shrink(half, 4, 4), 2, 2), Content::color_under_alpha);
    for (std::size_t i = 0; i < at_once.rgba.size(); ++i) EXPECT_NEAR(stepwise.rgba[i], at_once.rgba[i], 1);
}

}  // namespace
}  // namespace lodestream::image
