#include "client/fly/pilot.h"

#include <gtest/gtest.h>

#include "common/control/speed_controllers.h"
#include "tests/client/fly/constructed_scenery.h"
#include "tests/client/render/with_renderer.h"

namespace lodestream::fly {
namespace {

using testing::spheres;

class PilotTest : public lodestream::testing::WithRenderer {
  protected:
    Screen screen{64, 48, 45.0};
};

TEST_F(PilotTest, FliesEveryControllerToTheEnd) {
    const motion::Trace trace = *motion::built_in({motion::Kind::reversal, 1.0, 240.0, 1});
    for (const control::Kind kind : control::kinds) {
        PilotOptions options;
        options.kind = kind;
        options.screen = screen;
        std::size_t pictures = 0;
        options.on_frame = [&](const render::Image& image, const control::FrameRequest&) -> Status {
            EXPECT_EQ(image.width, 64u);
            ++pictures;
            return Nothing{};
        };
        const auto frames = fly(*renderer, spheres(), trace, options);
        ASSERT_TRUE(frames) << frames.error().message;
        EXPECT_EQ(frames->size(), pictures);
        EXPECT_FALSE(frames->empty());
        for (const control::FlownFrame& frame : *frames) {
            EXPECT_LT(frame.level, 3u);
            EXPECT_GT(frame.frame_ms, 0.0);
        }
    }
}

// Whatever the frames take, the levels are the pseudocode's for the speeds that were met.
TEST_F(PilotTest, IsblcOnARealRendererTakesTheLevelsOfItsSpeeds) {
    const motion::Trace trace = *motion::built_in({motion::Kind::stop, 8.0, 240.0, 1});
    PilotOptions options;
    options.kind = control::Kind::isblc;
    options.control.target_fps = 4.0;
    options.screen = screen;
    const auto frames = fly(*renderer, spheres(), trace, options);
    ASSERT_TRUE(frames) << frames.error().message;
    std::uint32_t level = 0;
    for (const control::FlownFrame& frame : *frames) {
        const std::uint32_t before = level;
        level = control::isblc(level, frame.speed_deg_s, 2, options.control.speed);
        EXPECT_EQ(frame.level, level);
        EXPECT_EQ(frame.switched, level != before);
    }
}

TEST_F(PilotTest, EndsWhenThePicturesTakerFails) {
    PilotOptions options;
    options.screen = screen;
    options.on_frame = [](const render::Image&, const control::FrameRequest&) -> Status {
        return fail(ErrorCode::io, "full");
    };
    const auto frames = fly(*renderer, spheres(), {{0.0, {}}, {1.0, {}}}, options);
    ASSERT_FALSE(frames);
    EXPECT_EQ(frames.error().message, "full");
}

TEST_F(PilotTest, MeasuresCostsThatAreAboveZero) {
    const auto costs = measure_costs(*renderer, spheres(), screen);
    ASSERT_TRUE(costs) << costs.error().message;
    for (const double cost : {costs->fixed_ms, costs->per_million_triangles_ms, costs->per_million_pixels_ms,
                              costs->per_million_uploaded_ms})
        EXPECT_GT(cost, 0.0);
}

TEST_F(PilotTest, ABlurredPictureDiffersFromASharpOneAndAStillOneDoesNot) {
    const motion::Pose here{std::nullopt, 0.0, 0.0}, there{std::nullopt, 8.0, 0.0};
    const auto sharp = picture(*renderer, spheres(), 0, {here}, screen);
    const auto still = picture(*renderer, spheres(), 0, {here, here}, screen);
    const auto blurred = picture(*renderer, spheres(), 0, {there, here}, screen);
    ASSERT_TRUE(sharp && still && blurred);
    EXPECT_EQ(sharp->rgba, still->rgba);
    EXPECT_NE(sharp->rgba, blurred->rgba);
}

}  // namespace
}  // namespace lodestream::fly
