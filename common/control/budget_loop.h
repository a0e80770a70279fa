// Closes the loop with the server: what frames take says what this device can draw now, and where that, or the window,
// is no longer what the plan at hand was made for, another plan is asked for. A pure step without a clock.
//
// What the device can draw is worked out from the costs that frames teach (frame_time_model.h), not from the level that
// happens to be drawn: a coarse level's frames, which are mostly fixed cost, do not make the device look slow, so a
// smaller budget is never a reason for a smaller one yet.
#pragma once

#include <cstdint>
#include <optional>

#include "common/control/frame_time_model.h"

namespace lodestream::control {

// Hysteresis: by how much a plan's basis must be off, and how long a plan stands.
inline constexpr double replan_share = 0.25;           // more, or less, than the plan at hand was made for
inline constexpr double replan_deadline_share = 0.06;  // that those triangles take: where pixels leave little to
                                                       // triangles, a quarter of them is no more than noise
inline constexpr double replan_interval_s = 2.0;       // between two plans, whatever happens
inline constexpr double settle_s = 0.5;                // that it must be off without a break: no spike asks for a plan
inline constexpr double fast_as_measured = 1e12;       // triangles/s; no device is told to be faster

// What a plan is made for.
struct PlanBasis {
    double triangles_per_second = 0.0;  // that frames within the deadline can show, >= 1
    std::uint32_t width = 0;            // px, of the window
    std::uint32_t height = 0;           // px
};

// A frame that was drawn.
struct DrawnFrame {
    Work work;
    double frame_ms = 0.0;    // not finite or not above 0: not learned from
    double interval_s = 0.0;  // since the frame before, max_interval_s at most; not finite or not above 0: no time
    std::uint32_t width = 0;  // px, of the window now
    std::uint32_t height = 0;
};

struct BudgetLoopState {
    bool started = false;
    FrameTimeModel model;
    PlanBasis planned;
    double since_plan_s = 0.0;
    double off_for_s = 0.0;
};

struct BudgetLoopStep {
    BudgetLoopState state;
    std::optional<PlanBasis> wish;  // a plan to ask for now
};

// What a device of these costs shows in a second, each frame within `deadline_ms`; in [1, fast_as_measured].
double triangles_per_second(const FrameTimeModel& model, double pixels, double deadline_ms);

// `first_guess`: the costs that are known before the first frame. The first step always has a wish. Whatever is
// measured, wishes are finite and at least replan_interval_s of measured time apart. pre: deadline_ms > 0
BudgetLoopStep follow(BudgetLoopState state, const DrawnFrame& frame, const FrameCosts& first_guess,
                      double deadline_ms);

}  // namespace lodestream::control
