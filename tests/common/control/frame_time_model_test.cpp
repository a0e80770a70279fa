#include "common/control/frame_time_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/base/random.h"

namespace lodestream::control {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double true_ms(const Work& work, double slower = 1.0) {
    return slower * (1.0 + work.pixels * 2e-6 + work.exposures * (work.triangles * 60e-6 + work.shaded_px * 6e-6) +
                     work.uploaded_triangles * 25e-6 + work.background_load * 3.0);
}

Work some_work(Random& random) {
    const auto level = static_cast<std::uint32_t>(random.uniform() * 4.0);
    const double triangles = 200'000.0 / std::pow(2.0, level), pixels = random.uniform(1e5, 1e6);
    return {level,
            triangles,
            std::floor(random.uniform(1.0, 4.999)),
            pixels,
            random.uniform() < 0.1 ? triangles : 0.0,
            random.uniform() < 0.2 ? 1.0 : 0.0,
            pixels};
}

FrameTimeModel trained(int frames, double noise) {
    Random random(7);
    FrameTimeModel model = make_model({});
    for (int i = 0; i < frames; ++i) {
        const Work work = some_work(random);
        model = learn(model, work, true_ms(work) * std::exp(noise * random.normal()));
    }
    return model;
}

TEST(FrameTimeModel, LearnsALinearDeviceThroughNoise) {
    const FrameTimeModel model = trained(400, 0.03);
    Random random(99);
    for (int i = 0; i < 50; ++i) {
        const Work work = some_work(random);
        EXPECT_NEAR(predict_ms(model, work) / true_ms(work), 1.0, 0.1);
    }
}

// As when a renderer's threads share a core every other frame: level 1 takes 5 or 8.5 ms for minutes. Its costs and its
// own correction describe the same frames, so that one could grow while the other falls.
TEST(FrameTimeModel, FramesThatScatterForLongDoNotRaiseWhatAnotherLevelIsSaidToTake) {
    const Work often{1, 50'000, 1.0, 5e5, 0.0, 0.0, 5e5}, other{0, 200'000, 1.0, 5e5, 0.0, 0.0, 5e5};
    Random random(3);
    FrameTimeModel model = make_model({});
    double at_first = 0.0;
    for (int i = 0; i < 6000; ++i) {
        model = learn(model, often, random.uniform() < 0.3 ? 5.0 : 8.5);
        if (i == 300) at_first = predict_ms(model, other);
    }
    EXPECT_NEAR(predict_ms(model, other) / at_first, 1.0, 0.25);
    EXPECT_NEAR(predict_ms(model, often), 7.5, 1.5);
}

TEST(FrameTimeModel, NoticesADeviceThatBecameTwiceAsSlowWithinTwentyFrames) {
    FrameTimeModel model = trained(400, 0.03);
    const Work now{2, 50'000, 1.0, 5e5, 0.0, 0.0, 5e5};
    for (int i = 0; i < 20; ++i) model = learn(model, now, true_ms(now, 2.0));
    EXPECT_NEAR(predict_ms(model, now) / true_ms(now, 2.0), 1.0, 0.05);
    // Also for what was not drawn since.
    const Work other{0, 200'000, 2.0, 5e5, 0.0, 0.0, 5e5};
    EXPECT_NEAR(predict_ms(model, other) / true_ms(other, 2.0), 1.0, 0.2);
}

TEST(FrameTimeModel, AnOutlierMovesThePredictionByAFewPercent) {
    const FrameTimeModel before = trained(400, 0.03);
    const Work work{1, 100'000, 1.0, 5e5, 0.0, 0.0, 5e5};
    const FrameTimeModel after = learn(before, work, 100.0 * true_ms(work));
    EXPECT_NEAR(predict_ms(after, work) / predict_ms(before, work), 1.0, 0.15);
}

TEST(FrameTimeModel, WhatWasNotMeasuredChangesNothing) {
    const FrameTimeModel before = trained(10, 0.03);
    const Work work{1, 100'000, 1.0, 5e5, 0.0, 0.0, 5e5};
    for (const double ms : {nan, 0.0, -5.0, std::numeric_limits<double>::infinity()})
        EXPECT_EQ(predict_ms(learn(before, work, ms), work), predict_ms(before, work));
}

TEST(FrameTimeModel, StaysFiniteForAnyTimes) {
    Random random(3);
    FrameTimeModel model = make_model({});
    for (int i = 0; i < 3000; ++i) {
        const Work work = some_work(random);
        model = learn(model, work, random.log_uniform(1e-300, 1e300));
        ASSERT_TRUE(std::isfinite(predict_ms(model, work)));
        ASSERT_GT(predict_ms(model, work), 0.0);
        ASSERT_GE(safety_factor(model), 1.0);
        ASSERT_LE(safety_factor(model), 2.0);
    }
}

TEST(FrameTimeModel, SafetyGrowsWithTheSpreadOfTheFrames) {
    EXPECT_LT(safety_factor(trained(400, 0.005)), 1.06);
    EXPECT_GT(safety_factor(trained(400, 0.10)), 1.15);
}

TEST(FrameTimeModel, PredictsByWhatAProbeToldApartAndLearnsInItsProportions) {
    FrameCosts costs{1.0, 80.0, 0.5, 50.0, 5.0};
    costs.per_million_vertices_ms = 20.0;
    costs.per_million_shaded_ms = 6.0;
    costs.per_million_textured_ms = 2.0;
    costs.per_million_extent_ms = 30.0;
    Work work{0, 50'000, 2.0, 4e5, 0.0, 0.0};
    work.vertices = 25'000;
    work.shaded_px = 3e5;
    work.textured_px = 1e5;
    work.extent_px = 1e5;
    const double triangles_ms = 0.05 * 80.0 + 0.025 * 20.0 + 0.1 * 30.0, shaded_ms = 0.3 * 6.0 + 0.1 * 2.0;
    EXPECT_NEAR(frame_ms(costs, work), 1.0 + 0.4 * 0.5 + 2.0 * (triangles_ms + shaded_ms), 1e-12);
    EXPECT_NEAR(predict_ms(make_model(costs), work), frame_ms(costs, work), 1e-12);

    FrameTimeModel model = make_model(costs);
    for (int i = 0; i < 100; ++i) model = learn(model, work, 1.5 * frame_ms(costs, work));
    EXPECT_NEAR(predict_ms(model, work), 1.5 * frame_ms(costs, work), 0.2);
}

TEST(FrameTimeModel, ExposuresRepeatWhatIsDrawnAndNotThePicture) {
    const FrameCosts costs{1.0, 100.0, 2.0, 50.0, 5.0, 3.0};
    EXPECT_NEAR(frame_ms(costs, {0, 1e4, 1.0, 1e6, 0.0, 0.0, 1e6}), 1.0 + 2.0 + 1.0 + 3.0, 1e-12);
    EXPECT_NEAR(frame_ms(costs, {0, 1e4, 4.0, 1e6, 0.0, 0.0, 1e6}), 1.0 + 2.0 + 4.0 * (1.0 + 3.0), 1e-12);
}

TEST(FrameTimeModel, ReplacesAFirstGuessThatIsNoCost) {
    const FrameTimeModel model = make_model({nan, -1.0, 0.0, std::numeric_limits<double>::infinity(), 1e300});
    EXPECT_TRUE(std::isfinite(predict_ms(model, {0, 1e9, 4.0, 1e9, 1e9, 1.0, 1e9})));
    EXPECT_EQ(model.first_guess.per_million_triangles_ms, FrameCosts{}.per_million_triangles_ms);
}

}  // namespace
}  // namespace lodestream::control
