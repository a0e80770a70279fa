#include "common/scene/view.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace lodestream::scene {

namespace {

constexpr double min_fov_deg = 1.0, max_fov_deg = 170.0;
constexpr double least_sine = 1e-6;  // between the view and its up
constexpr double along_y = 1.0 - 1e-6;

Vec3d forward_of(const View& view) {
    return normalize(view.target - view.eye);
}

}  // namespace

Status validate(const View& view) {
    if (!all_finite(view.eye) || !all_finite(view.target) || !all_finite(view.up))
        return invalid_input("a view's eye, target and up must be finite");
    const Vec3d towards = view.target - view.eye;
    if (!(length(towards) > 0) || !std::isfinite(length(towards)))
        return invalid_input("a view's eye must not be its target");
    if (!(length(view.up) > 0) || !(length(cross(forward_of(view), normalize(view.up))) > least_sine))
        return invalid_input("a view's up must not lie along it");
    if (!(view.fov_y_deg >= min_fov_deg && view.fov_y_deg <= max_fov_deg))
        return invalid_input("a view's angle must be 1 to 170 degrees");
    if (view.width == 0 || view.height == 0) return invalid_input("a view's canvas must have pixels");
    if (!(view.near > 0) || !std::isfinite(view.near))
        return invalid_input("a view's near plane must be in front of the eye");
    return Nothing{};
}

View view_towards(const Vec3d& eye, const Vec3d& target) {
    View view;
    view.eye = eye;
    view.target = target;
    if (std::abs(forward_of(view).y) > along_y) view.up = {1.0, 0.0, 0.0};
    return view;
}

View ahead_of(const View& before, const View& now, double steps) {
    const Vec3d was = normalize(before.target - before.eye), is = normalize(now.target - now.eye);
    const Vec3d axis = cross(was, is);
    const double sine = length(axis);
    const double turn = std::min(steps * std::atan2(sine, dot(was, is)), pi);
    View view = now;
    view.eye += steps * (now.eye - before.eye);
    Vec3d direction = is;
    if (sine > 0.0) direction = std::cos(turn) * is + std::sin(turn) * cross(axis / sine, is);
    view.target = view.eye + distance(now.target, now.eye) * direction;
    return validate(view) ? view : now;
}

Projection::Projection(const View& view) : eye_(view.eye), forward_(forward_of(view)), near_(view.near) {
    assert(validate(view));
    const Vec3d right = normalize(cross(forward_, view.up)), up = cross(right, forward_);
    const double tangent_y = std::tan(radians(view.fov_y_deg) / 2.0);
    const double tangent_x = tangent_y * view.width / view.height;
    focal_px_ = view.height / 2.0 / tangent_y;
    canvas_px_ = 1.0 * view.width * view.height;
    corner_cosine_ = 1.0 / std::hypot(1.0, tangent_x, tangent_y);
    const auto side = [&](const Vec3d& normal) {
        const Vec3d unit = normalize(normal);
        return Plane{unit, -dot(unit, eye_)};
    };
    planes_[0] = {forward_, -dot(forward_, eye_) - near_};
    planes_[1] = side(forward_ * tangent_x + right);
    planes_[2] = side(forward_ * tangent_x - right);
    planes_[3] = side(forward_ * tangent_y + up);
    planes_[4] = side(forward_ * tangent_y - up);
}

bool Projection::sees(const Box& box) const {
    if (box.empty()) return false;
    for (const Plane& plane : planes_) {
        const Vec3d foremost{plane.normal.x > 0 ? box.max.x : box.min.x, plane.normal.y > 0 ? box.max.y : box.min.y,
                             plane.normal.z > 0 ? box.max.z : box.min.z};
        if (dot(plane.normal, foremost) + plane.offset < 0) return false;
    }
    return true;
}

// What is on the canvas and at least this far from the eye is at least the corner's cosine of it deep.
double Projection::least_depth(const Box& box) const {
    const Vec3d hindmost{forward_.x > 0 ? box.min.x : box.max.x, forward_.y > 0 ? box.min.y : box.max.y,
                         forward_.z > 0 ? box.min.z : box.max.z};
    const Vec3d outside = glm::max(glm::max(box.min - eye_, eye_ - box.max), Vec3d{0.0});
    return std::max({dot(forward_, hindmost - eye_), corner_cosine_ * length(outside), near_});
}

double Projection::error_px(const Box& box, double error) const {
    return error > 0 && sees(box) ? error * focal_px_ / least_depth(box) : 0.0;
}

double Projection::picture_error(const Box& box, double error) const {
    if (!(error > 0) || !sees(box)) return 0.0;
    const double px_per_unit = focal_px_ / least_depth(box), side = px_per_unit * box.diagonal();
    return error * px_per_unit * std::min(side * side, canvas_px_);
}

}  // namespace lodestream::scene
