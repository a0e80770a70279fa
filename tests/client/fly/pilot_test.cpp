#include "client/fly/pilot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>

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

TEST_F(PilotTest, AFlightTakesTheTimeThatItShows) {
    PilotOptions options;
    options.screen = screen;
    const auto begin = std::chrono::steady_clock::now();
    const auto frames = fly(*renderer, spheres(), {{0.0, {}}, {0.5, {}}}, options);
    ASSERT_TRUE(frames) << frames.error().message;
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
    EXPECT_GE(passed.count(), static_cast<double>(frames->size() - 1) / 60.0);
}

TEST_F(PilotTest, MeasuresCostsThatAreAboveZero) {
    const auto costs = measure_costs(*renderer, spheres(), screen);
    ASSERT_TRUE(costs) << costs.error().message;
    const auto sharp = measure_costs(*renderer, spheres(), screen, false);
    ASSERT_TRUE(sharp) << sharp.error().message;
    for (const control::FrameCosts& some : {*costs, *sharp})
        for (const double cost : {some.fixed_ms, some.per_million_triangles_ms, some.per_million_pixels_ms,
                                  some.per_million_shaded_ms, some.per_million_uploaded_ms})
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

// The viewer at a distance of the spheres' radius, looking at them.
motion::Sample at_distance(double t_s, double distance) {
    return {t_s, {Vec3d{0, 0, distance}, 0.0, 0.0}};
}

class SplitFlightTest : public PilotTest {
  protected:
    void SetUp() override {
        PilotTest::SetUp();
        options.kind = control::Kind::none;
        options.control.target_fps = 20.0;
        options.screen = screen;
        options.on_split = [this](const SplitFrame& split) { splits.push_back(split); };
        scenery = spheres();
        ASSERT_TRUE(make_movable(scenery));
    }

    std::vector<control::FlownFrame> flown(const motion::Trace& trace) {
        splits.clear();
        auto frames = fly(*renderer, scenery, trace, options);
        EXPECT_TRUE(frames) << frames.error().message;
        if (!frames) return {};
        EXPECT_EQ(frames->size(), splits.size());
        return *std::move(frames);
    }

    PilotOptions options;
    Scenery scenery;
    std::vector<SplitFrame> splits;
};

TEST_F(SplitFlightTest, FewerTrianglesAreGouraudFarAwayAndNoFrameChangesMoreThanItsBound) {
    const std::uint64_t triangles = scenery.levels[0].movable->triangles();
    const auto frames = flown({at_distance(0.0, 1.2), at_distance(5.0, 40.0), at_distance(10.0, 1.2)});
    ASSERT_GT(frames.size(), 20u);
    EXPECT_EQ(splits.front().change_steps, 0.0);
    std::uint64_t fewest = triangles;
    double largest_change = 0.0;
    for (const SplitFrame& split : splits) {
        EXPECT_LE(split.change_steps, split.bound_steps + 1e-9);
        EXPECT_LE(split.bound_steps, 4.0 + 1e-9);  // no triangle of this sphere takes more alone
        fewest = std::min(fewest, split.gouraud_triangles);
        largest_change = std::max(largest_change, split.change_steps);
    }
    EXPECT_GT(splits.front().gouraud_triangles, triangles / 2);
    EXPECT_LT(fewest, splits.front().gouraud_triangles / 2);
    EXPECT_GT(largest_change, 0.0);
}

// To and fro over the edge of a distance step: without hysteresis the border would go after it.
TEST_F(SplitFlightTest, AViewerWhoSwaysDoesNotSwayTheBorder) {
    const auto settled = [&](double away) {
        const shading::View view = view_of(default_view(scenery, screen.fov_y_deg), at_distance(0.0, away).pose);
        const double distance = shading::continuous_distance(view, scenery.bounds, display_of(screen));
        return shading::settled_split(distance, shading::max_distance_steps, 1000).gouraud;
    };
    constexpr double sway = 0.02;
    double edge = 3.0;
    while (settled(edge - sway) == settled(edge + sway)) edge += sway;
    motion::Trace trace;
    for (int i = 0; i <= 100; ++i) trace.push_back(at_distance(0.05 * i, edge + (i % 2 ? sway : -sway)));
    flown(trace);
    for (const SplitFrame& split : splits) EXPECT_EQ(split.gouraud_triangles, splits[0].gouraud_triangles);
}

TEST_F(SplitFlightTest, TheBorderFollowsTheDevicesStepsWithinTheSameBound) {
    int frame = 0;
    options.distance_steps = [&] { return frame++ < 20 ? 16u : 2u; };
    flown({at_distance(0.0, 3.0), at_distance(10.0, 3.0)});
    ASSERT_GT(splits.size(), 40u);
    EXPECT_EQ(splits[19].gouraud_triangles, splits[0].gouraud_triangles);
    EXPECT_LT(splits.back().gouraud_triangles, splits[0].gouraud_triangles);
    EXPECT_EQ(splits.back().gouraud_triangles, scenery.levels[0].movable->triangles() / 2);
    for (const SplitFrame& split : splits) EXPECT_LE(split.change_steps, split.bound_steps + 1e-9);
}

TEST_F(SplitFlightTest, AnotherLevelKeepsTheShareThatTheBorderHad) {
    options.kind = control::Kind::sblc;
    motion::Trace trace;  // still, then turning, from a distance where about half is Gouraud
    for (int i = 0; i <= 60; ++i)
        trace.push_back({0.05 * i, {Vec3d{0, 0, 6}, i < 30 ? 0.0 : 0.2 * std::pow(i - 30.0, 2.0), 0.0}});
    const auto frames = flown(trace);
    bool has_switched = false;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const double triangles = static_cast<double>(scenery.levels[frames[i].level].movable->triangles());
        EXPECT_NEAR(static_cast<double>(splits[i].gouraud_triangles) / triangles,
                    static_cast<double>(splits[0].gouraud_triangles) /
                        static_cast<double>(scenery.levels[frames[0].level].movable->triangles()),
                    0.02);
        has_switched = has_switched || frames[i].switched;
    }
    EXPECT_TRUE(has_switched);
}

TEST_F(SplitFlightTest, CostsAreThoseOfMovableLevels) {
    EXPECT_TRUE(measure_costs(*renderer, scenery, screen));
    EXPECT_TRUE(scenery.levels[0].content.primitives.empty());
}

}  // namespace
}  // namespace lodestream::fly
