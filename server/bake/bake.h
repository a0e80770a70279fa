// Baking: a model becomes a collapse history and a ladder of encoded levels, each with its measured error.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/codec/level_codec.h"
#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"
#include "proto/messages.h"
#include "server/bake/baked_model.h"
#include "server/bake/limits.h"
#include "server/store/store.h"

namespace lodestream::bake {

inline constexpr double ladder_ratio = 0.5;        // triangles of a rung over the rung above
inline constexpr std::uint64_t ladder_floor = 64;  // triangles; no rung below
inline constexpr std::size_t max_ladder_levels = 24;

struct BakeOptions {
    std::function<bool(double)> progress;  // share done in [0,1]; returning false cancels
    std::function<bool()> pause;           // true: stop now, the asset stays `baking` and is gone on with later
    Limits limits;
};

// Nothing to bake: no triangles, or no points in a cloud.
bool is_empty(const mesh::Model& model);

// A bake has two parts, so that it survives a crash and a first level can be served before it is done.
// 1. Writes `asset` as `baking` with the model's figures, keeps the model in the store until the bake is done, and
// makes
//    the asset's textures and first levels (first_levels.h). The store must not know the asset as ready. Errors:
//    invalid_input (no triangles), limit_exceeded (memory): nothing is kept; those of the codec and the store.
Result<proto::Asset> prepare(store::Store& store, proto::Asset asset, const mesh::Model& model,
                             const Limits& limits = {});
// 2. Bakes a prepared asset. Stores the baked model and every rung, and writes the asset as `ready` in the end. Returns
//    the asset as stored. Errors: unavailable (cancelled or paused), limit_exceeded (time, memory), those of its
//    stages; the asset is left `failed` unless it was paused.
Result<proto::Asset> bake_prepared(store::Store& store, const std::string& asset_id, const BakeOptions& options = {});
// Both.
Result<proto::Asset> bake(store::Store& store, proto::Asset asset, mesh::Model model, const BakeOptions& options = {});

// The assets whose bake was cut off by the end of the program and is to be gone on with. One whose bake has ended the
// program max_bake_starts times is marked `failed` instead. To be called once after the store was opened.
Result<std::vector<std::string>> recover(store::Store& store);

inline std::string ladder_key(std::uint64_t triangles) {
    return "ladder/" + std::to_string(triangles);
}
inline constexpr std::string_view baked_key = "bake";  // of the baked model among an asset's content
using store::imported_key;                             // of the imported model, until the bake is done; its record
                                                       // counts the bakes that were started and not ended

// The asset's one grid with as many bits, and normals as close, as this level's error deserves. `grid_bounds`: of all
// of the asset's levels.
codec::EncodeOptions level_options(const Box& grid_bounds, const mesh::Mesh& level, const metric::SurfaceError& error,
                                   bool lean = false);
// What an asset tells of an encoded level.
proto::Level described_level(const codec::Encoded& encoded, const metric::SurfaceError& error, const Box& bounds,
                             double encode_ms, const std::string& hash);
double percent_of_diagonal(double error, const Box& bounds);  // 0 for an empty box
std::string content_url(const std::string& hash);

// Ids are the names made safe for a URL: lower-case letters, digits, '-', '_' and '.', at most max_name_length.
inline constexpr std::size_t max_name_length = 128;
Result<std::string> asset_id(std::string_view name);

}  // namespace lodestream::bake
