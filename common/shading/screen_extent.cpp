#include "common/shading/screen_extent.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "common/base/raster.h"

namespace lodestream::shading {

namespace {

constexpr double nearest_share_of_target = 1e-6;  // of the target's distance; what is nearer is behind the eye
constexpr double farthest_px = 1e7;               // off the picture's middle; as far as a projection is told
constexpr double most_samples = 32'768;           // of the raster that tells what is shaded

struct OnScreen {
    double x = 0.0, y = 0.0;  // px from the picture's middle
    double nearness = 0.0;    // 1 / depth; 0: behind the eye
    bool in_front() const { return nearness > 0.0; }
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
    return {px(p.right), px(p.up), 1.0 / depth};
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

// Of the samples that triangles cover: how many there were and how many lay before all before.
struct Samples {
    double covered = 0.0, shaded = 0.0;
};

// A grid of samples over the picture, a cell's middle each.
struct Raster {
    std::uint32_t width, height;
    double cells_per_px_x, cells_per_px_y;
    std::span<float> nearest;

    void draw(const std::array<OnScreen, 3>& corners, Samples& samples) const {
        const auto placed = [&](const OnScreen& c) {
            return Vec3d{(c.x * cells_per_px_x) + 0.5 * width, (c.y * cells_per_px_y) + 0.5 * height, c.nearness};
        };
        const std::array<Vec3d, 3> at{placed(corners[0]), placed(corners[1]), placed(corners[2])};
        // Nearness is linear on the screen.
        const Vec3d normal = cross(at[1] - at[0], at[2] - at[0]);
        const double by_x = normal.z != 0.0 ? -normal.x / normal.z : 0.0;
        const double by_y = normal.z != 0.0 ? -normal.y / normal.z : 0.0;
        const double least = std::min({at[0].z, at[1].z, at[2].z}), most = std::max({at[0].z, at[1].z, at[2].z});
        for_each_pixel(at, width, height, [&](std::uint32_t x, std::uint32_t y) {
            const double told = at[0].z + (x + 0.5 - at[0].x) * by_x + (y + 0.5 - at[0].y) * by_y;
            const auto nearness = static_cast<float>(std::clamp(told, least, most));
            float& nearest_here = nearest[std::size_t{y} * width + x];
            samples.covered += 1.0;
            if (!(nearness >= nearest_here)) return;  // GL_LEQUAL
            nearest_here = nearness;
            samples.shaded += 1.0;
        });
    }
};

}  // namespace

ScreenExtents::ScreenExtents(const View& view, const budget::Display& display) : view_(view), display_(display) {
    const double pixels = std::max(1.0, static_cast<double>(display.width) * display.height);
    const double scale = std::min(1.0, std::sqrt(most_samples / pixels));
    const auto cells = [&](std::uint32_t px) { return std::max(1u, static_cast<std::uint32_t>(px * scale)); };
    width_ = std::min(cells(display.width), static_cast<std::uint32_t>(most_samples));
    height_ = std::min(cells(display.height), static_cast<std::uint32_t>(most_samples));
    nearest_.assign(std::size_t{width_} * height_, 0.0f);
}

ScreenExtent ScreenExtents::draw(const mesh::Mesh& mesh, const Vec3d& origin) {
    const Projection projection = projection_of(view_, display_);
    std::vector<OnScreen> projected;
    projected.reserve(mesh.positions.size());
    for (const Vec3f& p : mesh.positions) projected.push_back(project(projection, Vec3d(p) + origin));
    const double half_width = 0.5 * display_.width, half_height = 0.5 * display_.height;
    const Raster raster{width_, height_, width_ / std::max(1.0, static_cast<double>(display_.width)),
                        height_ / std::max(1.0, static_cast<double>(display_.height)), nearest_};
    ScreenExtent sum;
    double covered_px = 0.0;
    Samples samples;
    for (const mesh::Triangle& t : mesh.triangles) {
        const std::array<OnScreen, 3> corners{projected[t[0]], projected[t[1]], projected[t[2]]};
        Interval x, y;
        for (const OnScreen& corner : corners)
            if (corner.in_front()) {
                x.add(corner.x);
                y.add(corner.y);
            }
        const double rectangle = x.length() * y.length();
        const double shown = x.within(half_width).length() * y.within(half_height).length();
        if (!(shown > 0.0)) continue;
        sum.extent_px += std::sqrt(shown);
        const bool is_whole = corners[0].in_front() && corners[1].in_front() && corners[2].in_front();
        // One that reaches behind the eye is taken to fill half of the rectangle that is told.
        const double all = is_whole ? area(corners[0], corners[1], corners[2]) : 0.5 * rectangle;
        covered_px += all * shown / rectangle;
        if (is_whole) raster.draw(corners, samples);
    }
    // A share, since small triangles meet samples by chance.
    sum.shaded_px = covered_px * (samples.covered > 0.0 ? samples.shaded / samples.covered : 1.0);
    return sum;
}

}  // namespace lodestream::shading
