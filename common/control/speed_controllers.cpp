#include "common/control/speed_controllers.h"

#include <algorithm>
#include <cmath>

namespace lodestream::control {

namespace {

std::uint32_t finer(std::uint32_t level) {
    return level > 0 ? level - 1 : 0;
}

std::uint32_t coarser(std::uint32_t level, std::uint32_t last) {
    return std::min(level + 1, last);
}

}  // namespace

std::uint32_t sblc(std::uint32_t level, double speed_deg_s, double last_speed_deg_s, std::uint32_t last,
                   const SpeedOptions& options) {
    if (speed_deg_s == last_speed_deg_s) return level;
    if (speed_deg_s <= options.still_deg_s) return 0;
    const double estimate = std::ceil(speed_deg_s * options.levels_per_deg_s);
    return static_cast<std::uint32_t>(std::min(estimate, static_cast<double>(last)));
}

std::uint32_t isblc(std::uint32_t level, double speed_deg_s, std::uint32_t last, const SpeedOptions& options) {
    if (speed_deg_s <= options.still_deg_s) return finer(level);
    const double estimate = speed_deg_s * options.levels_per_deg_s;
    return estimate > level ? coarser(level, last) : level;
}

std::uint32_t acceleration(std::uint32_t level, double speed_deg_s, double acceleration_deg_s2, std::uint32_t last,
                           const SpeedOptions& options) {
    if (speed_deg_s <= options.still_deg_s) return finer(level);
    const double estimate = std::max(acceleration_deg_s2, 0.0) * options.levels_per_deg_s2;
    return estimate > level ? coarser(level, last) : level;
}

}  // namespace lodestream::control
