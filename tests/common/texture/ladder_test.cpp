#include "common/texture/ladder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/texture/textured.h"

namespace lodestream::texture {
namespace {

const ImageUse opaque_color{true, image::Content::color, false};
const ImageUse color_under_alpha{true, image::Content::color_under_alpha, true};
const ImageUse numbers{true, image::Content::data, false};

// Every size is what it says, in fewer bytes than the one before.
void expect_sound(const mesh::Image& source, const Sizes& sizes) {
    std::size_t bytes = source.bytes.size();
    int halvings = 0;
    for (const SmallerImage& size : sizes) {
        EXPECT_LT(size.image.bytes.size(), bytes);
        EXPECT_GT(size.halvings, halvings);
        bytes = size.image.bytes.size();
        halvings = size.halvings;
        const Result<image::Header> header = image::read_header(size.image.bytes);
        ASSERT_TRUE(header.ok());
        EXPECT_EQ(header->width, size.image.width);
        EXPECT_EQ(header->height, size.image.height);
        EXPECT_EQ(image::media_type(header->format), size.image.media_type);
    }
}

TEST(SmallerSizes, HalveDownToFourTexels) {
    const mesh::Image source = jpeg_of(noise(256, 128));
    const Sizes sizes = *smaller_sizes(source, opaque_color);
    expect_sound(source, sizes);
    ASSERT_GE(sizes.size(), 5u);
    EXPECT_EQ(sizes[0].image.width, 128u);
    EXPECT_EQ(sizes[0].image.height, 64u);
    for (const SmallerImage& size : sizes) {
        EXPECT_EQ(size.image.media_type, "image/jpeg");
        EXPECT_GE(size.image.width, min_side);
        EXPECT_GE(size.image.height, min_side);
    }
}

TEST(SmallerSizes, OddSidesRoundUp) {
    const mesh::Image source = png_of(noise(101, 7, 100));
    const Sizes sizes = *smaller_sizes(source, color_under_alpha);
    expect_sound(source, sizes);
    ASSERT_GE(sizes.size(), 2u);
    EXPECT_EQ(sizes[0].image.width, 51u);
    EXPECT_EQ(sizes[0].image.height, 4u);
    EXPECT_EQ(sizes[1].image.width, 26u);
    EXPECT_EQ(sizes[1].image.height, 4u);
}

TEST(SmallerSizes, OneTexelAndShortSidesStay) {
    EXPECT_TRUE(smaller_sizes(png_of(noise(1, 1)), opaque_color)->empty());
    EXPECT_TRUE(smaller_sizes(png_of(noise(4, 3)), opaque_color)->empty());
    const Sizes of_a_line = *smaller_sizes(png_of(noise(512, 1)), opaque_color);
    EXPECT_FALSE(of_a_line.empty());
    for (const SmallerImage& size : of_a_line) EXPECT_EQ(size.image.height, 1u);
}

TEST(SmallerSizes, AlphaThatIsReadStaysPng) {
    const mesh::Image source = png_of(noise(64, 64, 100));
    const Sizes sizes = *smaller_sizes(source, color_under_alpha);
    ASSERT_FALSE(sizes.empty());
    EXPECT_EQ(sizes[0].image.media_type, "image/png");
    EXPECT_EQ(image::decode(sizes[0].image.bytes)->rgba[3], 100);
}

TEST(SmallerSizes, OpaqueColorPngBecomesAJpegWhereThatIsFarSmaller) {
    const mesh::Image source = png_of(noise(256, 256, 100));  // no material reads this alpha
    const Sizes sizes = *smaller_sizes(source, opaque_color);
    expect_sound(source, sizes);
    ASSERT_FALSE(sizes.empty());
    EXPECT_EQ(sizes[0].image.media_type, "image/jpeg");
    const Sizes of_data = *smaller_sizes(source, numbers);
    EXPECT_FALSE(of_data.empty());
    for (const SmallerImage& size : of_data) EXPECT_EQ(size.image.media_type, "image/png");
}

TEST(SmallerSizes, OneThatIsNotSmallerIsSkipped) {
    // Stripes of black and white compress to next to nothing; their averages along a slope do not.
    image::Pixels pixels{128, 128, {}};
    for (std::size_t i = 0; i < pixels.pixels(); ++i) {
        const std::uint8_t value = (i % 128) % 2 == 0 ? 255 : 0;
        pixels.rgba.insert(pixels.rgba.end(), {value, value, value, 255});
    }
    const mesh::Image source{"image/png", *image::encode_small_png(pixels), 128, 128};
    expect_sound(source, *smaller_sizes(source, opaque_color));
}

TEST(SmallerSizes, DamagedBytesAreAnErrorAtEveryLength) {
    const mesh::Image whole = png_of(noise(16, 16));
    for (std::size_t size = 0; size < whole.bytes.size() - 16; ++size) {
        mesh::Image cut = whole;
        cut.bytes.resize(size);
        EXPECT_FALSE(smaller_sizes(cut, opaque_color).ok()) << size;
    }
    EXPECT_FALSE(smaller_sizes({}, opaque_color).ok());
}

TEST(SmallerSizes, SidesOf16kAreReadAndAnAreaBeyondTheLimitIsRefused) {
    const mesh::Image wide = png_of(noise(image::max_side, 1));
    const Sizes sizes = *smaller_sizes(wide, opaque_color);
    expect_sound(wide, sizes);
    ASSERT_FALSE(sizes.empty());
    EXPECT_EQ(sizes[0].image.width, image::max_side / 2);

    mesh::Image huge = png_of(noise(1, 1));
    for (const std::size_t offset : {16u, 20u}) {  // width and height in IHDR: 0x4000 = 16384
        huge.bytes[offset + 2] = std::byte{0x40};
        huge.bytes[offset + 3] = std::byte{0};
    }
    EXPECT_EQ(smaller_sizes(huge, opaque_color).error().code, ErrorCode::limit_exceeded);
}

TEST(MakeLadder, KeepsADamagedImageAndSaysSo) {
    mesh::Model model = square_with(png_of(noise(64, 64)));
    model.images.push_back(model.images[0]);
    model.images[1].bytes.resize(100);
    model.materials[0].emissive_texture.image = 1;
    const Result<Ladder> ladder = make_ladder(model);
    ASSERT_TRUE(ladder.ok());
    ASSERT_EQ(ladder->size(), 2u);
    EXPECT_FALSE((*ladder)[0].empty());
    EXPECT_TRUE((*ladder)[1].empty());
    ASSERT_EQ(ladder.warnings.size(), 1u);
    EXPECT_THAT(ladder.warnings[0], ::testing::HasSubstr("image 1 is sent as it is"));
}

TEST(MakeLadder, HoldsItsLimitOfTexelsTogether) {
    mesh::Model model = square_with(png_of(noise(64, 64)));
    model.images.push_back(model.images[0]);
    model.materials[0].emissive_texture.image = 1;
    const Result<Ladder> ladder = make_ladder(model, image_uses(model), 2 * 64 * 64 - 1);
    ASSERT_TRUE(ladder.ok());
    EXPECT_FALSE((*ladder)[0].empty());
    EXPECT_TRUE((*ladder)[1].empty());
    ASSERT_EQ(ladder.warnings.size(), 1u);
    EXPECT_TRUE(make_ladder(model, image_uses(model), 2 * 64 * 64).warnings.empty());
}

TEST(MakeLadder, DoesNotLookAtUnusedImages) {
    mesh::Model model = square_with(png_of(noise(64, 64)));
    model.images.push_back({"image/png", {}, 8, 8});
    const Result<Ladder> ladder = make_ladder(model);
    ASSERT_TRUE(ladder.ok());
    EXPECT_TRUE(ladder.warnings.empty());
    EXPECT_TRUE(make_ladder(mesh::Model{})->empty());
}

}  // namespace
}  // namespace lodestream::texture
