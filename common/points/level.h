// What is known of a level, a prefix of an ordered cloud.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"
#include "common/points/order.h"
#include "common/simplify/executor.h"

namespace lodestream::points {

struct Level {
    std::uint64_t points = 0;
    metric::SurfaceError error;  // measured between its points and the mesh, both ways
    double radius = 0.0;         // of the discs that leave no hole between them, model units
};

// The mesh that has a point wherever the cloud has one: triangles without area, which the metric measures as points.
mesh::Mesh as_mesh(const PointCloud& cloud);

inline constexpr std::uint64_t fewest_measured = 64;  // points

// Two-sided distance between the first `count` points and the mesh. Without points or triangles as metric::measure().
metric::SurfaceError measure(const metric::SurfaceIndex& original, const mesh::Mesh& mesh, const PointCloud& cloud,
                             std::uint64_t count);

// The whole cloud, its halves down to fewest_measured and its first point, finest first, each measured. A coarser level
// is never said to be better. Empty for an empty cloud.
std::vector<Level> measured_levels(const metric::SurfaceIndex& original, const mesh::Mesh& mesh,
                                   const OrderedCloud& ordered, const simplify::Executor& executor = {});

// A level of `count` points: it has the error of the measured one that is not finer, and the radius that its points'
// own distance gives, at most that one's. At most as many points as there are. pre: levels as from measured_levels, not
// empty
Level level_of(std::span<const Level> levels, std::uint64_t count);

// The fewest points, of the levels from the coarsest to the finest, whose discs have at most that radius; the finest
// where none do. pre: likewise
std::uint64_t points_for(std::span<const Level> levels, double radius);

// In a picture no more points of a cloud are worth drawing than make discs of this radius, or of that share of the
// sphere around its box where that is less, so that what is small keeps its shape. With discs of 0.8 px a crowd of
// scans takes 1.6 times as long, and its picture's error falls by a seventh.
inline constexpr double least_disc_px = 1.25;
inline constexpr double least_disc_share = 1.0 / 24.0;

// So many. `sphere_radius` in model units. pre: likewise
std::uint64_t points_worth_drawing(std::span<const Level> levels, double px_per_unit, double sphere_radius);

}  // namespace lodestream::points
