#include "client/render/image.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>

namespace lodestream::render {
namespace {

Image gradient(std::uint32_t width, std::uint32_t height) {
    Image image = solid(width, height, 0, 0, 0);
    for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = static_cast<std::uint8_t>(i * 37 % 256);
    return image;
}

void paint(Image& image, std::uint32_t x, std::uint32_t y, std::uint8_t value) {
    for (std::size_t c = 0; c < 3; ++c) image.rgba[(std::size_t{y} * image.width + x) * 4 + c] = value;
}

TEST(Image, WritesAndReadsAFile) {
    const auto path = std::filesystem::path(::testing::TempDir()) / "lodestream_image_test.png";
    ASSERT_TRUE(write_png(path, gradient(4, 5)));
    const auto back = read_image(path);
    std::filesystem::remove(path);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->rgba, gradient(4, 5).rgba);
}

TEST(Image, SaysWhichFileCannotBeWrittenOrRead) {
    const auto written = write_png("/nonexistent-folder/picture.png", gradient(1, 1));
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find("/nonexistent-folder/picture.png"), std::string::npos);
    const auto read = read_image("/nonexistent-folder/picture.png");
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code, ErrorCode::io);
    EXPECT_FALSE(read_image(::testing::TempDir()));
}

TEST(Image, RefusesAnEmptyOneAndOneWithMissingPixels) {
    EXPECT_FALSE(encode_png({}));
    Image short_one = gradient(4, 4);
    short_one.rgba.pop_back();
    EXPECT_FALSE(encode_png(short_one));
    EXPECT_FALSE(compare(short_one, short_one));
    EXPECT_FALSE(compare(gradient(2, 2), gradient(2, 3)));
}

TEST(Compare, EqualImagesHaveNoErrorAndTheHighestPsnr) {
    Image image = solid(4, 4, 255, 255, 255);
    paint(image, 1, 1, 9);
    const auto difference = compare(image, image);
    ASSERT_TRUE(difference);
    EXPECT_EQ(difference->rms, 0.0);
    EXPECT_EQ(difference->max, 0.0);
    EXPECT_EQ(difference->psnr_db, max_psnr_db);
    EXPECT_EQ(difference->compared_pixels, 1u);
    EXPECT_EQ(difference->silhouette_pixels, 0u);
}

TEST(Compare, CountsOnlyPixelsThatOneOfTheImagesCovers) {
    Image a = solid(10, 10, 255, 255, 255), b = a;
    paint(a, 2, 2, 100);
    paint(b, 2, 2, 110);  // covered in both, 10 steps apart
    paint(b, 5, 5, 205);  // covered in one, 50 steps apart
    const auto difference = compare(a, b);
    ASSERT_TRUE(difference);
    EXPECT_EQ(difference->compared_pixels, 2u);
    EXPECT_EQ(difference->silhouette_pixels, 1u);
    EXPECT_DOUBLE_EQ(difference->silhouette_percent, 50.0);
    EXPECT_DOUBLE_EQ(difference->max, 50.0);
    EXPECT_DOUBLE_EQ(difference->rms, std::sqrt((100.0 + 2500.0) / 2.0));
    EXPECT_NEAR(difference->psnr_db, 20.0 * std::log10(255.0 / difference->rms), 1e-12);
}

TEST(Compare, TwoEmptyPicturesAgree) {
    const auto difference = compare(solid(3, 3, 8, 9, 10), solid(3, 3, 8, 9, 10));
    ASSERT_TRUE(difference);
    EXPECT_EQ(difference->compared_pixels, 0u);
    EXPECT_EQ(difference->rms, 0.0);
}

TEST(DifferenceImage, IsWhiteWhereEqualAndDarkerByTheAmplifiedDifference) {
    Image a = solid(2, 1, 200, 200, 200), b = a;
    paint(b, 1, 0, 190);
    const auto image = difference_image(a, b, 4.0);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->rgba, (std::vector<std::uint8_t>{255, 255, 255, 255, 215, 215, 215, 255}));
}

TEST(SideBySide, KeepsEveryImageAndFillsTheRestWhite) {
    const std::array<Image, 2> images{solid(2, 1, 10, 20, 30), solid(1, 3, 40, 50, 60)};
    const Image all = side_by_side(images, 1);
    ASSERT_EQ(all.width, 4u);
    ASSERT_EQ(all.height, 3u);
    EXPECT_EQ(all.rgba[0], 10);
    EXPECT_EQ(all.rgba[2 * 4], 255);  // the gap
    EXPECT_EQ(all.rgba[3 * 4 + 1], 50);
    EXPECT_EQ(all.rgba[(2 * 4 + 0) * 4], 255);  // below the lower image
    EXPECT_EQ(all.rgba[(2 * 4 + 3) * 4 + 2], 60);
    EXPECT_EQ(side_by_side({}).pixels(), 0u);
}

}  // namespace
}  // namespace lodestream::render
