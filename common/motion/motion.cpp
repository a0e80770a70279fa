#include "common/motion/motion.h"

#include <algorithm>
#include <cmath>

namespace lodestream::motion {

namespace {

double shortest_turn(double from_deg, double to_deg) {
    return std::remainder(to_deg - from_deg, 360.0);
}

std::optional<Vec3d> position_between(const Pose& a, const Pose& b, double share) {
    if (a.position && b.position) return *a.position + (*b.position - *a.position) * share;
    return a.position ? a.position : b.position;
}

}  // namespace

Pose looking_at(const Vec3d& eye, const Vec3d& target) {
    const Vec3d forward = normalize(target - eye);
    const auto degrees = [](double angle) { return angle * 180.0 / pi; };
    return {eye, degrees(std::atan2(-forward.x, -forward.z)), degrees(std::asin(std::clamp(forward.y, -1.0, 1.0)))};
}

double duration_s(const Trace& trace) {
    return trace.empty() ? 0.0 : trace.back().t_s - trace.front().t_s;
}

Pose pose_at(const Trace& trace, double t_s) {
    if (trace.empty()) return {};
    if (!(t_s > trace.front().t_s)) return trace.front().pose;
    const auto after =
        std::upper_bound(trace.begin(), trace.end(), t_s, [](double t, const Sample& s) { return t < s.t_s; });
    if (after == trace.end()) return trace.back().pose;
    const Sample &a = *(after - 1), &b = *after;
    const double share = (t_s - a.t_s) / (b.t_s - a.t_s);
    return {position_between(a.pose, b.pose, share),
            a.pose.yaw_deg + shortest_turn(a.pose.yaw_deg, b.pose.yaw_deg) * share,
            a.pose.pitch_deg + (b.pose.pitch_deg - a.pose.pitch_deg) * share};
}

Vec3d direction(const Pose& pose) {
    const double yaw = radians(std::remainder(pose.yaw_deg, 360.0));
    const double pitch = radians(std::clamp(pose.pitch_deg, -max_pitch_deg, max_pitch_deg));
    return {-std::sin(yaw) * std::cos(pitch), std::sin(pitch), -std::cos(yaw) * std::cos(pitch)};
}

double speed_deg_s(const Trace& trace, double t_s) {
    const Vec3d before = direction(pose_at(trace, t_s - sensor_interval_s));
    const Vec3d now = direction(pose_at(trace, t_s));
    // atan2 keeps small angles exact, where acos would lose half of the digits.
    const double angle = std::atan2(length(cross(before, now)), dot(before, now));
    return angle * 180.0 / pi / sensor_interval_s;
}

const char* kind_name(Kind kind) {
    switch (kind) {
        case Kind::still:
            return "still";
        case Kind::start:
            return "start";
        case Kind::stop:
            return "stop";
        case Kind::reversal:
            return "reversal";
        case Kind::nod:
            return "nod";
        case Kind::circle:
            return "circle";
        case Kind::mix:
            return "mix";
    }
    return "mix";
}

Result<Kind> parse_kind(std::string_view name) {
    std::string known;
    for (const Kind kind : kinds) {
        if (name == kind_name(kind)) return kind;
        known += (known.empty() ? "" : ", ") + std::string(kind_name(kind));
    }
    return invalid_input("no built-in motion \"" + std::string(name) + "\"; there are " + known);
}

}  // namespace lodestream::motion
