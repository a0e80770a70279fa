#include "common/control/motion_blur.h"

namespace lodestream::control {

std::uint32_t exposures(double speed_deg_s, const BlurOptions& options) {
    if (!options.enabled || !(speed_deg_s > options.two_above_deg_s)) return 1;
    return speed_deg_s > options.four_above_deg_s ? max_exposures : 2;
}

}  // namespace lodestream::control
