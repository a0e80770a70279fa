#include <algorithm>
#include <cmath>
#include <limits>

#include "common/codec/level_codec.h"
#include "common/codec/rounding.h"
#include "common/mesh/operations.h"

namespace lodestream::codec {
namespace {

// Draco multiplies and divides by range / 2^bits in single precision; between these its steps are normal numbers.
constexpr float min_range = 1e-31f;
constexpr float max_range = std::numeric_limits<float>::max();

// A coordinate is at most two to this many times its lattice's step.
constexpr int lattice_bits = 22;
constexpr double max_window_coordinate = std::numeric_limits<float>::max() / 256.0;

float float_at_most(double x) {
    const float rounded = static_cast<float>(std::clamp<double>(x, -max_range, max_range));
    return rounded > x ? std::nextafter(rounded, -max_range) : rounded;
}

float float_at_least(double x) {
    return -float_at_most(-x);
}

double largest(const Vec3d& v) {
    return std::max({v.x, v.y, v.z});
}

bool positive(double x) {
    return std::isfinite(x) && x > 0.0;
}

// 0 where nothing is known to measure the step by.
double wanted_step(double error, double mean_edge_length) {
    const double by_error = positive(error) ? error / (2.0 * std::sqrt(3.0)) : 0.0;
    if (!positive(mean_edge_length)) return by_error;
    return std::clamp(by_error, mean_edge_length / finest_steps_per_edge, mean_edge_length / coarsest_steps_per_edge);
}

}  // namespace

QuantizationGrid choose_grid(const Box& bounds, double error, double mean_edge_length) {
    QuantizationGrid grid;
    grid.bits = max_position_bits;
    if (bounds.empty() || !all_finite(bounds.min) || !all_finite(bounds.max)) return grid;

    double range = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        grid.origin[axis] = float_at_most(bounds.min[axis]);
        range = std::max(range, bounds.max[axis] - grid.origin[axis]);
    }
    grid.range = std::max(float_at_least(range), min_range);

    const double step = wanted_step(error, mean_edge_length);
    const double steps = static_cast<double>(grid.range) / step;
    if (steps < std::ldexp(1.0, max_position_bits))
        grid.bits =
            std::clamp(static_cast<int>(std::ceil(std::log2(steps + 1.0))), min_position_bits, max_position_bits);
    return grid;
}

QuantizationGrid fit_grid(const Box& bounds, const mesh::Mesh& level, double error) {
    QuantizationGrid grid = choose_grid(bounds, 0.0, 0.0);
    const double allowed = std::hypot(off_surface_share_of_error * (positive(error) ? error : 0.0),
                                      off_surface_share_of_extent * grid.range);
    const double largest_step = mesh::mean_edge_length(level) / steps_per_edge;
    const SurfaceRounding surface(level.positions, level.triangles);
    grid.bits = min_position_bits;
    const auto is_coarse = [&] {
        // Rounding along a surface gains less than three bits on the nearest point, which is off by 0.29 steps.
        return (positive(largest_step) && grid.step() > largest_step) || grid.step() > 30.0 * allowed;
    };
    while (grid.bits < max_position_bits && is_coarse()) ++grid.bits;
    while (grid.bits < max_position_bits) {
        const double off = surface.round(grid).off_surface_rms;
        if (off <= allowed) break;
        // What is off falls about as the step does.
        const double octaves = std::min(std::log2(off / allowed), double{max_position_bits});
        grid.bits = std::min(grid.bits + std::max(1, static_cast<int>(octaves)), max_position_bits);
    }
    return grid;
}

double fit_normal_tolerance_degrees(const mesh::Mesh& level, double error) {
    const double edge = mesh::mean_edge_length(level);
    const double slope = positive(error) && positive(edge) ? std::atan(error / edge) : 0.0;
    return std::clamp(normal_tolerance_per_slope * glm::degrees(slope), least_normal_tolerance_degrees,
                      largest_normal_tolerance_degrees);
}

int fit_normal_bits(double tolerance_degrees) {
    constexpr double around = 180.0;  // degrees that the steps of one coordinate reach over
    return std::clamp(static_cast<int>(std::ceil(std::log2(4.0 * around / tolerance_degrees) - 1e-9)), 4, 10);
}

void fit_normals(EncodeOptions& options, const mesh::Mesh& level, double error) {
    options.normal_tolerance_degrees = fit_normal_tolerance_degrees(level, error);
    options.normal_bits = fit_normal_bits(options.normal_tolerance_degrees);
}

QuantizationGrid choose_window(const Box& bounds, double error, double mean_edge_length) {
    const QuantizationGrid free = choose_grid(bounds, error, mean_edge_length);
    if (bounds.empty() || !all_finite(bounds.min) || !all_finite(bounds.max)) return free;
    const double farthest = largest(glm::max(glm::abs(bounds.min), glm::abs(bounds.max)));
    const double size = std::max<double>(largest(bounds.extent()), min_range);
    if (farthest > max_window_coordinate) return free;

    const double step = wanted_step(error, mean_edge_length);
    int exponent = positive(step) ? std::ilogb(std::min(step, size)) : std::numeric_limits<int>::min();
    // Single precision holds every multiple within the window, and the most bits reach across it.
    exponent = std::max({exponent, std::ilogb(std::max<double>(farthest, min_range)) - lattice_bits,
                         std::ilogb(size) - max_position_bits + 2});

    QuantizationGrid grid;
    const double lattice_step = std::ldexp(1.0, exponent);
    const Vec3d origin = glm::floor(bounds.min / lattice_step) * lattice_step;
    const double steps = std::ceil(largest((bounds.max - origin) / lattice_step));
    grid.origin = Vec3f(origin);
    grid.bits = std::clamp(static_cast<int>(std::ceil(std::log2(steps + 1.0))), min_position_bits, max_position_bits);
    grid.range = static_cast<float>(lattice_step * (std::ldexp(1.0, grid.bits) - 1.0));
    return grid;
}

}  // namespace lodestream::codec
