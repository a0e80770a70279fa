// An asset's point cloud in the store: resampled and ordered once in the bake, so that any prefix of it is a level.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/codec/points_codec.h"
#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"
#include "common/simplify/history.h"
#include "server/store/store.h"

namespace lodestream::bake {

// A point for each triangle, within these: below, a mesh is as cheap; above, no weak device draws them.
inline constexpr std::uint64_t min_baked_points = 1'000;
inline constexpr std::uint64_t max_baked_points = 300'000;
inline constexpr std::string_view points_key = "points";  // among an asset's content
inline constexpr std::uint64_t max_points_bytes = 1ull << 30;

// What an asset is resampled from.
struct PointsSource {
    const mesh::Model& model;                        // materials, images and origin
    const mesh::Mesh& finest;                        // its finest level
    const metric::SurfaceIndex& original;            // of that
    metric::SurfaceError off{};                      // what that is off itself
    const simplify::HistoryView* history = nullptr;  // of the finest: to weigh points against its cuts; null: not
};

// Makes, measures, encodes and stores them, and what they and the model's cuts show of their errors. `progress` is told
// the share done, from any thread, and returns false to cancel. Errors: unavailable (cancelled), those of the codec and
// the store.
Status make_points(store::Store& store, const std::string& asset_id, const PointsSource& source,
                   const std::function<bool(double)>& progress);

// Likewise of a model that is a cloud itself (mesh::Kind::points): ordered, its finest max_cloud_points, measured
// against all of them, and stored as tiles too (points::tiles_of), whose errors are the radii of the discs that they
// need.
inline constexpr std::uint64_t max_cloud_points = 4'000'000;
Status make_cloud_points(store::Store& store, const std::string& asset_id, const mesh::Model& model,
                         const std::function<bool(double)>& progress);

// Errors: not_found (the asset has none), those of reading and decoding.
Result<codec::Points> load_points(const store::Store& store, const std::string& asset_id);

// The level of at most `count` points as one that stands for itself: its own measured levels begin with it.
codec::Points cut_points(const codec::Points& points, std::uint64_t count);

}  // namespace lodestream::bake
