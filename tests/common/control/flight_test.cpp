#include "common/control/flight.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lodestream::control {
namespace {

const std::vector<Level> ladder{{1000, 0.0}, {100, 2.0}};

motion::Trace turning(double seconds, double speed_deg_s) {
    motion::Trace trace;
    for (int i = 0; i <= std::lround(seconds * 100.0); ++i)
        trace.push_back({i / 100.0, {std::nullopt, std::remainder(speed_deg_s * i / 100.0, 360.0), 0.0}});
    return trace;
}

Flight flight(Kind kind) {
    Flight out{kind, ladder, {}, 1e5};
    out.options.target_fps = 50.0;
    return out;
}

auto always(double frame_ms) {
    return [frame_ms](const FrameRequest& request) {
        return Result<FrameOutcome>({frame_ms, 0.0, ladder[request.level].error_px});
    };
}

TEST(Flight, LastsAsLongAsItsFramesAndNeverShorterThanTheDeadline) {
    EXPECT_NEAR(static_cast<double>(fly(flight(Kind::none), turning(2.0, 0.0), always(5.0))->size()), 100.5, 0.6);
    EXPECT_NEAR(static_cast<double>(fly(flight(Kind::none), turning(2.0, 0.0), always(100.0))->size()), 20.5, 0.6);
}

TEST(Flight, AsksForTheControllersLevelsAndSaysWhenTheyChange) {
    const auto frames = fly(flight(Kind::isblc), turning(1.0, 100.0), always(5.0));
    ASSERT_TRUE(frames);
    EXPECT_EQ(frames->at(0).level, 0u);  // held before the first sample: still
    EXPECT_EQ(frames->at(1).level, 1u);
    EXPECT_TRUE(frames->at(1).switched);
    EXPECT_FALSE(frames->at(2).switched);
    EXPECT_EQ(frames->at(2).triangles, 100u);
    EXPECT_EQ(frames->at(2).error_px, 2.0);
    EXPECT_NEAR(frames->at(2).speed_deg_s, 100.0, 1e-6);
}

TEST(Flight, ExposuresAreSpreadOverTheTimeSinceTheFrameBefore) {
    std::vector<FrameRequest> requests;
    const auto frames = fly(flight(Kind::none), turning(1.0, 100.0), [&](const FrameRequest& request) {
        requests.push_back(request);
        return Result<FrameOutcome>({20.0, 0.0, 0.0});
    });
    ASSERT_TRUE(frames);
    EXPECT_EQ(requests[0].poses.size(), 1u);
    ASSERT_EQ(requests[10].poses.size(), 4u);  // at 0.2 s, 20 degrees; 2 degrees since the frame before
    for (int i = 0; i < 4; ++i)
        EXPECT_NEAR(requests[10].poses[static_cast<std::size_t>(i)].yaw_deg, 18.5 + 0.5 * i, 1e-9);
}

TEST(Flight, TheShutterIsNoLongerOpenThanTheDeadline) {
    const auto frames = fly(flight(Kind::none), turning(1.0, 100.0), [](const FrameRequest& request) {
        // Four exposures within 20 ms, not within the 100 ms that the frame before took.
        if (request.poses.size() == 4) {
            EXPECT_NEAR(request.poses[3].yaw_deg - request.poses[0].yaw_deg, 1.5, 1e-9);
        }
        return Result<FrameOutcome>({100.0, 0.0, 0.0});
    });
    ASSERT_TRUE(frames);
    EXPECT_EQ(frames->back().exposures, 4u);
}

// Half of the triangles take half of the time; a model that is told which half is never surprised.
TEST(Flight, APredictionKnowsWhatIsInView) {
    Flight turning_away = flight(Kind::predictive);
    turning_away.options.predictive.first_guess = {1.0, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e4};
    const auto in_view = [](const motion::Pose& pose) { return std::abs(pose.yaw_deg) > 45.0 ? 0.25 : 1.0; };
    turning_away.in_view = in_view;
    const auto frames = fly(turning_away, turning(4.0, 30.0), [&](const FrameRequest& request) {
        const double drawn = 1e-6 * static_cast<double>(ladder[request.level].triangles) * 1e4 *
                             static_cast<double>(request.poses.size());
        return Result<FrameOutcome>({1.0 + drawn * in_view(request.poses.back()), 0.0, 0.0});
    });
    ASSERT_TRUE(frames);
    for (const FlownFrame& frame : *frames) EXPECT_NEAR(*frame.predicted_ms / frame.frame_ms, 1.0, 0.01) << frame.t_s;
}

TEST(Flight, EndsWithTheErrorOfWhoDraws) {
    const auto frames = fly(flight(Kind::none), turning(1.0, 0.0),
                            [](const FrameRequest&) { return Result<FrameOutcome>(fail(ErrorCode::io, "no paper")); });
    EXPECT_EQ(frames.error().message, "no paper");
}

TEST(Flight, RefusesWhatCannotBeFlown) {
    EXPECT_FALSE(fly(flight(Kind::none), {}, always(5.0)));
    EXPECT_FALSE(fly({Kind::none, {}, {}, 0.0}, turning(1.0, 0.0), always(5.0)));
    EXPECT_EQ(fly(flight(Kind::none), {{0.0, {}}, {1e9, {}}}, always(1e-3)).error().code, ErrorCode::limit_exceeded);
}

TEST(Flight, AFlightInNumbers) {
    Options options;
    options.target_fps = 50.0;
    std::vector<FlownFrame> frames(4);
    for (FlownFrame& frame : frames) frame.frame_ms = 10.0;
    frames[1].frame_ms = 40.0;  // 25 fps, the others 50
    frames[1].switched = true;
    frames[1].error_px = 2.0;
    frames[1].level = 1;
    frames[2].frame_ms = 20.0;  // just in time
    frames[2].predicted_ms = 22.0;
    const FlightSummary summary = summarize(frames, options);
    EXPECT_EQ(summary.frames, 4u);
    EXPECT_DOUBLE_EQ(summary.average_fps, 43.75);
    EXPECT_DOUBLE_EQ(summary.worst_fps, 25.0);
    EXPECT_NEAR(summary.deviation_fps, std::sqrt((3 * 6.25 * 6.25 + 18.75 * 18.75) / 4.0), 1e-12);
    EXPECT_NEAR(summary.deviation_ms, std::sqrt((100.0 + 400.0 + 100.0) / 4.0), 1e-12);
    EXPECT_DOUBLE_EQ(summary.within_deadline, 0.75);
    EXPECT_EQ(summary.switches, 1u);
    EXPECT_DOUBLE_EQ(summary.mean_error_px, 0.5);
    EXPECT_DOUBLE_EQ(summary.mean_level, 0.25);
    EXPECT_NEAR(*summary.prediction_error, 0.1, 1e-12);
    EXPECT_EQ(summarize({}, options).frames, 0u);

    options.target_fps = 60.0;
    const std::vector<FlownFrame> even(241, frames[0]);
    EXPECT_EQ(summarize(even, options).deviation_fps, 0.0);
    EXPECT_EQ(summarize(even, options).deviation_ms, 0.0);
}

}  // namespace
}  // namespace lodestream::control
