// Which level of the ladder the coming frame is drawn with: six controllers as pure steps, (state, measurement) →
// (state, decision), without a clock. Level 0 is the finest. Sources: ISBLC paper (seeds-digest §2) for sblc and isblc;
// its future work for acceleration; the frame-rate loop that Nexus (Ponchio et al.) uses for reactive.
//
// Whatever is measured, a decision is a level of the ladder, and every value in a state is finite. A speed that is not
// a number counts as the last one that was, a missing frame time is not learned from, and a clock that goes backwards
// counts as one that stood still.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "common/base/result.h"
#include "common/control/frame_time_model.h"
#include "common/control/motion_blur.h"

namespace lodestream::control {

enum class Kind { none, sblc, isblc, acceleration, reactive, predictive };
inline constexpr Kind kinds[] = {Kind::none,         Kind::sblc,     Kind::isblc,
                                 Kind::acceleration, Kind::reactive, Kind::predictive};
const char* kind_name(Kind kind);  // "none", "sblc", …
Result<Kind> parse_kind(std::string_view name);

// One rung; a ladder is 1 to max_levels of them, triangles falling and errors not falling.
struct Level {
    std::uint64_t triangles = 0;
    double error_px = 0.0;  // on the screen, >= 0
};

// What is known when a frame is about to be drawn.
struct Measurement {
    double interval_s = 0.0;                                            // since the step before
    double speed_deg_s = 0.0;                                           // of the view, now
    double pixels = 0.0;                                                // of the coming frame
    double frame_ms = std::numeric_limits<double>::quiet_NaN();         // of the frame before; not a number: not known
    double background_load = 0.0;                                       // decoding beside the coming frame, [0, 1]
    double budget_triangles = std::numeric_limits<double>::infinity();  // of the plan; only `predictive` keeps to it
    double in_view = 1.0;  // share of the triangles within the coming picture, [0, 1]; not a number: not known, all
};

inline constexpr double max_speed_deg_s = 1e6;
inline constexpr double max_interval_s = 10.0;
inline constexpr double min_target_fps = 1.0, max_target_fps = 1000.0;

// LOD_est = speed * levels_per_deg_s, and still is what is not faster than still_deg_s (α and S_min of the paper).
struct SpeedOptions {
    double still_deg_s = 5.0;
    double levels_per_deg_s = 2.0 / 150.0;   // 3 levels: the coarsest above 75 degrees/s
    double levels_per_deg_s2 = 2.0 / 750.0;  // of `acceleration`
};

// The defaults, which are the paper's for three levels, spread over a ladder of any size: the coarsest is taken at
// about the same speed. pre: levels >= 1
SpeedOptions speed_options(std::size_t levels);

inline constexpr std::uint32_t max_switches_per_s = 8;  // of `predictive`, within any second of the measured intervals
inline constexpr std::uint32_t settle_frames = 240;  // of `predictive`: no switch later than that after a disturbance

// The defaults suit 60 frames/s and a head that turns; each says what moving it trades.
struct PredictiveOptions {
    FrameCosts first_guess;  // from the probe where there is one
    double deadline_share =
        0.94;                     // of the deadline that a frame may be predicted to take; lower: fewer misses, coarser
    double refine_share = 0.86;   // of the deadline, for a finer level; lower: fewer switches, coarser
    double look_ahead_s = 0.10;   // along the motion; longer: earlier coarsening
    double hold_s = 0.08;         // finer only where what moved within it would fit; longer: fewer switches, coarser
    double refine_wait_s = 0.10;  // between a coarser and a finer level; likewise
};

struct Options {
    double target_fps = 60.0;  // clamped to [min_target_fps, max_target_fps]
    SpeedOptions speed;
    BlurOptions blur;
    PredictiveOptions predictive;
};

double deadline_ms(const Options& options);

struct PredictiveState {
    bool started = false;
    FrameTimeModel model;
    Work work;                                // of the frame before
    std::array<std::uint32_t, 3> mistakes{};  // finer levels that were left soon, at 1, 2 and 4 exposures
    double since_switch_s = 0.0;
    std::uint32_t late_frames = 0;  // since the last switch
    bool last_was_refinement = false;
    std::uint32_t exposures_at_switch = 1;
    double in_view_at_switch = 1.0;
    std::array<double, 2> since_exposures_s{};                  // since the view was fast enough for 2 and for 4
    std::array<double, max_switches_per_s> since_switches_s{};  // the last ones, newest first
};

struct State {
    std::uint32_t level = 0;
    bool started = false;      // the first step makes no switch
    double speed_deg_s = 0.0;  // of the step before
    double error_px = 0.0;     // what `reactive` accepts
    PredictiveState predictive;
};

struct Decision {
    std::uint32_t level = 0;  // < ladder.size()
    bool switched = false;    // another level than that of the step before
    std::uint32_t exposures = 1;
    std::optional<double> predicted_ms;  // of the coming frame, where the controller has a model of it
};

struct Step {
    State state;
    Decision decision;
};

// What drawing a level takes; `switched`: it has to be uploaded. pre: level < ladder.size()
Work work_of(std::span<const Level> ladder, std::uint32_t level, std::uint32_t exposures, bool switched,
             const Measurement& now);

// Errors: invalid_input (ladder empty, too long, or not ordered; an option not finite or out of its range).
Status check(std::span<const Level> ladder, const Options& options);

// pre: check(ladder, options) succeeded; `state` is State{} or came from a step with the same kind and ladder
Step step(Kind kind, std::span<const Level> ladder, const Options& options, State state,
          const Measurement& measurement);

}  // namespace lodestream::control
