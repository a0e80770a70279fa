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

// Sums of differences to the first value, so that values that are all alike deviate by nothing.
class Spread {
  public:
    void add(double value) {
        if (count_ == 0.0) first_ = value;
        const double more = value - first_;
        sum_ += more;
        squares_ += more * more;
        count_ += 1.0;
    }
    double mean() const { return first_ + sum_ / count_; }
    double deviation() const { return std::sqrt(std::max(squares_ - sum_ * sum_ / count_, 0.0) / count_); }

  private:
    double first_ = 0.0, sum_ = 0.0, squares_ = 0.0, count_ = 0.0;
};

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
    out.worst_fps = fps(frames.front());
    Spread rates, times_ms;
    std::vector<double> off;
    for (const FlownFrame& frame : frames) {
        rates.add(fps(frame));
        times_ms.add(frame.frame_ms);
        out.worst_fps = std::min(out.worst_fps, fps(frame));
        out.within_deadline += (frame.frame_ms <= deadline ? 1.0 : 0.0) / count;
        out.switches += frame.switched ? 1 : 0;
        out.mean_error_px += frame.error_px / count;
        out.mean_level += frame.level / count;
        if (frame.predicted_ms && frame.frame_ms > 0.0)
            off.push_back(std::abs(*frame.predicted_ms / frame.frame_ms - 1.0));
    }
    out.average_fps = rates.mean();
    out.deviation_fps = rates.deviation();
    out.deviation_ms = times_ms.deviation();
    if (!off.empty()) out.prediction_error = median(std::move(off));
    return out;
}

}  // namespace lodestream::control
