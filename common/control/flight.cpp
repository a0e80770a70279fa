#include "common/control/flight.h"

#include <algorithm>
#include <cmath>

namespace lodestream::control {

namespace {

// The exposures are spread evenly over the time that the shutter is open, the last one at its end.
std::vector<motion::Pose> poses_of(const motion::Trace& trace, double t_s, double shutter_s, std::uint32_t exposures) {
    std::vector<motion::Pose> poses;
    for (std::uint32_t i = 1; i <= exposures; ++i)
        poses.push_back(motion::pose_at(trace, t_s - shutter_s * (exposures - i) / exposures));
    return poses;
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

Result<std::vector<FlownFrame>> fly(const Flight& flight, const motion::Trace& trace,
                                    const std::function<Result<FrameOutcome>(const FrameRequest&)>& draw) {
    if (auto sound = check(flight.ladder, flight.options); !sound) return sound.error();
    if (trace.empty()) return invalid_input("a flight needs a motion of at least one sample");
    const double deadline = deadline_ms(flight.options);
    std::vector<FlownFrame> frames;
    State state;
    Measurement now;
    now.pixels = flight.pixels;
    std::optional<DrawnFrame> before;
    for (double t_s = trace.front().t_s; t_s <= trace.back().t_s;) {
        if (frames.size() == max_flight_frames)
            return fail(ErrorCode::limit_exceeded, "the flight has too many frames");
        now.speed_deg_s = motion::speed_deg_s(trace, t_s);
        if (flight.budget) now.budget_triangles = flight.budget(before);
        if (flight.in_view) now.in_view = flight.in_view(motion::pose_at(trace, t_s));
        Step taken = step(flight.kind, flight.ladder, flight.options, std::move(state), now);
        state = std::move(taken.state);
        const Decision& decision = taken.decision;
        const auto drawn =
            draw({t_s, decision.level, decision.switched,
                  poses_of(trace, t_s, std::min(now.interval_s, deadline / 1000.0), decision.exposures)});
        if (!drawn) return drawn.error();
        frames.push_back({t_s, drawn->frame_ms, decision.level, flight.ladder[decision.level].triangles,
                          now.speed_deg_s, drawn->error_px, decision.switched, decision.exposures,
                          decision.predicted_ms});
        const Work work = work_of(flight.ladder, decision.level, decision.exposures, decision.switched, now);
        now.frame_ms = drawn->frame_ms;
        now.background_load = drawn->background_load;
        now.interval_s = std::max(drawn->frame_ms, deadline) / 1000.0;
        before = DrawnFrame{work, drawn->frame_ms, now.interval_s};
        t_s += now.interval_s;
    }
    return frames;
}

FlightSummary summarize(std::span<const FlownFrame> frames, const Options& options) {
    FlightSummary out;
    out.frames = frames.size();
    if (frames.empty()) return out;
    const double deadline = deadline_ms(options), count = static_cast<double>(frames.size());
    const auto fps = [&](const FlownFrame& frame) { return 1000.0 / std::max(frame.frame_ms, deadline); };
    // Sums of differences to the first frame, so that frames that are all alike deviate by nothing.
    const double first_fps = fps(frames.front());
    out.worst_fps = first_fps;
    double sum = 0.0, squares = 0.0;
    std::vector<double> off;
    for (const FlownFrame& frame : frames) {
        const double more_fps = fps(frame) - first_fps;
        sum += more_fps;
        squares += more_fps * more_fps;
        out.worst_fps = std::min(out.worst_fps, fps(frame));
        out.within_deadline += (frame.frame_ms <= deadline ? 1.0 : 0.0) / count;
        out.switches += frame.switched ? 1 : 0;
        out.mean_error_px += frame.error_px / count;
        out.mean_level += frame.level / count;
        if (frame.predicted_ms && frame.frame_ms > 0.0)
            off.push_back(std::abs(*frame.predicted_ms / frame.frame_ms - 1.0));
    }
    out.average_fps = first_fps + sum / count;
    out.deviation_fps = std::sqrt(std::max(squares - sum * sum / count, 0.0) / count);
    if (!off.empty()) out.prediction_error = median(std::move(off));
    return out;
}

}  // namespace lodestream::control
