#include "tests/client/render/terrain_views.h"

#include <cmath>
#include <numbers>

namespace lodestream::render {

namespace {

constexpr std::uint32_t width = 192, height = 128;
constexpr double fov_y_deg = 98.2;  // 120 degrees across
constexpr double border = 0.05;     // of the extent
const Vec3f sky{1.0f, 0.0f, 1.0f};
constexpr std::uint8_t most_green = 8, least_red_and_blue = 248;

bool is_sky(const Image& image, std::uint32_t x, std::uint32_t y) {
    const std::uint8_t* pixel = &image.rgba[4 * (std::size_t{y} * image.width + x)];
    return pixel[0] >= least_red_and_blue && pixel[1] < most_green && pixel[2] >= least_red_and_blue;
}

}  // namespace

DrawOptions terrain_picture() {
    DrawOptions options;
    options.width = width;
    options.height = height;
    options.samples = 1;
    options.background = sky;
    return options;
}

shading::View any_terrain_view(const Vec3d& ground, std::mt19937& random) {
    std::uniform_real_distribution<double> share;
    const double above = std::pow(10.0, 1.0 + 2.0 * share(random));  // m
    const double heading = std::numbers::pi * (2.0 * share(random) - 1.0);
    const double pitch = std::numbers::pi * (share(random) - 0.5);
    shading::View view;
    view.eye = ground + Vec3d(0.0, above, 0.0);
    view.target = view.eye + 100.0 * Vec3d(std::cos(pitch) * std::cos(heading), std::sin(pitch),
                                           std::cos(pitch) * std::sin(heading));
    view.fov_y_deg = fov_y_deg;
    return view;
}

std::size_t cracks(const Image& image, const shading::View& view, const Box& bounds) {
    const Vec3d forward = normalize(view.target - view.eye);
    const Vec3d right = normalize(cross(forward, Vec3d(0.0, 1.0, 0.0))), up = cross(right, forward);
    const double tan_y = std::tan(0.5 * radians(view.fov_y_deg)), tan_x = tan_y * width / height;
    const Vec3d margin = border * bounds.extent();
    std::size_t count = 0;
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            const Vec3d along = forward + (2.0 * (x + 0.5) / width - 1.0) * tan_x * right +
                                (1.0 - 2.0 * (y + 0.5) / height) * tan_y * up;
            if (!(along.y < 0.0)) continue;
            const Vec3d lowest = view.eye + (bounds.min.y - view.eye.y) / along.y * along;
            const bool is_within = lowest.x > bounds.min.x + margin.x && lowest.x < bounds.max.x - margin.x &&
                                   lowest.z > bounds.min.z + margin.z && lowest.z < bounds.max.z - margin.z;
            count += is_within && is_sky(image, x, y) ? 1 : 0;
        }
    return count;
}

bool looks_at_ground(const Image& image) {
    return !is_sky(image, image.width / 2, image.height - 1);
}

}  // namespace lodestream::render
