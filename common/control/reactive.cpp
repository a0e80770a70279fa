#include "common/control/reactive.h"

#include <algorithm>

namespace lodestream::control {

namespace {

constexpr double least_error_px = 1e-3;

// From half of what the second finest shows, at which the finest is taken, to what the coarsest does.
double within(double error_px, std::span<const Level> ladder) {
    const double low = std::max(ladder[std::min<std::size_t>(1, ladder.size() - 1)].error_px / 2.0, least_error_px);
    return std::clamp(error_px, low, std::max(ladder.back().error_px, low) * reactive_step);
}

}  // namespace

Reactive react(double error_px, double frame_ms, double deadline_ms, std::span<const Level> ladder) {
    if (frame_ms > deadline_ms * reactive_step) error_px *= reactive_step;
    if (frame_ms >= 0.0 && frame_ms < deadline_ms / reactive_step) error_px /= reactive_step;
    error_px = within(error_px, ladder);
    std::uint32_t level = 0;
    while (level + 1 < ladder.size() && ladder[level + 1].error_px <= error_px) ++level;
    return {error_px, level};
}

}  // namespace lodestream::control
