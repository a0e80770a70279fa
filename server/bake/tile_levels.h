// How the levels of a tile are made: cut from what is seen of its geometry, measured, encoded. The bake of a scene and
// the change of one (server/live) make theirs alike.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/base/result.h"
#include "common/codec/level_codec.h"
#include "common/metric/surface_distance.h"
#include "common/simplify/history.h"
#include "server/bake/scene_colors.h"
#include "server/bake/seen_surface.h"

namespace lodestream::bake {

inline constexpr std::uint64_t tile_triangles = 7'680;  // of a tile that has tiles below it, at most
inline constexpr double tile_ratio = 0.5;               // of its triangles to those of the tiles below, at most
inline constexpr double chain_ratio = 0.5;              // between levels of one object and above the whole scene
inline constexpr std::uint64_t coarsest_tile = 240;     // triangles; the root has no fewer, where the scene has as many

// Counts behind those that are there: they fall from one of `triangles` until they are not above `end`.
void add_chain(std::vector<std::uint64_t>& counts, std::uint64_t triangles, std::uint64_t end);

// Of the tile above tiles of so many triangles together, and of those above that where it is the root.
std::vector<std::uint64_t> tile_counts(std::uint64_t triangles_below, bool is_root);

struct TileLevel {
    Surface surface;
    metric::SurfaceError error;  // against what is seen
};

// A level of each of these counts, the finest first, each from the surface that shows that count best. One that would
// have no fewer triangles than the one before, or than `fewer_than`, is left out. Errors: unavailable (`progress`
// returned false), those of recording.
Result<std::vector<TileLevel>> cut_levels(SeenSurface seen, const std::vector<std::uint64_t>& counts,
                                          std::uint64_t fewer_than, const simplify::Executor& executor,
                                          const std::function<bool()>& progress);

// On the lattice of the scene's axes that the error deserves.
codec::QuantizationGrid tile_grid(const mesh::Mesh& mesh, const metric::SurfaceError& error);

// What a tile that was cut is off by more, beside its source: the rounding onto its grid.
double rounding_error(const codec::QuantizationGrid& grid);

// `grid`: tile_grid() or, of a finest tile, TileBorders'. `model`: materials, images and origin. A bare surface is
// painted with `colors`. pre: colors where it is bare
Result<codec::Encoded> encode_tile(const Surface& surface, const metric::SurfaceError& error,
                                   const codec::QuantizationGrid& grid, const mesh::Model& model,
                                   std::vector<codec::SmallerImage> images, const SceneColors* colors);

}  // namespace lodestream::bake
