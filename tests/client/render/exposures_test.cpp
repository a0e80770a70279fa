// Pictures of several moments: motion blur.
#include <gtest/gtest.h>

#include "client/render/renderer.h"
#include "tests/client/render/with_renderer.h"
#include "tests/support/meshes.h"

namespace lodestream::render {
namespace {

using shading::View;

class ExposuresTest : public testing::WithRenderer {
  protected:
    void SetUp() override {
        WithRenderer::SetUp();
        ASSERT_TRUE(renderer);
        mesh::Model model;
        model.mesh = testing::sphere(16);
        model.materials.emplace_back().base_color = {0, 0, 0, 1};
        ASSERT_TRUE(renderer->upload(drawable(model, model.mesh)));
        options.phong.specular = 0.0;
    }

    // The black sphere with its centre `shift` model units left of the picture's.
    static View shifted(double shift) { return {{shift, 0, 4}, {shift, 0, 0}, 45.0, {0, 0, 1}}; }

    Image picture(const View& view, std::vector<View> earlier = {}) {
        options.earlier = std::move(earlier);
        const auto frame = renderer->draw(view, options);
        EXPECT_TRUE(frame) << frame.error().message;
        return frame ? frame->image : Image{};
    }

    DrawOptions options{.width = 96, .height = 96, .samples = 4};
};

int red(const Image& image, std::uint32_t x, std::uint32_t y) {
    return image.rgba[(std::size_t{y} * image.width + x) * 4];
}

TEST_F(ExposuresTest, OfOneAndTheSameMomentAreThatMoment) {
    const Image once = picture(shifted(0.2));
    const Image four = picture(shifted(0.2), {shifted(0.2), shifted(0.2), shifted(0.2)});
    EXPECT_EQ(once.rgba, four.rgba);
}

TEST_F(ExposuresTest, ArePicturesMean) {
    // 1.5 units apart: the sphere covers the middle in the later moment and the left side in the earlier.
    const Image both = picture(shifted(0.0), {shifted(1.5)});
    constexpr int half_light = 188;                 // of white, in sRGB
    EXPECT_NEAR(red(both, 90, 48), 255, 0);         // neither
    EXPECT_NEAR(red(both, 65, 48), half_light, 1);  // the later one alone
    EXPECT_NEAR(red(both, 12, 48), half_light, 1);  // the earlier one alone
    EXPECT_EQ(red(picture(shifted(0.0)), 12, 48), 255);
    EXPECT_EQ(red(picture(shifted(0.0)), 65, 48), 0);
}

TEST_F(ExposuresTest, WhatOneExposureHidesTheOtherStillShows) {
    const Image three = picture(shifted(0.0), {shifted(1.5), shifted(1.5), shifted(1.5)});
    const int quarter = red(three, 65, 48), three_quarters = red(three, 12, 48);
    EXPECT_NEAR(quarter, 225, 1);         // 3/4 of the light is left
    EXPECT_NEAR(three_quarters, 137, 1);  // 1/4
}

TEST_F(ExposuresTest, WhatOnlyTheEarlierMomentSawIsHalfThere) {
    const View turned_away{{0, 0, 4}, {0, 0, 8}, 45.0, {0, 0, 1}};
    EXPECT_NEAR(red(picture(turned_away, {shifted(0.0)}), 48, 48), 188, 1);  // half of white's light, in sRGB
    EXPECT_NEAR(red(picture(shifted(0.0), {turned_away}), 48, 48), 188, 1);
}

}  // namespace
}  // namespace lodestream::render
