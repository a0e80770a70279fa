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
#include "server/store/store.h"

namespace lodestream::bake {

inline constexpr double ladder_ratio = 0.5;        // triangles of a rung over the rung above
inline constexpr std::uint64_t ladder_floor = 64;  // triangles; no rung below
inline constexpr std::size_t max_ladder_levels = 24;

struct BakeOptions {
    std::function<bool(double)> progress;  // share done in [0,1]; returning false cancels
};

// Bakes `model` as the asset `asset.id`, which the store must not know as ready. Stores the baked model and every rung,
// and writes the asset as `ready` in the end. Returns the asset as stored. Errors: those of its stages; the asset is
// left `failed`.
Result<proto::Asset> bake(store::Store& store, proto::Asset asset, mesh::Model model, const BakeOptions& options = {});

inline std::string ladder_key(std::uint64_t triangles) {
    return "ladder/" + std::to_string(triangles);
}
inline constexpr std::string_view baked_key = "bake";  // of the baked model among an asset's content

// The asset's one grid, with as many bits as this level's error deserves. `grid_bounds`: of all of the asset's levels.
codec::QuantizationGrid level_grid(const Box& grid_bounds, const mesh::Mesh& level, const metric::SurfaceError& error);
double mean_edge_length(const mesh::Mesh& mesh);
double percent_of_diagonal(double error, const Box& bounds);  // 0 for an empty box
std::string content_url(const std::string& hash);

// Ids are the names made safe for a URL: lower-case letters, digits, '-', '_' and '.', at most max_name_length.
inline constexpr std::size_t max_name_length = 128;
Result<std::string> asset_id(std::string_view name);

}  // namespace lodestream::bake
