#include "common/control/predictive.h"

#include <algorithm>
#include <cmath>

namespace lodestream::control {

namespace {

constexpr double long_ago_s = 1e6;
constexpr double undone_within_s = 1.0;  // a finer level that is left sooner without more motion was a mistake
constexpr double more_in_view = 1.1;     // times the share of the triangles that was in view: more to draw
constexpr double mistake_share = 0.93;   // of the room for a finer level, after each mistake
constexpr std::uint32_t most_mistakes = 4, most_late_frames = 2;  // that are counted
constexpr double settled_s = 2.0;  // a level that lasted is left for as much more room as after one more mistake: noise
                                   // alone would else try a finer one at last
constexpr double trial_s = 0.25;   // of a finer level, unless a frame is late; the model knows by then what it takes
constexpr double optimism = 0.7;   // at rest; predictions of a level not drawn for long have been off as much, and only
                                   // trying tells
constexpr double once_more_s = 1.0;  // after a trial that failed: what else ran then may be done
constexpr double budget_share_to_refine = 0.9;

// One frame's question, with everything that the answer depends on.
struct Question {
    const PredictiveState& state;
    std::uint32_t level;
    const Measurement& now;
    std::span<const Level> ladder;
    const Options& options;
    double safety = 1.0;
    std::uint32_t exposures = 1;        // now
    std::uint32_t exposures_ahead = 1;  // the most, now and along the motion
    std::uint32_t exposures_held = 1;   // the most, ahead and within the last hold_s
    bool at_rest = false;               // as long: a late frame would show what was there anyway
};

Work work_of(const Question& q, std::uint32_t level, std::uint32_t exposures, bool switched) {
    return control::work_of(q.ladder, level, exposures, switched, q.now);
}

double need_ms(const Question& q, std::uint32_t level, std::uint32_t exposures, bool switched) {
    return predict_ms(q.state.model, work_of(q, level, exposures, switched)) * q.safety;
}

bool fits(const Question& q, std::uint32_t level, std::uint32_t exposures, bool switched, double share) {
    return need_ms(q, level, exposures, switched) <= share * deadline_ms(q.options);
}

bool within_budget(const Question& q, std::uint32_t level, double share) {
    return static_cast<double>(q.ladder[level].triangles) <= share * q.now.budget_triangles;
}

// Switches within the last second.
std::uint32_t recent_switches(const PredictiveState& state) {
    return static_cast<std::uint32_t>(std::count_if(state.since_switches_s.begin(), state.since_switches_s.end(),
                                                    [](double since_s) { return since_s <= 1.0; }));
}

// 0, 1 and 2 for 1, 2 and 4.
std::size_t index_of(std::uint32_t exposures) {
    return exposures >= max_exposures ? 2 : exposures - 1;
}

// The coarsest where nothing fits. Where the upload alone breaks this frame's deadline, the frames after it count.
std::uint32_t finest_that_fits(const Question& q, double share) {
    const auto last = static_cast<std::uint32_t>(q.ladder.size()) - 1;
    for (const bool with_upload : {true, false})
        for (std::uint32_t level = 0; level <= last; ++level)
            if (within_budget(q, level, 1.0) && fits(q, level, q.exposures, with_upload && level != q.level, share) &&
                fits(q, level, q.exposures_ahead, false, share))
                return level;
    return last;
}

// Than at the last switch.
bool has_more_to_draw(const Question& q) {
    return q.exposures_ahead > q.state.exposures_at_switch || q.now.in_view > more_in_view * q.state.in_view_at_switch;
}

// A finer level is judged by what it takes, not by what it was predicted to take. At rest one late frame is let pass,
// which anything may have made late.
bool is_on_trial(const Question& q) {
    const std::uint32_t most_late = q.at_rest ? 1 : 0;
    return q.state.last_was_refinement && q.state.since_switch_s <= trial_s && q.state.late_frames <= most_late &&
           !has_more_to_draw(q);
}

bool may_be_tried(const Question& q, std::uint32_t mistakes) {
    return q.at_rest && (mistakes == 0 || (mistakes == 1 && q.state.since_switch_s >= once_more_s));
}

bool must_coarsen(const Question& q) {
    const double share = q.options.predictive.deadline_share;
    if (!within_budget(q, q.level, 1.0)) return true;
    if (is_on_trial(q)) return false;
    if (!fits(q, q.level, q.exposures, false, share)) return true;
    if (fits(q, q.level, q.exposures_ahead, false, share)) return false;
    // It will have to; now rather than then, unless the switch fits then as well.
    const std::uint32_t next = finest_that_fits(q, share);
    return !fits(q, next, q.exposures_ahead, true, share) && fits(q, next, q.exposures, true, share);
}

// The finest of the finer levels that may be taken now, or the same level.
std::uint32_t refined(const Question& q) {
    const PredictiveOptions& options = q.options.predictive;
    const bool waited = q.state.last_was_refinement || q.state.since_switch_s >= options.refine_wait_s;
    const bool may_be_undone = recent_switches(q.state) + 2 <= max_switches_per_s;
    if (!waited || !may_be_undone) return q.level;
    const std::uint32_t mistakes = q.state.mistakes[index_of(q.exposures_held)];
    Question asked = q;
    if (may_be_tried(q, mistakes)) asked.safety = optimism;
    const std::uint32_t settled = q.state.since_switch_s >= settled_s ? 1 : 0;
    const double share = options.refine_share * std::pow(mistake_share, mistakes + settled);
    for (std::uint32_t level = 0; level < q.level; ++level)
        if (within_budget(q, level, budget_share_to_refine) && fits(asked, level, q.exposures_held, false, share) &&
            fits(asked, level, q.exposures, true, options.deadline_share))
            return level;
    return q.level;
}

std::uint32_t choose(const Question& q) {
    if (!q.state.started) return finest_that_fits(q, q.options.predictive.refine_share);
    if (!must_coarsen(q)) return refined(q);
    if (recent_switches(q.state) >= max_switches_per_s) return q.level;
    return std::max(q.level, finest_that_fits(q, q.options.predictive.deadline_share));
}

void pass_time(PredictiveState& state, double interval_s) {
    const auto older = [&](double& since_s) { since_s = std::min(since_s + interval_s, long_ago_s); };
    older(state.since_switch_s);
    std::for_each(state.since_exposures_s.begin(), state.since_exposures_s.end(), older);
    std::for_each(state.since_switches_s.begin(), state.since_switches_s.end(), older);
}

// The frame with the upload counts for nothing.
void note_late_frame(PredictiveState& state, double frame_ms, double deadline) {
    if (frame_ms > deadline && state.work.uploaded_triangles == 0.0)
        state.late_frames = std::min(state.late_frames + 1, most_late_frames);
}

void note_exposures(PredictiveState& state, std::uint32_t exposures) {
    if (exposures >= 2) state.since_exposures_s[0] = 0.0;
    if (exposures >= max_exposures) state.since_exposures_s[1] = 0.0;
}

std::uint32_t held_exposures(const PredictiveState& state, double hold_s) {
    if (state.since_exposures_s[1] <= hold_s) return max_exposures;
    return state.since_exposures_s[0] <= hold_s ? 2 : 1;
}

// A finer level that had to be left although there was no more to draw is a mistake, one that lasted takes a mistake
// back.
void judge_refinement(PredictiveState& state, bool finer, const Question& q) {
    if (!state.last_was_refinement) return;
    std::uint32_t& mistakes = state.mistakes[index_of(state.exposures_at_switch)];
    if (state.since_switch_s >= undone_within_s)
        mistakes -= mistakes > 0 ? 1 : 0;
    else if (!finer && !has_more_to_draw(q))
        mistakes = std::min(mistakes + 1, most_mistakes);
}

void note_switch(PredictiveState& state, bool finer, const Question& q) {
    judge_refinement(state, finer, q);
    state.since_switch_s = 0.0;
    state.late_frames = 0;
    state.last_was_refinement = finer;
    state.exposures_at_switch = q.exposures_held;
    state.in_view_at_switch = q.now.in_view;
    std::rotate(state.since_switches_s.begin(), state.since_switches_s.end() - 1, state.since_switches_s.end());
    state.since_switches_s.front() = 0.0;
}

PredictiveState first_state(const PredictiveOptions& options) {
    PredictiveState state;
    state.model = make_model(options.first_guess);
    state.since_switch_s = long_ago_s;
    state.since_exposures_s.fill(long_ago_s);
    state.since_switches_s.fill(long_ago_s);
    return state;
}

}  // namespace

Prediction predict(PredictiveState state, std::uint32_t level, const Measurement& now, double acceleration_deg_s2,
                   std::span<const Level> ladder, const Options& options) {
    const bool first = !state.started;
    if (first) state = first_state(options.predictive);
    pass_time(state, now.interval_s);
    if (!first) {
        note_late_frame(state, now.frame_ms, deadline_ms(options));
        state.model = learn(std::move(state.model), state.work, now.frame_ms);
    }

    // A view that slows down as fast as that turns back rather than stops.
    const double speed_ahead = std::abs(now.speed_deg_s + acceleration_deg_s2 * options.predictive.look_ahead_s);
    Question q{state, level, now, ladder, options, safety_factor(state.model)};
    q.exposures = exposures(now.speed_deg_s, options.blur);
    q.exposures_ahead = std::max(q.exposures, exposures(speed_ahead, options.blur));
    note_exposures(state, q.exposures);
    q.exposures_held = std::max(q.exposures_ahead, held_exposures(state, options.predictive.hold_s));
    q.at_rest = q.exposures_held == 1 && std::max(std::abs(now.speed_deg_s), speed_ahead) <= options.speed.still_deg_s;

    const std::uint32_t chosen = choose(q);
    const bool switched = !first && chosen != level;
    const Work work = work_of(q, chosen, q.exposures, switched);
    if (switched) note_switch(state, chosen < level, q);
    state.work = work;
    state.started = true;
    const double predicted_ms = predict_ms(state.model, work);
    return {std::move(state), chosen, predicted_ms};
}

}  // namespace lodestream::control
