#include "common/points/tiles.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace lodestream::points {

namespace {

// What is still to become the tile of this number, and those below it.
struct Pending {
    std::uint32_t tile = 0, depth = 0;
    std::vector<std::uint32_t> points;  // in the cloud's order
};

using Octants = std::array<std::vector<std::uint32_t>, 8>;

// By the middle of their box, so that points that differ are parted.
Octants octants_of(const PointCloud& cloud, const std::vector<std::uint32_t>& points, std::size_t first) {
    Box box;
    for (std::size_t i = first; i < points.size(); ++i) box.add(Vec3d(cloud.positions[points[i]]));
    const Vec3d middle = box.center();
    Octants octants;
    for (std::size_t i = first; i < points.size(); ++i) {
        const Vec3d p(cloud.positions[points[i]]);
        const unsigned octant = (p.x > middle.x ? 1u : 0u) | (p.y > middle.y ? 2u : 0u) | (p.z > middle.z ? 4u : 0u);
        octants[octant].push_back(points[i]);
    }
    return octants;
}

void add_boxes(const PointCloud& cloud, std::vector<Tile>& tiles) {
    for (std::size_t i = tiles.size(); i-- > 0;) {
        for (const std::uint32_t point : tiles[i].points) tiles[i].box.add(Vec3d(cloud.positions[point]));
        if (tiles[i].parent == no_tile) continue;
        tiles[tiles[i].parent].box.add(tiles[i].box.min);
        tiles[tiles[i].parent].box.add(tiles[i].box.max);
    }
}

template <class Value>
std::vector<Value> chosen(const std::vector<Value>& values, const std::vector<std::uint32_t>& points) {
    std::vector<Value> some;
    if (values.empty()) return some;
    some.reserve(points.size());
    for (const std::uint32_t point : points) some.push_back(values[point]);
    return some;
}

}  // namespace

std::vector<Tile> tiles_of(const PointCloud& cloud) {
    std::vector<Tile> tiles;
    if (cloud.positions.empty()) return tiles;
    std::vector<Pending> pending(1);
    pending[0].points.resize(cloud.positions.size());
    std::iota(pending[0].points.begin(), pending[0].points.end(), 0u);
    tiles.emplace_back();
    for (std::size_t next = 0; next < pending.size(); ++next) {
        const Pending place = std::move(pending[next]);
        const bool is_leaf = place.points.size() <= points_per_tile || place.depth == max_tile_depth;
        const std::size_t own = is_leaf ? place.points.size() : points_per_tile;
        Tile& tile = tiles[place.tile];
        tile.points.assign(place.points.begin(), place.points.begin() + static_cast<std::ptrdiff_t>(own));
        tile.shown = is_leaf ? cloud.positions.size() : std::uint64_t{tile.points.back()} + 1;
        if (is_leaf) continue;
        tile.first_child = static_cast<std::uint32_t>(tiles.size());
        for (std::vector<std::uint32_t>& octant : octants_of(cloud, place.points, own)) {
            if (octant.empty()) continue;
            const auto child = static_cast<std::uint32_t>(tiles.size());
            ++tiles[place.tile].child_count;
            tiles.emplace_back().parent = place.tile;
            pending.push_back({child, place.depth + 1, std::move(octant)});
        }
    }
    add_boxes(cloud, tiles);
    return tiles;
}

PointCloud points_of(const PointCloud& cloud, const Tile& tile) {
    return {chosen(cloud.positions, tile.points), chosen(cloud.normals, tile.points),
            chosen(cloud.colors, tile.points)};
}

}  // namespace lodestream::points
