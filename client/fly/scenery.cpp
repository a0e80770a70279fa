#include "client/fly/scenery.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lodestream::fly {

namespace {

constexpr double eye_over_terrain = 0.02;
constexpr double straight = 1e-9;  // sine of the angle to the vertical
constexpr std::uint64_t most_samples = 4'096;

}  // namespace

Result<Scenery> fetch_scenery(sdk::Client& client, const std::string& id_or_name, std::uint64_t max_triangles) {
    const auto asset = client.find_asset(id_or_name);
    if (!asset) return asset.error();
    if (asset->levels.empty())
        return fail(ErrorCode::unavailable,
                    "asset \"" + id_or_name + "\" has no levels: it is " + proto::status_name(asset->status));
    Scenery scenery;
    scenery.kind = asset->kind;
    double max_error = 0.0;
    for (const proto::Level& level : asset->levels) {
        if (scenery.levels.size() == control::max_levels) break;
        if (!scenery.levels.empty() && level.triangles >= scenery.levels.back().triangles) continue;
        if (level.triangles > max_triangles && &level != &asset->levels.back()) continue;
        const auto bytes = client.fetch(level.url, level.bytes);
        if (!bytes) return bytes.error();
        auto content = codec::decode_level(*bytes);
        if (!content) return content.error();
        max_error = std::max(max_error, level.max_error);
        scenery.levels.push_back({*std::move(content), level.triangles, max_error});
    }
    if (auto prepared = prepare(scenery); !prepared) return prepared.error();
    return scenery;
}

Status prepare(Scenery& scenery) {
    scenery.bounds = render::world_bounds(scenery.levels.front().content);
    for (SceneryLevel& level : scenery.levels) {
        auto part = render::prepare(level.content, scenery.bounds);
        if (!part) return part.error();
        level.part = *std::move(part);
    }
    return Nothing{};
}

Status make_movable(Scenery& scenery) {
    for (SceneryLevel& level : scenery.levels) {
        auto movable = render::movable_level(std::exchange(level.content, {}));
        if (!movable) return movable.error();
        level.movable = *std::move(movable);
        level.part = {};
    }
    return Nothing{};
}

Scenery chosen(const Scenery& scenery, const std::vector<std::size_t>& indices) {
    Scenery out{{}, scenery.bounds, scenery.kind};
    for (const std::size_t index : indices) out.levels.push_back(scenery.levels[index]);
    return out;
}

std::vector<control::Level> ladder_of(const Scenery& scenery, const shading::View& view,
                                      const budget::Display& display) {
    const double pixels = shading::pixels_per_unit(view, scenery.bounds, display);
    std::vector<control::Level> ladder;
    for (const SceneryLevel& level : scenery.levels) ladder.push_back({level.triangles, level.max_error * pixels});
    return ladder;
}

shading::View default_view(const Scenery& scenery, double fov_y_deg) {
    const Box& bounds = scenery.bounds;
    shading::View view = shading::framing_view(bounds);
    if (scenery.kind == "terrain" && !bounds.empty()) {
        const double width = std::max(bounds.extent().x, bounds.extent().z);
        view.eye = {bounds.center().x, bounds.max.y + eye_over_terrain * width, bounds.center().z};
        view.target = view.eye + Vec3d{0, 0, -width};
    }
    view.fov_y_deg = fov_y_deg;
    return view;
}

std::vector<Vec3d> sampled_triangles(const Scenery& scenery) {
    const SceneryLevel& finest = scenery.levels.front();
    const codec::Decoded& content = finest.movable ? finest.movable->content : finest.content;
    const std::size_t stride = finest.triangles / most_samples + 1;
    std::vector<Vec3d> points;
    for (const codec::Primitive& primitive : content.primitives) {
        const mesh::Mesh& mesh = primitive.mesh;
        for (std::size_t t = stride / 2; t < mesh.triangles.size(); t += stride) {
            Vec3d sum{0};
            for (const std::uint32_t corner : mesh.triangles[t]) sum += Vec3d(mesh.positions[corner]);
            points.push_back(content.origin + sum / 3.0);
        }
    }
    return points;
}

double share_in_view(std::span<const Vec3d> points, const shading::View& view, const budget::Display& display) {
    if (points.empty()) return 1.0;
    const Vec3d forward = normalize(view.target - view.eye);
    const Vec3d side = cross(forward, Vec3d{0, 1, 0});
    // Straight up or down, any direction is as good as another.
    const Vec3d right = length(side) > straight ? normalize(side) : Vec3d{1, 0, 0};
    const Vec3d up = cross(right, forward);
    const double tan_y = std::tan(0.5 * radians(view.fov_y_deg)), tan_x = tan_y * display.width / display.height;
    const auto seen = std::count_if(points.begin(), points.end(), [&](const Vec3d& point) {
        const Vec3d along = point - view.eye;
        const double ahead = dot(along, forward);
        return ahead > 0.0 && std::abs(dot(along, right)) <= ahead * tan_x && std::abs(dot(along, up)) <= ahead * tan_y;
    });
    return static_cast<double>(seen) / static_cast<double>(points.size());
}

shading::View view_of(const shading::View& default_view, const motion::Pose& pose) {
    shading::View view = default_view;
    motion::Pose seen = pose;
    if (pose.position) {
        view.eye = *pose.position;
    } else {
        const motion::Pose home = motion::looking_at(default_view.eye, default_view.target);
        seen.yaw_deg += home.yaw_deg;
        seen.pitch_deg = std::clamp(seen.pitch_deg + home.pitch_deg, -motion::max_pitch_deg, motion::max_pitch_deg);
    }
    // As far as the default view's target, so that it stays apart from the eye however large the coordinates are.
    view.target = view.eye + motion::direction(seen) * length(default_view.target - default_view.eye);
    return view;
}

}  // namespace lodestream::fly
