#include "common/shading/split_control.h"

#include <algorithm>
#include <cmath>

#include "common/shading/hybrid_split.h"
#include "common/shading/numbers.h"

namespace lodestream::shading {
namespace {

std::uint32_t step_at(double steps_away, std::uint32_t steps) {
    return static_cast<std::uint32_t>(std::clamp(std::ceil(steps_away), 0.0, static_cast<double>(steps)));
}

// Step k covers the distances (k - 1, k], in steps; it is kept a margin farther on both sides.
std::uint32_t held_step(std::uint32_t step, double steps_away, std::uint32_t steps, double margin) {
    const bool holds = step <= steps && steps_away > step - 1.0 - margin && steps_away <= step + margin;
    return holds ? step : step_at(steps_away, steps);
}

// The place nearest to `target` whose error is at most `allowed` from that at `from`; at least one triangle further.
std::uint64_t reachable(std::span<const double> left, std::uint64_t from, std::uint64_t target, double allowed) {
    const auto at = [&](std::uint64_t place) { return left.begin() + static_cast<std::ptrdiff_t>(place); };
    if (target > from) {
        const auto stop = std::partition_point(at(from + 1), at(target + 1),
                                               [&](double error) { return left[from] - error <= allowed; });
        return std::max(from + 1, static_cast<std::uint64_t>(stop - left.begin()) - 1);
    }
    const auto start =
        std::partition_point(at(target), at(from), [&](double error) { return error - left[from] > allowed; });
    return std::min(from - 1, static_cast<std::uint64_t>(start - left.begin()));
}

}  // namespace

SplitState settled_split(double continuous_distance, std::uint32_t steps, std::uint64_t triangles) {
    const std::uint32_t count = std::max(steps, 1u);
    const std::uint32_t step = step_at(std::clamp(finite_or_zero(continuous_distance), 0.0, 1.0) * count, count);
    return {step, gouraud_count(triangles, static_cast<double>(step) / count)};
}

SplitState on_level(const SplitState& state, std::uint64_t triangles_before, std::uint64_t triangles) {
    const double flat = 1.0 - static_cast<double>(std::min(state.gouraud, triangles_before)) /
                                  static_cast<double>(std::max<std::uint64_t>(triangles_before, 1));
    return {state.step, gouraud_count(triangles, flat)};
}

SplitMove move_split(const SplitState& state, double continuous_distance, std::uint32_t steps, const SplitCurve& curve,
                     const SplitControlOptions& options) {
    SplitMove move{state, 0.0};
    if (curve.difference_left.empty()) return move;
    const std::uint32_t count = std::max(steps, 1u);
    const double steps_away = std::clamp(finite_or_zero(continuous_distance), 0.0, 1.0) * count;
    move.state.step = held_step(state.step, steps_away, count, std::clamp(options.hysteresis, 0.0, 1.0));
    const std::uint64_t triangles = curve.difference_left.size() - 1;
    const std::uint64_t from = std::min(state.gouraud, triangles);
    const std::uint64_t target = gouraud_count(triangles, static_cast<double>(move.state.step) / count);
    const double allowed = finite_or_zero(options.max_change * options.max_change * pi * curve.radius * curve.radius);
    move.state.gouraud = target == from ? from : reachable(curve.difference_left, from, target, allowed);
    move.squared_change = std::abs(curve.difference_left[from] - curve.difference_left[move.state.gouraud]);
    return move;
}

}  // namespace lodestream::shading
