#include "common/control/control.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/control/predictive.h"
#include "common/control/reactive.h"
#include "common/control/speed_controllers.h"

namespace lodestream::control {

namespace {

constexpr double max_pixels = 1e10;
constexpr double shortest_interval_s = 1e-6;  // within which a change of speed is no acceleration

double in_range(double value, double low, double high, double otherwise) {
    return std::isnan(value) ? otherwise : std::clamp(value, low, high);
}

// Everything finite and in range, but a frame time that is not known.
Measurement cleaned(const Measurement& measured, const State& state) {
    Measurement m = measured;
    m.interval_s = in_range(m.interval_s, 0.0, max_interval_s, 0.0);
    m.speed_deg_s = in_range(m.speed_deg_s, 0.0, max_speed_deg_s, state.speed_deg_s);
    m.pixels = in_range(m.pixels, 0.0, max_pixels, 0.0);
    m.in_view = in_range(m.in_view, 0.0, 1.0, 1.0);
    m.background_load = in_range(m.background_load, 0.0, 1.0, 0.0);
    m.budget_triangles =
        std::isnan(m.budget_triangles) ? std::numeric_limits<double>::infinity() : std::max(m.budget_triangles, 0.0);
    if (!(m.frame_ms > 0.0) || !std::isfinite(m.frame_ms)) m.frame_ms = std::numeric_limits<double>::quiet_NaN();
    return m;
}

double acceleration_of(const State& state, const Measurement& now) {
    if (!state.started || !(now.interval_s > shortest_interval_s)) return 0.0;
    return (now.speed_deg_s - state.speed_deg_s) / now.interval_s;
}

std::optional<std::string> not_above_zero(const char* name, double value) {
    if (std::isfinite(value) && value > 0.0) return std::nullopt;
    return std::string(name) + " must be a finite number above 0";
}

Status check_ladder(std::span<const Level> ladder) {
    if (ladder.empty() || ladder.size() > max_levels)
        return invalid_input("a ladder has 1 to " + std::to_string(max_levels) + " levels");
    for (std::size_t i = 0; i < ladder.size(); ++i) {
        if (!std::isfinite(ladder[i].error_px) || ladder[i].error_px < 0.0)
            return invalid_input("level " + std::to_string(i) + ": error_px must be a finite number, at least 0");
        if (i > 0 && (ladder[i].triangles >= ladder[i - 1].triangles || ladder[i].error_px < ladder[i - 1].error_px))
            return invalid_input("level " + std::to_string(i) +
                                 " must have fewer triangles than the one before it and "
                                 "no less error");
    }
    return Nothing{};
}

}  // namespace

const char* kind_name(Kind kind) {
    switch (kind) {
        case Kind::none:
            return "none";
        case Kind::sblc:
            return "sblc";
        case Kind::isblc:
            return "isblc";
        case Kind::acceleration:
            return "acceleration";
        case Kind::reactive:
            return "reactive";
        case Kind::predictive:
            return "predictive";
    }
    return "none";
}

Result<Kind> parse_kind(std::string_view name) {
    std::string known;
    for (const Kind kind : kinds) {
        if (name == kind_name(kind)) return kind;
        known += (known.empty() ? "" : ", ") + std::string(kind_name(kind));
    }
    return invalid_input("no controller \"" + std::string(name) + "\"; there are " + known);
}

SpeedOptions speed_options(std::size_t levels) {
    SpeedOptions options;
    const double steps_to_default = std::max(static_cast<double>(levels) - 1.0, 1.0) / 2.0;
    options.levels_per_deg_s *= steps_to_default;
    options.levels_per_deg_s2 *= steps_to_default;
    return options;
}

double deadline_ms(const Options& options) {
    return 1000.0 / std::clamp(options.target_fps, min_target_fps, max_target_fps);
}

Work work_of(std::span<const Level> ladder, std::uint32_t level, std::uint32_t exposures, bool switched,
             const Measurement& now) {
    const auto triangles = static_cast<double>(ladder[level].triangles);
    return {level,
            triangles,
            static_cast<double>(exposures),
            now.pixels,
            switched ? triangles : 0.0,
            now.background_load,
            now.pixels,
            triangles * now.in_view};
}

Status check(std::span<const Level> ladder, const Options& options) {
    if (auto sound = check_ladder(ladder); !sound) return sound;
    std::optional<std::string> wrong;
    const auto require = [&](const char* name, double value) {
        if (!wrong) wrong = not_above_zero(name, value);
    };
    require("target_fps", options.target_fps);
    require("still_deg_s", options.speed.still_deg_s);
    require("levels_per_deg_s", options.speed.levels_per_deg_s);
    require("levels_per_deg_s2", options.speed.levels_per_deg_s2);
    require("two_above_deg_s", options.blur.two_above_deg_s);
    require("four_above_deg_s", options.blur.four_above_deg_s);
    require("deadline_share", options.predictive.deadline_share);
    require("refine_share", options.predictive.refine_share);
    require("look_ahead_s", options.predictive.look_ahead_s);
    require("hold_s", options.predictive.hold_s);
    require("refine_wait_s", options.predictive.refine_wait_s);
    if (!wrong && options.predictive.refine_share > options.predictive.deadline_share)
        wrong = "refine_share must not exceed deadline_share";
    if (wrong) return invalid_input(*wrong);
    return Nothing{};
}

Step step(Kind kind, std::span<const Level> ladder, const Options& options, State state,
          const Measurement& measurement) {
    const Measurement now = cleaned(measurement, state);
    const auto last = static_cast<std::uint32_t>(ladder.size()) - 1;
    const double faster_deg_s2 = acceleration_of(state, now);
    std::uint32_t level = state.level;
    Decision decision;
    switch (kind) {
        case Kind::none:
            level = 0;
            break;
        case Kind::sblc:
            level = sblc(level, now.speed_deg_s, state.speed_deg_s, last, options.speed);
            break;
        case Kind::isblc:
            level = isblc(level, now.speed_deg_s, last, options.speed);
            break;
        case Kind::acceleration:
            level = acceleration(level, now.speed_deg_s, faster_deg_s2, last, options.speed);
            break;
        case Kind::reactive: {
            const double frame_ms = std::isnan(now.frame_ms) ? -1.0 : now.frame_ms;
            const Reactive reaction = react(state.error_px, frame_ms, deadline_ms(options), ladder);
            state.error_px = reaction.error_px;
            level = reaction.level;
            break;
        }
        case Kind::predictive: {
            Prediction prediction = predict(std::move(state.predictive), level, now, faster_deg_s2, ladder, options);
            state.predictive = std::move(prediction.state);
            level = prediction.level;
            decision.predicted_ms = prediction.predicted_ms;
            break;
        }
    }
    decision.level = level;
    decision.switched = state.started && level != state.level;
    decision.exposures = exposures(now.speed_deg_s, options.blur);
    state.level = level;
    state.speed_deg_s = now.speed_deg_s;
    state.started = true;
    return {std::move(state), decision};
}

}  // namespace lodestream::control
