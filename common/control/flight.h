// Flies a motion frame by frame under a controller: the loop that the simulator and the real renderer share. Time
// passes as the frames do: a frame lasts as long as it takes to draw, and never shorter than the deadline, since no
// display shows more pictures than its rate.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/control/budget_loop.h"
#include "common/control/control.h"
#include "common/motion/motion.h"

namespace lodestream::control {

inline constexpr std::size_t max_flight_frames = 1'000'000;

// What is to be drawn.
struct FrameRequest {
    double t_s = 0.0;
    std::uint32_t level = 0;
    bool switched = false;  // another level than the frame before; false for the first frame
    // 1 to max_exposures; the frame is their mean. The last one is that of t_s, the others lie evenly before it, within
    // the time since the frame before and the deadline, whichever is shorter.
    std::vector<motion::Pose> poses;
};

struct FrameOutcome {
    double frame_ms = 0.0;         // with all that had to happen before it could be shown, level change included
    double background_load = 0.0;  // decoding that the next frame will have beside it, [0, 1]
    double error_px = 0.0;         // of that level in that view
};

struct Flight {
    Kind kind = Kind::none;
    std::span<const Level> ladder;
    Options options;
    double pixels = 0.0;  // of a frame
    // Triangles that the coming frame may have, as a plan says; is told the frame before. Empty: no plan.
    std::function<double(const std::optional<DrawnFrame>&)> budget{};
    std::function<double(const motion::Pose&)> in_view{};  // of Measurement, of what that pose sees; empty: all
};

struct FlownFrame {
    double t_s = 0.0;
    double frame_ms = 0.0;
    std::uint32_t level = 0;
    std::uint64_t triangles = 0;
    double speed_deg_s = 0.0;
    double error_px = 0.0;
    bool switched = false;
    std::uint32_t exposures = 1;
    std::optional<double> predicted_ms;
};

// Draws from the trace's first moment to its last. Errors: invalid_input (check(); an empty trace), limit_exceeded
// (more than max_flight_frames), and whatever `draw` fails with.
Result<std::vector<FlownFrame>> fly(const Flight& flight, const motion::Trace& trace,
                                    const std::function<Result<FrameOutcome>(const FrameRequest&)>& draw);

// A flight in numbers. Frame rates are those of single frames, 1000 / max(frame_ms, deadline).
struct FlightSummary {
    std::size_t frames = 0;
    double average_fps = 0.0;
    double worst_fps = 0.0;
    double deviation_fps = 0.0;    // standard deviation; 0 where every frame is in time
    double deviation_ms = 0.0;     // that of frame_ms: of what frames take, no wait for the deadline in it
    double within_deadline = 0.0;  // share of the frames
    std::uint32_t switches = 0;
    double mean_error_px = 0.0;
    double mean_level = 0.0;
    std::optional<double> prediction_error;  // median of |predicted / measured - 1|, where there was a prediction
};

// All 0 for no frames.
FlightSummary summarize(std::span<const FlownFrame> frames, const Options& options);

}  // namespace lodestream::control
