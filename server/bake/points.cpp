#include "server/bake/points.h"

#include <algorithm>

#include "common/mesh/operations.h"
#include "common/points/resample.h"
#include "server/bake/executor.h"
#include "server/bake/surface_colors.h"

namespace lodestream::bake {

namespace {

points::OrderedCloud make_cloud(const mesh::Mesh& mesh, const SurfaceColors& colors) {
    const std::uint64_t budget = std::clamp<std::uint64_t>(mesh.triangles.size(), min_baked_points, max_baked_points);
    points::ResampleOptions options;
    options.executor = all_cores();
    if (!colors.constant())
        options.color = [&](std::size_t triangle, const Vec3f& weights) { return colors.at(triangle, weights); };
    return points::order(points::resample(mesh, points::choose_parameters(mesh, budget), options), budget);
}

}  // namespace

Status make_points(store::Store& store, const std::string& asset_id, const mesh::Model& model, const mesh::Mesh& finest,
                   const metric::SurfaceIndex& original) {
    const SurfaceColors colors(model, finest);
    points::OrderedCloud ordered = make_cloud(finest, colors);
    codec::Points content;
    content.levels = points::measured_levels(original, finest, ordered, all_cores());
    content.cloud = std::move(ordered.cloud);
    content.grid = codec::point_grid(mesh::bounds(finest));
    content.base_color = colors.constant().value_or(Vec4f(1.0f));
    content.origin = model.origin;
    Result<codec::EncodedPoints> encoded = codec::encode_points(content);
    if (!encoded) return encoded.error();
    Result<store::StoredFile> file = store.put_content(asset_id, points_key, "glb", encoded->glb);
    if (!file) return file.error();
    return Nothing{};
}

Result<codec::Points> load_points(const store::Store& store, const std::string& asset_id) {
    Result<store::Store::Content> stored = store.content(asset_id, points_key);
    if (!stored) return fail(stored.error().code, "asset '" + asset_id + "' has no points: " + stored.error().message);
    Result<std::vector<std::byte>> bytes = store::read_file(stored->file.path, max_points_bytes);
    if (!bytes) return bytes.error();
    Result<codec::DecodedPoints> decoded = codec::decode_points(*bytes);
    if (!decoded) return decoded.error();
    return std::move(decoded->content);
}

codec::Points cut_points(const codec::Points& points, std::uint64_t count) {
    codec::Points cut{points::prefix(points.cloud, count), points.grid, {}, points.base_color, points.origin};
    if (points.levels.empty()) return cut;
    cut.levels.push_back(points::level_of(points.levels, cut.cloud.positions.size()));
    for (const points::Level& level : points.levels)
        if (level.points < cut.levels.front().points) cut.levels.push_back(level);
    return cut;
}

}  // namespace lodestream::bake
