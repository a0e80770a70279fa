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
#include "server/bake/shown_errors.h"
#include "server/store/store.h"

namespace lodestream::planner {

// Discs of half a pixel across cover a picture's pixels one by one; smaller ones would add nothing.
inline constexpr double smallest_disc_px = 0.25;  // radius

struct PointLevel {
    codec::Points points;  // all of the asset's
    budget::PointBudget budget;
    proto::Profile profile = proto::Profile::plain;
    std::uint64_t bytes = 0;  // of that level: plain ones at most, lean ones about
};

// Where an asset is seen from.
struct Sight {
    double pixels_per_unit = 0.0;  // at the nearest point of its bounding sphere
    double distance = 0.0;         // of the sphere's centre, model units
    double radius = 0.0;           // of the sphere, likewise
};

// Errors: not_found (the asset has no points), those of reading and decoding, invalid_input.
Result<PointLevel> plan_points(const store::Store& store, const proto::Asset& asset, const proto::PlanRequest& request,
                               const Sight& sight);

// What a level of triangles shows of its error in pictures, so many of them Gouraud and the rest flat.
double shown_error(const bake::ShownErrors& errors, std::uint64_t gouraud, std::uint64_t flat);

// Points against that, where they win from close by: fewer of them are worth drawing the farther away they are. None
// where points never win with these two levels.
std::optional<proto::Crossing> crossing_of(const PointLevel& level, const bake::ShownErrors& errors,
                                           double triangles_error, const Sight& sight);
// Of those at hand, in the view at hand.
bool points_win(const proto::Crossing& crossing);

// Encodes and stores the level, unless the store has it; fills level, shading (but for the distance), content and what
// the budget says of points.
Status add_points(proto::PlanResponse& response, store::Store& store, const std::string& asset_id,
                  const PointLevel& level, double pixels_per_unit);

}  // namespace lodestream::planner
