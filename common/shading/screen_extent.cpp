#include "common/shading/screen_extent.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace lodestream::shading {

namespace {

constexpr double nearest_share_of_target = 1e-6;  // of the target's distance; what is nearer is behind the eye
constexpr double farthest_px = 1e7;               // off the picture's middle; as far as a projection is told

struct OnScreen {
    double x = 0.0, y = 0.0;  // px from the picture's middle
    bool in_front = false;
};

// View axes and what a unit at distance 1 measures on the screen.
struct Projection {
    Vec3d eye, right, up, forward;
    double px = 1.0;
    double nearest = 0.0;
};

Projection projection_of(const View& view, const budget::Display& display) {
    const Vec3d to_target = view.target - view.eye;
    const Vec3d forward = normalize(to_target);
    const Vec3d any_up = std::abs(forward.y) < 0.999 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
    const Vec3d right = normalize(cross(forward, any_up));
    const double half_fov = radians(std::clamp(view.fov_y_deg, min_fov_deg, max_fov_deg)) / 2.0;
    return {view.eye,
            right,
            cross(right, forward),
            forward,
            0.5 * std::max<double>(1.0, display.height) / std::tan(half_fov),
            nearest_share_of_target * length(to_target)};
}

OnScreen project(const Projection& p, const Vec3d& position) {
    const Vec3d offset = position - p.eye;
    const double depth = dot(offset, p.forward);
    if (!(depth > p.nearest)) return {};
    const auto px = [&](const Vec3d& axis) {
        return std::clamp(p.px * dot(offset, axis) / depth, -farthest_px, farthest_px);
    };
    return {px(p.right), px(p.up), true};
}

struct Interval {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
    double length() const { return std::max(high - low, 0.0); }
    void add(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    Interval within(double half) const { return {std::max(low, -half), std::min(high, half)}; }
};

double area(const OnScreen& a, const OnScreen& b, const OnScreen& c) {
    return 0.5 * std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y));
}

}  // namespace

ScreenExtent screen_extent(const mesh::Mesh& mesh, const Vec3d& origin, const View& view,
                           const budget::Display& display) {
    const Projection projection = projection_of(view, display);
    std::vector<OnScreen> corners;
    corners.reserve(mesh.positions.size());
    for (const Vec3f& p : mesh.positions) corners.push_back(project(projection, Vec3d(p) + origin));
    const double half_width = 0.5 * display.width, half_height = 0.5 * display.height;
    ScreenExtent sum;
    for (const mesh::Triangle& t : mesh.triangles) {
        Interval x, y;
        for (const std::uint32_t v : t)
            if (corners[v].in_front) {
                x.add(corners[v].x);
                y.add(corners[v].y);
            }
        const double rectangle = x.length() * y.length();
        const double shown = x.within(half_width).length() * y.within(half_height).length();
        if (!(shown > 0.0)) continue;
        sum.extent_px += std::sqrt(shown);
        const bool is_whole = corners[t[0]].in_front && corners[t[1]].in_front && corners[t[2]].in_front;
        // One that reaches behind the eye is taken to fill half of the rectangle that is told.
        const double all = is_whole ? area(corners[t[0]], corners[t[1]], corners[t[2]]) : 0.5 * rectangle;
        sum.covered_px += all * shown / rectangle;
    }
    return sum;
}

}  // namespace lodestream::shading
