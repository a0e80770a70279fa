#include "common/texture/choice.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <tuple>

#include "tests/common/texture/textured.h"

namespace lodestream::texture {
namespace {

// Two images of one square, the second of half the side; the first material shows both.
struct Chosen {
    mesh::Model model = square_with(jpeg_of(noise(256, 256)));
    Textures textures;

    Chosen() {
        model.images.push_back(jpeg_of(noise(128, 128)));
        model.materials[0].emissive_texture.image = 1;
        textures = textures_of(model, *make_ladder(model));
    }
    Choice with(const Needs& needs) const { return choose(model, textures, needs); }
    std::uint64_t full_bytes() const { return model.images[0].bytes.size() + model.images[1].bytes.size(); }
};

std::uint32_t width_of(const Chosen& chosen, const Choice& choice, std::size_t image) {
    return choice.images[image].image ? choice.images[image].image->width : chosen.model.images[image].width;
}

TEST(Choose, WithoutNeedsEveryImageStaysAsItIs) {
    const Chosen chosen;
    const Choice choice = chosen.with({});
    EXPECT_EQ(choice.images[0].image, nullptr);
    EXPECT_EQ(choice.images[1].image, nullptr);
    EXPECT_EQ(choice.bytes, chosen.full_bytes());
    EXPECT_TRUE(choice.key.empty());
}

TEST(Choose, TexelsGrowToAPixelAndNoFurther) {
    const Chosen chosen;
    for (const auto& [pixels_across, first, second] :
         {std::tuple{1000.0, 256u, 128u}, {128.0, 128u, 128u}, {127.9, 128u, 128u}, {64.0, 64u, 64u}}) {
        Needs needs;
        needs.pixel_size = 1.0 / pixels_across;
        const Choice choice = chosen.with(needs);
        EXPECT_EQ(width_of(chosen, choice, 0), first) << pixels_across;
        EXPECT_EQ(width_of(chosen, choice, 1), second) << pixels_across;
    }
}

TEST(Choose, SavingsAreTheDisplaysWhereTheNetworkHasRoom) {
    const Chosen chosen;
    Needs needs;
    needs.pixel_size = 1.0 / 64;
    const Choice choice = chosen.with(needs);
    EXPECT_EQ(choice.images[0].bytes_below_a_pixel + choice.images[1].bytes_below_a_pixel,
              chosen.full_bytes() - choice.bytes);
    EXPECT_FALSE(choice.key.empty());
}

TEST(Choose, TheHeaviestGivesFirstUntilAllFit) {
    const Chosen chosen;
    Needs needs;
    needs.max_bytes = static_cast<double>(chosen.full_bytes() - 1);
    Choice choice = chosen.with(needs);
    EXPECT_EQ(width_of(chosen, choice, 0), 128u);
    EXPECT_EQ(width_of(chosen, choice, 1), 128u);
    EXPECT_EQ(choice.images[0].bytes_below_a_pixel, 0u);
    for (const double bytes : {20'000.0, 8'000.0, 3'000.0}) {
        needs.max_bytes = bytes;
        EXPECT_LE(static_cast<double>(chosen.with(needs).bytes), bytes);
    }
}

TEST(Choose, WhatCannotFitGetsTheSmallestThereIs) {
    const Chosen chosen;
    Needs needs;
    needs.max_bytes = -1.0;
    const Choice choice = chosen.with(needs);
    EXPECT_EQ(choice.images[0].image, &chosen.textures.ladder[0].back().image);
    EXPECT_EQ(choice.images[1].image, &chosen.textures.ladder[1].back().image);
}

TEST(Choose, DifferentChoicesHaveDifferentKeys) {
    const Chosen chosen;
    std::set<std::string> keys;
    for (const double pixels : {1000.0, 128.0, 64.0, 32.0}) {
        Needs needs;
        needs.pixel_size = 1.0 / pixels;
        keys.insert(chosen.with(needs).key);
    }
    EXPECT_EQ(keys.size(), 4u);
}

TEST(Choose, ImagesThatCannotShrinkStay) {
    mesh::Model model = square_with({"image/png", std::vector<std::byte>(1000), 64, 64});
    const Textures textures = textures_of(model, *make_ladder(model));
    const Choice choice = choose(model, textures, {1.0, 1.0});
    EXPECT_EQ(choice.images[0].image, nullptr);
    EXPECT_EQ(choice.bytes, 1000u);
}

TEST(Choose, AModelWithoutImagesHasNothingToChoose) {
    const mesh::Model model;
    const Choice choice = choose(model, textures_of(model, {}), {1.0, 0.0});
    EXPECT_TRUE(choice.images.empty());
    EXPECT_EQ(choice.bytes, 0u);
}

}  // namespace
}  // namespace lodestream::texture
