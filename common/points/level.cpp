#include "common/points/level.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lodestream::points {

namespace {

// Of a disc's radius: the points keep their distance within a tenth, and those that order() chose from, which none of
// the surface is farther from than that, are themselves apart.
constexpr double covering = 1.1, covering_choice = 0.25;

// Where the cloud is used up, its last points are as near to others as any two happen to be, which says nothing of the
// gaps between the rest. So a half and a quarter of the points tell too: on a surface, twice as many are closer by
// the square root of two.
double spacing_of(const std::vector<float>& spacings, std::uint64_t points) {
    double spacing = spacings[points - 1];
    for (const std::uint64_t part : {2, 4})
        spacing = std::max(spacing, spacings[(points - 1) / part] / std::sqrt(static_cast<double>(part)));
    return spacing;
}

double radius_of(const std::vector<float>& spacings, std::uint64_t points) {
    return covering * spacing_of(spacings, points) + covering_choice * spacing_of(spacings, spacings.size());
}

}  // namespace

mesh::Mesh as_mesh(const PointCloud& cloud) {
    mesh::Mesh mesh;
    mesh.positions = cloud.positions;
    mesh.triangles.reserve(cloud.positions.size());
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) mesh.triangles.push_back({v, v, v});
    return mesh;
}

PointCloud prefix(const PointCloud& cloud, std::uint64_t count) {
    const auto first = [&](const auto& all) {
        const auto taken = static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(count, all.size()));
        return std::vector(all.begin(), all.begin() + taken);
    };
    return {first(cloud.positions), first(cloud.normals), first(cloud.colors)};
}

metric::SurfaceError measure(const metric::SurfaceIndex& original, const mesh::Mesh& mesh, const PointCloud& cloud,
                             std::uint64_t count) {
    return metric::measure(original, mesh, as_mesh(prefix({cloud.positions, {}, {}}, count)));
}

std::vector<Level> measured_levels(const metric::SurfaceIndex& original, const mesh::Mesh& mesh,
                                   const OrderedCloud& ordered, const simplify::Executor& executor) {
    std::vector<Level> levels;
    for (std::uint64_t points = ordered.cloud.positions.size(); points > 0; points /= 2) {
        levels.push_back({points, {}, radius_of(ordered.spacings, points)});
        if (points / 2 < fewest_measured) break;
    }
    if (!levels.empty() && levels.back().points > 1) levels.push_back({1, {}, radius_of(ordered.spacings, 1)});
    simplify::run(executor, levels.size(),
                  [&](std::size_t k) { levels[k].error = measure(original, mesh, ordered.cloud, levels[k].points); });
    for (std::size_t k = 1; k < levels.size(); ++k) {
        levels[k].error.rms = std::max(levels[k].error.rms, levels[k - 1].error.rms);
        levels[k].error.max = std::max(levels[k].error.max, levels[k - 1].error.max);
    }
    return levels;
}

Level level_of(std::span<const Level> levels, std::uint64_t count) {
    const std::uint64_t points = std::min(count, levels.front().points);
    const auto coarser =
        std::find_if(levels.begin(), levels.end(), [&](const Level& level) { return level.points <= points; });
    Level level = coarser == levels.end() ? levels.back() : *coarser;
    if (level.points == points || points == 0) return {points, level.error, level.radius};
    const Level& finer = *(coarser - 1);
    level.points = points;
    const double thinned = std::sqrt(static_cast<double>(finer.points) / static_cast<double>(points));
    const double coarsest = coarser == levels.end() ? std::numeric_limits<double>::infinity() : coarser->radius;
    level.radius = std::min(finer.radius * thinned, coarsest);
    return level;
}

std::uint64_t points_for(std::span<const Level> levels, double radius) {
    std::uint64_t low = levels.back().points, high = levels.front().points;
    while (low < high) {
        const std::uint64_t middle = low + (high - low) / 2;
        if (level_of(levels, middle).radius <= radius)
            high = middle;
        else
            low = middle + 1;
    }
    return high;
}

std::uint64_t points_worth_drawing(std::span<const Level> levels, double px_per_unit, double sphere_radius) {
    return points_for(levels, std::min(least_disc_px / px_per_unit, least_disc_share * sphere_radius));
}

}  // namespace lodestream::points
