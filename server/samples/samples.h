// Models built in, so that the demo downloads nothing. All are deterministic functions of their parameters.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::samples {

inline constexpr std::uint64_t teapot_triangles = 6'400;      // hybrid-rendering paper §4: 32 patches * 10 * 10 * 2
inline constexpr std::uint64_t terrain_vertices = 4'320'857;  // ISBLC paper: 10 m grid
inline constexpr double terrain_spacing_m = 10.0;
inline constexpr std::uint64_t ship_objects = 3'000;

inline constexpr std::uint64_t min_teapot_triangles = 128;  // fewer leave no tube for handle and spout
inline constexpr std::uint64_t min_terrain_vertices = 3;
inline constexpr std::uint64_t min_ship_objects = 1;  // the hull
inline constexpr std::uint64_t max_sample_triangles = 20'000'000;
inline constexpr std::uint64_t max_terrain_vertices = max_sample_triangles / 2;
inline constexpr std::uint64_t max_ship_objects = 126'630;  // HLOD paper's ship

// Errors of all three: invalid_input (fewer than the least), limit_exceeded (more than the most).

// The Utah teapot from its 32 bicubic Bézier patches; 2 m wide, centred, y up, exactly `triangles` of them, none
// degenerate. Patches share them out as evenly as grids allow; rows of unequal length are stitched without cracks.
Result<mesh::Model> teapot(std::uint64_t triangles = teapot_triangles);

// Seeded ridged fractal hills on a 10 m grid of about square shape, exactly `vertices` of them; y up, heights in 0 …
// 1500 m.
Result<mesh::Model> terrain(std::uint64_t vertices = terrain_vertices, std::uint64_t seed = 1);

// A seeded cargo ship of exactly `objects` objects: hull, decks, bridge, cranes, containers, pipes, railings, bollards.
// Metres, y up, bow towards +x, waterline at y = 0. With fewer objects, the ship is smaller and the most telling come
// first.
Result<mesh::Model> ship(std::uint64_t objects = ship_objects, std::uint64_t seed = 1);

// The same ship with some 640 triangles an object instead of 105: gear and containers are instances of 16 shapes. Of
// max_ship_objects it has 80 million triangles, instances counted.
Result<mesh::Model> fine_ship(std::uint64_t objects = max_ship_objects, std::uint64_t seed = 1);

// "teapot", "teapot:800", "terrain:40000", "ship:500", "fine-ship:126630": name and count. Errors name what is allowed.
Result<mesh::Model> make_sample(std::string_view spec);

}  // namespace lodestream::samples
