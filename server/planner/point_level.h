// The other half of a plan: the asset's points instead of its triangles, and which of the two serves better.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/budget/budget.h"
#include "common/codec/points_codec.h"
#include "common/shading/view.h"
#include "proto/messages.h"
#include "server/store/store.h"

namespace lodestream::planner {

inline constexpr double invisible_px = 1.0 / 32.0;  // errors below are not told apart
// Discs of half a pixel across cover a picture's pixels one by one; smaller ones would add nothing.
inline constexpr double smallest_disc_px = 0.25;  // radius
// The RMS distance, over the radius of a level's discs, of the level of triangles whose picture errs as much. Measured
// by lodestream_bench_points --share: 0.5 with discs of 65 px, 0.3 with 30 px, 0.13 with 7 px.
inline constexpr double shown_share_of_radius = 0.25;

struct PointLevel {
    codec::Points points;  // all of the asset's
    budget::PointBudget budget;
    proto::Profile profile = proto::Profile::plain;
    std::uint64_t bytes = 0;  // of that level: plain ones at most, lean ones about
    double error_px = 0.0;    // what the level of that budget shows, in the view
};

// Errors: not_found (the asset has no points), those of reading and decoding, invalid_input.
Result<PointLevel> plan_points(const store::Store& store, const proto::Asset& asset, const proto::PlanRequest& request,
                               double pixels_per_unit);

// One level of triangles beside one of points, as seen from `distance` of the bounding sphere's centre.
struct Rivals {
    double triangles_px = 0.0, points_px = 0.0;  // errors shown
    std::uint64_t triangles_bytes = 0, points_bytes = 0;
    double distance = 0.0, radius = 0.0;  // model units; of the sphere
};
// Less error shown wins; where neither shows any, fewer bytes.
bool points_win(const Rivals& rivals);
// The distance from which on points win with these two levels: none where they never do, 0 where they always do.
std::optional<double> crossing_distance(const Rivals& rivals);

// Encodes and stores the level, unless the store has it; fills level, shading (but for the distance), content and what
// the budget says of points.
Status add_points(proto::PlanResponse& response, store::Store& store, const std::string& asset_id,
                  const PointLevel& level, double pixels_per_unit);

}  // namespace lodestream::planner
