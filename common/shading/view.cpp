#include "common/shading/view.h"

#include <algorithm>
#include <cmath>

namespace lodestream::shading {

namespace {

constexpr double nearest_share_of_radius = 0.01;

double half_fov(const View& view) {
    return radians(std::clamp(view.fov_y_deg, min_fov_deg, max_fov_deg)) / 2.0;
}

double height_of(const budget::Display& display) {
    return std::max<double>(1.0, display.height);
}

// Distance over radius from the eye to the box's centre, without squaring what could overflow.
double relative_distance(const View& view, const Box& bounds) {
    const double radius = bounds.radius();
    if (!(radius > 0.0) || !std::isfinite(radius)) return 1.0;
    const Vec3d offset = (view.eye - bounds.center()) / radius;
    const double distance = std::hypot(offset.x, offset.y, offset.z);
    return std::isfinite(distance) ? distance : std::numeric_limits<double>::max();
}

}  // namespace

Status validate(const View& view) {
    if (!all_finite(view.eye)) return invalid_input("view.eye must hold three finite numbers");
    if (!all_finite(view.target)) return invalid_input("view.target must hold three finite numbers");
    if (!all_finite(view.light)) return invalid_input("view.light must hold three finite numbers");
    if (!std::isfinite(view.fov_y_deg) || view.fov_y_deg <= 0.0 || view.fov_y_deg >= 180.0)
        return invalid_input("view.fov_y_deg must lie between 0 and 180");
    if (view.light == Vec3d{0.0}) return invalid_input("view.light must not be of length zero");
    if (view.eye == view.target) return invalid_input("view.eye and view.target must differ");
    return Nothing{};
}

View framing_view(const Box& world_bounds) {
    View view;
    const double radius = world_bounds.radius() > 0.0 ? world_bounds.radius() : 1.0;
    const Vec3d direction = normalize(Vec3d{0.45, 0.35, 1.0});
    view.target = world_bounds.center();
    view.eye = view.target + direction * (radius / std::sin(half_fov(view)));
    return view;
}

std::uint32_t distance_steps(double dlr) {
    if (!(dlr > 0.0)) return min_distance_steps;
    const double steps = std::round(max_distance_steps * std::sqrt(std::min(dlr, 1.0)));
    return std::clamp(static_cast<std::uint32_t>(steps), min_distance_steps, max_distance_steps);
}

double continuous_distance(const View& view, const Box& world_bounds, const budget::Display& display) {
    const double distance = relative_distance(view, world_bounds);
    const double farthest = height_of(display) / (far_diameter_px * std::tan(half_fov(view)));  // in radii
    if (distance <= 1.0) return 0.0;
    if (farthest <= 1.0 || distance >= farthest) return 1.0;
    return std::clamp(std::log(distance) / std::log(farthest), 0.0, 1.0);
}

double distance_level(const View& view, const Box& world_bounds, const budget::Display& display, std::uint32_t steps) {
    const double count = std::max<std::uint32_t>(steps, 1);
    return std::clamp(std::ceil(continuous_distance(view, world_bounds, display) * count - 1e-9) / count, 0.0, 1.0);
}

double pixels_per_unit(const View& view, const Box& world_bounds, const budget::Display& display) {
    const double radius = world_bounds.radius();
    if (!(radius > 0.0) || !std::isfinite(radius)) return 0.0;
    const double nearest = std::max(relative_distance(view, world_bounds) - 1.0, nearest_share_of_radius);
    const double pixels_per_radius = height_of(display) / (2.0 * std::tan(half_fov(view)) * nearest);
    const double result = pixels_per_radius / radius;
    return std::isfinite(result) ? result : std::numeric_limits<double>::max();
}

}  // namespace lodestream::shading
