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

// fit_grid(): the first step it tries, about what turns out to be right; a grid that uses this much of what it may; and
// how often it tries.
constexpr double first_step_of_allowed = 10.0, near_enough = 0.94;
constexpr int most_fitting_turns = 8;

// The same place in steps of this length, but no finer than it is. pre: step > 0
QuantizationGrid with_step(const QuantizationGrid& finest, double step) {
    const double steps = std::ceil(finest.range / step);
    if (!(steps < std::ldexp(1.0, max_position_bits) - 1.0)) return finest;
    QuantizationGrid grid = finest;
    grid.bits = std::max(static_cast<int>(std::ceil(std::log2(steps + 1.0))), min_position_bits);
    const double range = step * (std::ldexp(1.0, grid.bits) - 1.0);
    if (range < max_range) grid.range = std::max(static_cast<float>(range), finest.range);
    return grid;
}

// Of the vertices with normals, the share of those whose normal is farther off the mean of their triangles' than this.
double share_of_told_normals(const mesh::Mesh& level, double tolerance_degrees) {
    if (level.normals.size() != level.positions.size()) return 0.0;
    std::vector<Vec3d> sums(level.positions.size(), Vec3d{0.0});
    for (const mesh::Triangle& t : level.triangles) {
        const Vec3d a(level.positions[t[0]]);
        const Vec3d area = cross(Vec3d(level.positions[t[1]]) - a, Vec3d(level.positions[t[2]]) - a);
        for (const std::uint32_t v : t) sums[v] += area;
    }
    const double least_cosine = std::cos(radians(tolerance_degrees));
    std::size_t told = 0;
    for (std::size_t v = 0; v < sums.size(); ++v) {
        const Vec3d normal(level.normals[v]);
        told += dot(sums[v], normal) < least_cosine * length(sums[v]) * length(normal) ? 1 : 0;
    }
    return static_cast<double>(told) / static_cast<double>(std::max<std::size_t>(sums.size(), 1));
}

// Of normals that may be off by this much.
bool most_are_told(const mesh::Mesh& level, double tolerance_degrees) {
    return share_of_told_normals(level, std::max(tolerance_degrees, told_normal_degrees)) > most_told_normals;
}

double share_of_extent(bool faithful, bool lean) {
    if (lean) return faithful ? lean_faithful_off_surface_share_of_extent : lean_off_surface_share_of_extent;
    return faithful ? faithful_off_surface_share_of_extent : off_surface_share_of_extent;
}

// 0 where nothing is known to measure the step by.
double wanted_step(double error, double mean_edge_length) {
    const double by_error = positive(error) ? error / (2.0 * std::sqrt(3.0)) : 0.0;
    if (!positive(mean_edge_length)) return by_error;
    return std::clamp(by_error, mean_edge_length / finest_steps_per_edge, mean_edge_length / coarsest_steps_per_edge);
}

QuantizationGrid grid_of_step(const Box& bounds, double step) {
    QuantizationGrid grid;
    grid.bits = max_position_bits;
    if (bounds.empty() || !all_finite(bounds.min) || !all_finite(bounds.max)) return grid;

    double range = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        grid.origin[axis] = float_at_most(bounds.min[axis]);
        range = std::max(range, bounds.max[axis] - grid.origin[axis]);
    }
    grid.range = std::max(float_at_least(range), min_range);

    const double steps = static_cast<double>(grid.range) / step;
    if (steps < std::ldexp(1.0, max_position_bits))
        grid.bits =
            std::clamp(static_cast<int>(std::ceil(std::log2(steps + 1.0))), min_position_bits, max_position_bits);
    return grid;
}

}  // namespace

QuantizationGrid choose_grid(const Box& bounds, double error, double mean_edge_length) {
    return grid_of_step(bounds, wanted_step(error, mean_edge_length));
}

bool is_faithful(const mesh::Mesh& level, double normal_error_degrees) {
    return normal_error_degrees < faithful_normal_error_degrees && !most_are_told(level, 0.0);
}

QuantizationGrid fit_grid(const Box& bounds, const mesh::Mesh& level, double error, double normal_error_degrees,
                          bool lean) {
    const QuantizationGrid finest = choose_grid(bounds, 0.0, 0.0);
    const double share_of_error = lean ? lean_off_surface_share_of_error : off_surface_share_of_error;
    const double allowed = std::hypot(share_of_error * (positive(error) ? error : 0.0),
                                      share_of_extent(is_faithful(level, normal_error_degrees), lean) * finest.range);
    // Rounding along a surface gains less than three bits on the nearest point, which is off by 0.29 steps.
    double largest = std::min(30.0 * allowed, finest.range / (std::ldexp(1.0, min_position_bits) - 1.0));
    if (const double edge = mesh::mean_edge_length(level); positive(edge))
        largest = std::min(largest, edge / steps_per_edge);
    const SurfaceRounding surface(level.positions, level.triangles);
    QuantizationGrid best = finest;
    double step = std::min(largest, first_step_of_allowed * allowed);
    for (int turn = 0; turn < most_fitting_turns && step > best.step(); ++turn) {
        const QuantizationGrid grid = with_step(finest, step);
        const double off = surface.round(grid).off_surface_rms;
        if (off <= allowed) best = grid;
        if (off <= allowed && (off >= near_enough * allowed || step == largest)) break;
        // What is off falls about as the step does.
        step = off > 0.0 ? std::min(step * (1.0 + near_enough) / 2.0 * allowed / off, largest) : largest;
    }
    return best;
}

double fit_normal_tolerance_degrees(double normal_error_degrees, bool lean) {
    const double share =
        (lean ? lean_normal_tolerance_share_of_error : normal_tolerance_share_of_error) * normal_error_degrees;
    const double least = lean ? least_lean_normal_tolerance_degrees : least_normal_tolerance_degrees;
    return positive(share) ? std::clamp(share, least, largest_normal_tolerance_degrees) : least;
}

int fit_normal_bits(double tolerance_degrees, bool most_are_told) {
    constexpr double around = 180.0;  // degrees that the steps of one coordinate reach over
    const int bits =
        static_cast<int>(std::ceil(std::log2(normal_steps_per_tolerance * around / tolerance_degrees) - 1e-9));
    return std::clamp(bits, 4, most_are_told ? most_told_normal_bits : most_normal_bits);
}

void fit_normals(EncodeOptions& options, const mesh::Mesh& level, double normal_error_degrees) {
    const double tolerance = fit_normal_tolerance_degrees(normal_error_degrees, options.lean);
    options.normal_tolerance_degrees = tolerance;
    options.normal_bits = fit_normal_bits(tolerance, most_are_told(level, tolerance));
}

QuantizationGrid choose_window(const Box& bounds, double error, double mean_edge_length) {
    return window_of_step(bounds, wanted_step(error, mean_edge_length));
}

QuantizationGrid window_of_step(const Box& bounds, double step) {
    const QuantizationGrid free = grid_of_step(bounds, step);
    if (bounds.empty() || !all_finite(bounds.min) || !all_finite(bounds.max)) return free;
    const double farthest = largest(glm::max(glm::abs(bounds.min), glm::abs(bounds.max)));
    const double size = std::max<double>(largest(bounds.extent()), min_range);
    if (farthest > max_window_coordinate) return free;

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
