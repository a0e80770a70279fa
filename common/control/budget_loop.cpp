#include "common/control/budget_loop.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/control/control.h"

namespace lodestream::control {

namespace {

constexpr double deadline_share = PredictiveOptions{}.refine_share;
constexpr double least_share = 0.02;  // of the deadline, left to triangles however dear the pixels are
constexpr double million = 1e6;

double empty_ms(const FrameTimeModel& model, double pixels) {
    return predict_ms(model, {0, 0.0, 1.0, pixels, 0.0, 0.0, pixels, 0.0});
}

double per_million_ms(const FrameTimeModel& model, double pixels) {
    const double full_ms = predict_ms(model, {0, million, 1.0, pixels, 0.0, 0.0, pixels, million});
    return std::max(full_ms - empty_ms(model, pixels), 1e-9);
}

bool is_off(const BudgetLoopState& state, const PlanBasis& now, double pixels, double deadline_ms) {
    if (now.width != state.planned.width || now.height != state.planned.height) return true;
    const double is = now.triangles_per_second, was = state.planned.triangles_per_second;
    const double a_frame = std::abs(is - was) / million * deadline_ms / 1000.0;
    return std::max(is / was, was / is) > 1.0 + replan_share &&
           a_frame * per_million_ms(state.model, pixels) > replan_deadline_share * deadline_ms;
}

}  // namespace

double triangles_per_second(const FrameTimeModel& model, double pixels, double deadline_ms) {
    const double left_ms = std::max(deadline_share * deadline_ms / safety_factor(model) - empty_ms(model, pixels),
                                    least_share * deadline_ms);
    const double per_frame = million * left_ms / per_million_ms(model, pixels);
    return std::clamp(per_frame * 1000.0 / deadline_ms, 1.0, fast_as_measured);
}

BudgetLoopStep follow(BudgetLoopState state, const DrawnFrame& frame, const FrameCosts& first_guess,
                      double deadline_ms) {
    const bool is_first = !state.started;
    if (is_first) state.model = make_model(first_guess);
    state.started = true;
    state.model = learn(std::move(state.model), frame.work, frame.frame_ms);
    const bool is_time = std::isfinite(frame.interval_s) && frame.interval_s > 0.0;
    const double interval_s = is_time ? std::min(frame.interval_s, max_interval_s) : 0.0;
    state.since_plan_s += interval_s;

    const PlanBasis now{triangles_per_second(state.model, frame.work.pixels, deadline_ms), frame.width, frame.height};
    state.off_for_s =
        !is_first && is_off(state, now, frame.work.pixels, deadline_ms) ? state.off_for_s + interval_s : 0.0;
    const bool is_due = is_first || (state.off_for_s >= settle_s && state.since_plan_s >= replan_interval_s);
    if (!is_due) return {std::move(state), std::nullopt};
    state.planned = now;
    state.since_plan_s = state.off_for_s = 0.0;
    return {std::move(state), now};
}

}  // namespace lodestream::control
