#include "common/image/codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace lodestream::image {
namespace {

Pixels gradient(std::uint32_t width, std::uint32_t height) {
    Pixels pixels{width, height, std::vector<std::uint8_t>(std::size_t{width} * height * 4)};
    for (std::size_t i = 0; i < pixels.rgba.size(); ++i) pixels.rgba[i] = static_cast<std::uint8_t>(i * 37 % 256);
    return pixels;
}

Pixels filled(std::uint32_t width, std::uint32_t height, std::array<std::uint8_t, 4> color) {
    Pixels pixels{width, height, {}};
    for (std::size_t i = 0; i < pixels.pixels(); ++i) pixels.rgba.insert(pixels.rgba.end(), color.begin(), color.end());
    return pixels;
}

std::vector<std::byte> bytes_of(std::span<const std::uint8_t> values) {
    const auto bytes = std::as_bytes(values);
    return {bytes.begin(), bytes.end()};
}

TEST(ImageCodec, PngKeepsEveryByteIncludingAlpha) {
    const Pixels image = gradient(7, 3);
    const auto png = encode_png(image);
    ASSERT_TRUE(png);
    const auto back = decode(*png);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->width, 7u);
    EXPECT_EQ(back->height, 3u);
    EXPECT_EQ(back->rgba, image.rgba);
}

TEST(ImageCodec, RefusesTruncatedPngAtEveryLengthOrDecodesItWhole) {
    const auto png = encode_png(gradient(16, 16));
    ASSERT_TRUE(png);
    for (std::size_t size = 0; size < png->size(); ++size) {
        const auto image = decode(std::span(*png).first(size));
        EXPECT_TRUE(!image || image->rgba.size() == 16u * 16u * 4u) << size;
        EXPECT_TRUE(!image || size >= png->size() / 2) << size;
    }
}

TEST(ImageCodec, SurvivesEveryFlippedByte) {
    const auto png = encode_png(gradient(8, 8));
    ASSERT_TRUE(png);
    for (std::size_t i = 0; i < png->size(); ++i)
        for (const int bit : {1, 128, 255}) {
            auto damaged = *png;
            damaged[i] ^= static_cast<std::byte>(bit);
            const auto image = decode(damaged);
            EXPECT_TRUE(!image || image->rgba.size() == image->pixels() * 4) << i;
        }
}

TEST(ImageCodec, RefusesAPngThatDeclaresMorePixelsThanTheLimit) {
    auto png = encode_png(gradient(1, 1));
    ASSERT_TRUE(png);
    for (const std::size_t offset :
         {16u, 20u}) {  // width and height in IHDR: 0x4000 = 16384 is a legal side, the area is not
        (*png)[offset + 2] = std::byte{0x40};
        (*png)[offset + 3] = std::byte{0};
    }
    const auto image = decode(*png);
    ASSERT_FALSE(image);
    EXPECT_EQ(image.error().code, ErrorCode::limit_exceeded);
}

TEST(ImageCodec, RefusesBytesThatAreNoImage) {
    EXPECT_FALSE(decode({}));
    const std::array<std::uint8_t, 12> text{'n', 'o', 't', ' ', 'a', ' ', 'p', 'n', 'g', '!', '!', '!'};
    const auto image = decode(bytes_of(text));
    ASSERT_FALSE(image);
    EXPECT_EQ(image.error().code, ErrorCode::invalid_input);
}

TEST(ImageCodec, ReadsTheHeaderOfBothFormats) {
    const Result<Header> png = read_header(*encode_png(gradient(7, 3)));
    ASSERT_TRUE(png.ok());
    EXPECT_EQ(png->format, Format::png);
    EXPECT_EQ(png->width, 7u);
    EXPECT_EQ(png->height, 3u);
    EXPECT_EQ(png->channels, 4u);
    const Result<Header> jpeg = read_header(*encode_jpeg(gradient(9, 5), 90));
    ASSERT_TRUE(jpeg.ok());
    EXPECT_EQ(jpeg->format, Format::jpeg);
    EXPECT_EQ(jpeg->width, 9u);
    EXPECT_EQ(jpeg->height, 5u);
    EXPECT_FALSE(jpeg->is_16_bit);
    EXPECT_FALSE(read_header({}).ok());
}

TEST(ImageCodec, SmallPngHoldsTheSamePictureInFewerChannels) {
    for (const auto& [color, channels] : {std::pair{std::array<std::uint8_t, 4>{9, 9, 9, 255}, 1u},
                                          {{9, 9, 9, 7}, 2u},
                                          {{9, 8, 9, 255}, 3u},
                                          {{9, 8, 9, 7}, 4u}}) {
        const Pixels pixels = filled(5, 3, color);
        const auto png = encode_small_png(pixels);
        ASSERT_TRUE(png.ok());
        EXPECT_EQ(read_header(*png)->channels, channels);
        EXPECT_EQ(decode(*png)->rgba, pixels.rgba);
    }
}

TEST(ImageCodec, JpegIsCloseToItsSourceWithoutAlpha) {
    const auto back = decode(*encode_jpeg(filled(16, 9, {200, 100, 50, 10}), 90));
    ASSERT_TRUE(back.ok());
    for (std::size_t i = 0; i < back->rgba.size(); i += 4) {
        EXPECT_NEAR(back->rgba[i], 200, 4);
        EXPECT_NEAR(back->rgba[i + 1], 100, 4);
        EXPECT_NEAR(back->rgba[i + 2], 50, 4);
        EXPECT_EQ(back->rgba[i + 3], 255);
    }
    EXPECT_TRUE(encode_jpeg(gradient(1, 1), -5).ok());
    EXPECT_TRUE(encode_jpeg(gradient(1, 1), 500).ok());
    EXPECT_FALSE(encode_jpeg({}, 90).ok());
}

TEST(ImageCodec, SurvivesEveryFlippedByteOfAJpeg) {
    const auto jpeg = *encode_jpeg(gradient(8, 8), 80);
    for (std::size_t i = 0; i < jpeg.size(); ++i)
        for (const int mask : {1, 128, 255}) {
            auto broken = jpeg;
            broken[i] ^= static_cast<std::byte>(mask);
            const auto pixels = decode(broken);
            EXPECT_TRUE(!pixels || is_consistent(*pixels)) << i;
        }
}

// A table that states more symbols than a byte can name made stb write past its own end.
TEST(ImageCodec, RefusesAJpegWithAnOverlongHuffmanTable) {
    auto jpeg = *encode_jpeg(gradient(8, 8), 80);
    const std::array<std::byte, 2> marker{std::byte{0xff}, std::byte{0xc4}};
    const auto table = std::search(jpeg.begin(), jpeg.end(), marker.begin(), marker.end());
    ASSERT_NE(table, jpeg.end());
    std::fill_n(table + 5, 16, std::byte{0xff});
    EXPECT_EQ(read_header(jpeg).error().code, ErrorCode::invalid_input);
    EXPECT_EQ(decode(jpeg).error().code, ErrorCode::invalid_input);
    jpeg.insert(jpeg.begin(), 3, std::byte{0xff});  // any marker may have fill bytes before it, the first one too
    EXPECT_EQ(read_header(jpeg).error().code, ErrorCode::invalid_input);
    EXPECT_EQ(decode(jpeg).error().code, ErrorCode::invalid_input);
}

// One IDAT of zeros that inflates a thousandfold behind a header of one pixel.
TEST(ImageCodec, APngThatSwellsBeyondItsHeaderIsRefusedWithoutTheMemory) {
    auto png = *encode_small_png(filled(4096, 4096, {0, 0, 0, 255}));
    for (const std::size_t offset : {16u, 20u})
        for (std::size_t i = 0; i < 4; ++i) png[offset + i] = i < 3 ? std::byte{0} : std::byte{1};
    const auto pixels = decode(png);
    ASSERT_FALSE(pixels.ok());
    EXPECT_EQ(pixels.error().code, ErrorCode::invalid_input);
}

TEST(ImageCodec, OnlySixteenBitGreyIsHeights) {
    EXPECT_EQ(decode_grey16_png(*encode_png(gradient(2, 2))).error().code, ErrorCode::unsupported);
    EXPECT_EQ(decode_grey16_png(*encode_jpeg(gradient(2, 2), 90)).error().code, ErrorCode::invalid_input);
    EXPECT_EQ(decode_grey16_png({}).error().code, ErrorCode::invalid_input);
}

}  // namespace
}  // namespace lodestream::image
