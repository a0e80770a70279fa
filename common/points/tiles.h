// An ordered cloud as a tree of tiles that add to each other, as viewers of large clouds load them.
#pragma once

#include <cstdint>
#include <vector>

#include "common/points/point_cloud.h"

namespace lodestream::points {

inline constexpr std::uint32_t points_per_tile = 16'384;
inline constexpr std::uint32_t max_tile_depth = 48;  // a tile so deep has all of its place's points
inline constexpr std::uint32_t no_tile = 0xffffffffu;

struct Tile {
    std::vector<std::uint32_t> points;  // of the cloud, in its order
    Box box;                            // of its own points and those of all below
    std::uint64_t shown = 0;  // with those above it shows its box as the cloud's first so many do; a leaf: all of them
    std::uint32_t parent = no_tile, first_child = 0, child_count = 0;
};

// The first points_per_tile points of a box are its tile, the others those of its octants: each point is in one tile,
// and as the cloud's order is even everywhere, so is each tile's part of it. The root first, children side by side and
// after their parent; empty for an empty cloud. pre: positions finite
std::vector<Tile> tiles_of(const PointCloud& cloud);

// The points of one.
PointCloud points_of(const PointCloud& cloud, const Tile& tile);

}  // namespace lodestream::points
