#include "server/planner/point_level.h"

#include <algorithm>
#include <cmath>

#include "common/codec/points_layout.h"
#include "common/points/level.h"
#include "proto/records.h"
#include "server/bake/bake.h"
#include "server/bake/points.h"
#include "server/bake/stopwatch.h"

namespace lodestream::planner {

namespace {

// Of a file of points, at most: its JSON tells of at most 20 measured levels in at most 140 bytes each.
constexpr std::uint64_t header_bytes = 4096;

// Lean points of surfaces take 0.40 to 0.45 of the plain bytes, without colours (lodestream_bench_points --codecs).
constexpr std::uint64_t lean_divisor = 2;
constexpr std::uint64_t fewest_lean_points = 100;  // below, what their JSON has more is more than they save
constexpr int max_network_corrections = 4;

std::uint64_t bytes_per_point(const points::PointCloud& cloud, proto::Profile profile) {
    const codec::PointLayout plain{!cloud.normals.empty(), !cloud.colors.empty()};
    return plain.stride() / (profile == proto::Profile::lean ? lean_divisor : 1);
}

Box bounds_of(const points::PointCloud& cloud) {
    Box box;
    for (const Vec3f& p : cloud.positions) box.add(Vec3d(p));
    return box;
}

Result<std::vector<std::byte>> encoded(const codec::Points& level, proto::Profile profile) {
    if (profile == proto::Profile::lean) return codec::encode_lean_points(level);
    Result<codec::EncodedPoints> plain = codec::encode_points(level);
    if (!plain) return plain.error();
    return std::move(plain->glb);
}

struct StoredLevel {
    store::StoredFile file;
    proto::Profile profile = proto::Profile::plain;
    double encode_ms = 0.0;  // 0: the store had it
};

Result<StoredLevel> stored_level(store::Store& store, const std::string& asset_id, const PointLevel& level,
                                 std::uint64_t count) {
    const proto::Profile profile = count < fewest_lean_points ? proto::Profile::plain : level.profile;
    const std::string key =
        std::string(bake::points_key) + "/" + (profile == proto::Profile::lean ? "lean/" : "") + std::to_string(count);
    if (const Result<store::Store::Content> stored = store.content(asset_id, key); stored)
        return StoredLevel{stored->file, profile, 0.0};
    const bake::Stopwatch encoding;
    const Result<std::vector<std::byte>> glb = encoded(bake::cut_points(level.points, count), profile);
    if (!glb) return glb.error();
    const double encode_ms = encoding.ms();
    Result<store::StoredFile> file = store.put_content(asset_id, key, "glb", *glb);
    if (!file) return file.error();
    return StoredLevel{*std::move(file), profile, encode_ms};
}

constexpr double percent = 100.0;

// Of a cloud that has lost its order, as a lean level has, all are drawn.
std::uint64_t drawn_at(const PointLevel& level, double pixels_per_unit, double radius) {
    const std::uint64_t points = level.budget.points;
    const bool is_ordered = level.profile == proto::Profile::plain || points < fewest_lean_points;
    return is_ordered ? std::min(points, points::points_worth_drawing(level.points.levels, pixels_per_unit, radius))
                      : points;
}

// Up to where points are worth drawing in such a number that their error is below that; none: from anywhere.
std::optional<double> farthest_win(const PointLevel& level, const bake::ShownErrors& errors, double triangles_error,
                                   const Sight& sight) {
    constexpr double far_away = 0.0;  // px per unit
    const std::uint64_t fewest = drawn_at(level, far_away, sight.radius);
    std::uint64_t points = level.budget.points;
    while (points > fewest && bake::error_at(errors.points, points) < triangles_error) points -= 1 + points / 64;
    if (points <= fewest && bake::error_at(errors.points, fewest) < triangles_error) return std::nullopt;
    const double radius = points::level_of(level.points.levels, points).radius;
    const double nearest = std::max(sight.distance - sight.radius, 0.0);
    return sight.radius + nearest * sight.pixels_per_unit * radius / points::least_disc_px;
}

}  // namespace

Result<PointLevel> plan_points(const store::Store& store, const proto::Asset& asset, const proto::PlanRequest& request,
                               const Sight& sight) {
    Result<codec::Points> points = bake::load_points(store, asset.id);
    if (!points) return points.error();
    PointLevel level;
    level.points = *std::move(points);
    const std::vector<points::Level>& levels = level.points.levels;
    if (levels.empty()) return fail(ErrorCode::not_found, "asset '" + asset.name + "' has no points");
    level.profile = request.profile;
    const std::uint64_t bytes_each = bytes_per_point(level.points.cloud, level.profile);
    const Result<budget::PointBudget> budget = budget::derive_point_budget(
        request.budget,
        {levels.front().points, asset.triangles, points::points_for(levels, smallest_disc_px / sight.pixels_per_unit),
         header_bytes, bytes_each});
    if (!budget) return budget.error();
    level.budget = *budget;
    level.bytes = header_bytes + level.budget.points * bytes_each;
    return level;
}

double shown_error(const bake::ShownErrors& errors, std::uint64_t gouraud, std::uint64_t flat) {
    const std::uint64_t all = gouraud + flat;
    if (all == 0) return 0.0;
    const double share = static_cast<double>(flat) / static_cast<double>(all);
    return std::hypot(std::sqrt(1.0 - share) * bake::error_at(errors.gouraud, all),
                      std::sqrt(share) * bake::error_at(errors.flat, all));
}

std::optional<proto::Crossing> crossing_of(const PointLevel& level, const bake::ShownErrors& errors,
                                           double triangles_error, const Sight& sight) {
    if (!(bake::error_at(errors.points, level.budget.points) < triangles_error)) return std::nullopt;
    const std::uint64_t drawn = drawn_at(level, sight.pixels_per_unit, sight.radius);
    return proto::Crossing{farthest_win(level, errors, triangles_error, sight), percent * triangles_error,
                           percent * bake::error_at(errors.points, drawn)};
}

bool points_win(const proto::Crossing& crossing) {
    return crossing.points_error_percent < crossing.triangles_error_percent;
}

Status add_points(proto::PlanResponse& response, store::Store& store, const std::string& asset_id,
                  const PointLevel& level, double pixels_per_unit) {
    std::uint64_t count = level.budget.points;
    Result<StoredLevel> stored = stored_level(store, asset_id, level, count);
    const bool is_for_network = level.budget.limited_by == budget::LimitedBy::network;
    for (int i = 0; stored && is_for_network && stored->file.bytes > level.bytes && i < max_network_corrections; ++i) {
        count = std::max<std::uint64_t>(1, count * level.bytes / (stored->file.bytes + 1));
        stored = stored_level(store, asset_id, level, count);
    }
    if (!stored) return stored.error();
    response.budget.points = count;
    response.budget.limited_by = budget::limited_by_name(level.budget.limited_by);
    response.budget.feasible = level.budget.feasible;
    const points::Level measured = points::level_of(level.points.levels, count);
    response.level = {};
    response.level.points = count;
    response.level.vertices = count;
    response.level.rms_error = measured.error.rms;
    response.level.max_error = measured.error.max;
    response.level.rms_error_percent = bake::percent_of_diagonal(measured.error.rms, bounds_of(level.points.cloud));
    response.level.screen_space_error_px = measured.error.max * pixels_per_unit;
    response.shading.gouraud = response.shading.flat = 0;
    response.shading.operations = {};
    response.shading.mode = "points";
    response.timing_ms.encode = stored->encode_ms;
    response.content.profile = proto::profile_name(stored->profile);
    response.content.url = bake::content_url(stored->file.hash);
    response.content.bytes = stored->file.bytes;
    return Nothing{};
}

}  // namespace lodestream::planner
