// The view that a plan is made for, and what it says about an object's distance and error on the screen.
#pragma once

#include "common/base/math.h"
#include "common/base/result.h"
#include "common/budget/budget.h"

namespace lodestream::shading {

struct View {
    Vec3d eye{0.0};
    Vec3d target{0.0};
    double fov_y_deg = 45.0;     // clamped to [min_fov_deg, max_fov_deg]
    Vec3d light{0.3, 1.0, 0.5};  // direction towards the light, world axes; any finite length but zero
};

inline constexpr double min_fov_deg = 1.0;
inline constexpr double max_fov_deg = 170.0;
inline constexpr budget::Display default_display{800, 600};
inline constexpr double far_diameter_px = 16.0;  // an object this tall on the screen counts as farthest
inline constexpr std::uint32_t min_distance_steps = 2;
inline constexpr std::uint32_t max_distance_steps = 16;

// Refuses non-finite numbers, a light of length zero, an eye at its target.
Status validate(const View& view);

// The view that frames a bounding sphere: from the front, a little above and to the right, sphere touching the frustum.
View framing_view(const Box& world_bounds);

// Distance steps between nearest and farthest by the device's capacity (paper §2.2: "many or few steps according to the
// device"): 16 * sqrt(DLR), rounded and clamped to [2, 16].
std::uint32_t distance_steps(double dlr);

// The paper's d in [0,1]: 0 with the eye on the bounding sphere or inside, 1 where the sphere is far_diameter_px tall;
// logarithmic between (each halving of the size counts alike).
double continuous_distance(const View& view, const Box& world_bounds, const budget::Display& display);
// The same, rounded up to the next of `steps` steps.
double distance_level(const View& view, const Box& world_bounds, const budget::Display& display, std::uint32_t steps);

// Pixels that one model unit covers at the nearest point of the bounding sphere; finite for any eye (one at or inside
// the sphere is taken as 1/100 radius away from it).
double pixels_per_unit(const View& view, const Box& world_bounds, const budget::Display& display);

}  // namespace lodestream::shading
