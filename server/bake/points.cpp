#include "server/bake/points.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "common/mesh/operations.h"
#include "common/points/resample.h"
#include "common/points/tiles.h"
#include "server/bake/executor.h"
#include "server/bake/shapes.h"
#include "server/bake/shown_errors.h"
#include "server/bake/surface_colors.h"
#include "server/bake/tile_tree.h"

namespace lodestream::bake {

namespace {

// Shares of the time that making points takes.
constexpr double resampled_share = 0.3;
constexpr double ordered_share = 0.5;

Error cancelled() {
    return fail(ErrorCode::unavailable, "the making of points was ended");
}

// All cores, until the first task after which `done` says to stop.
simplify::Executor stoppable(const std::function<bool(std::size_t done, std::size_t all)>& done) {
    return [done](std::size_t count, const std::function<void(std::size_t)>& task) {
        std::atomic<std::size_t> ended = 0;
        std::atomic<bool> stopped = false;
        all_cores()(count, [&](std::size_t k) {
            if (stopped) return;
            task(k);
            if (!done(++ended, count)) stopped = true;
        });
    };
}

std::uint64_t point_budget(const mesh::Mesh& mesh) {
    return std::clamp<std::uint64_t>(mesh.triangles.size(), min_baked_points, max_baked_points);
}

points::PointCloud make_cloud(const mesh::Mesh& mesh, std::uint64_t budget, const SurfaceColors& colors) {
    points::ResampleOptions options;
    options.executor = all_cores();
    if (!colors.constant())
        options.color = [&](std::size_t triangle, const Vec3f& weights) { return colors.at(triangle, weights); };
    return points::resample(mesh, points::choose_parameters(mesh, budget), options);
}

// What is to be ordered, what it is measured against, and what is known of the content already.
struct Unordered {
    const points::PointCloud& cloud;
    std::uint64_t budget = 0;
    const mesh::Mesh& finest;
    const metric::SurfaceIndex& original;
    codec::Points content;
    metric::SurfaceError off{};  // of `finest` itself
};

Result<codec::Points> store_ordered(store::Store& store, const std::string& asset_id, Unordered source,
                                    const std::function<bool(double)>& progress) {
    points::OrderedCloud ordered = points::order(source.cloud, source.budget, all_cores());
    if (!progress(ordered_share)) return cancelled();
    std::atomic<bool> goes_on = true;
    const auto measured = [&](std::size_t done, std::size_t all) {
        const double share = static_cast<double>(done) / static_cast<double>(all);
        if (!progress(std::lerp(ordered_share, 1.0, share))) goes_on = false;
        return goes_on.load();
    };
    codec::Points& content = source.content;
    content.levels = points::measured_levels(source.original, source.finest, ordered, stoppable(measured));
    if (!goes_on) return cancelled();
    for (points::Level& level : content.levels) level.error = sum(level.error, source.off);
    content.cloud = std::move(ordered.cloud);
    content.grid = codec::point_grid(mesh::bounds(source.finest));
    Result<codec::EncodedPoints> encoded = codec::encode_points(content);
    if (!encoded) return encoded.error();
    Result<store::StoredFile> file = store.put_content(asset_id, points_key, "glb", encoded->glb);
    if (!file) return file.error();
    return std::move(content);
}

Status store_tiles(store::Store& store, const std::string& asset_id, const codec::Points& all) {
    TileTree tree;
    for (const points::Tile& tile : points::tiles_of(all.cloud)) {
        const double radius = points::level_of(all.levels, tile.shown).radius;
        codec::Points content{points::points_of(all.cloud, tile), all.grid, {}, all.base_color, all.origin};
        content.levels = {{content.cloud.positions.size(), {}, radius}};
        const Result<codec::EncodedPoints> encoded = codec::encode_points(content);
        if (!encoded) return encoded.error();
        Result<store::StoredFile> file =
            store.put_content(asset_id, tile_key(tree.nodes.size(), 0), "glb", encoded->glb);
        if (!file) return file.error();
        scene::LodNode node;
        node.box = {tile.box.min + all.origin, tile.box.max + all.origin};
        node.error = tile.child_count > 0 ? radius : 0.0;
        node.parent = tile.parent == points::no_tile ? scene::none : tile.parent;
        node.first_child = tile.first_child;
        node.child_count = tile.child_count;
        tree.nodes.push_back(node);
        tree.hashes.push_back(file->hash);
        tree.bytes.push_back(file->bytes);
    }
    if (Status valid = scene::validate(tree.nodes); !valid) return valid;
    Result<store::StoredFile> file = store.put_content(asset_id, tiles_key, "tiles", serialize(tree));
    return file ? Status{Nothing{}} : Status{file.error()};
}

}  // namespace

Status make_points(store::Store& store, const std::string& asset_id, const PointsSource& source,
                   const std::function<bool(double)>& progress) {
    const auto& [model, finest, original, off, history] = source;
    const SurfaceColors colors(model, finest);
    const std::uint64_t budget = point_budget(finest);
    const points::PointCloud cloud = make_cloud(finest, budget, colors);
    if (!progress(resampled_share)) return cancelled();
    codec::Points content;
    content.base_color = colors.constant().value_or(Vec4f(1.0f));
    content.origin = model.origin;
    const auto stored =
        store_ordered(store, asset_id, {cloud, budget, finest, original, std::move(content), off}, progress);
    if (!stored) return stored.error();
    if (!history) return Nothing{};
    return put_shown_errors(
        store, asset_id, measure_shown_errors({colors, finest, *history, stored->cloud, stored->levels}, all_cores()));
}

Status make_cloud_points(store::Store& store, const std::string& asset_id, const mesh::Model& model,
                         const std::function<bool(double)>& progress) {
    const points::PointCloud cloud{model.mesh.positions, model.mesh.normals, model.mesh.colors};
    const mesh::Mesh points = points::as_mesh(cloud);
    const metric::SurfaceIndex original(points);
    if (!progress(resampled_share)) return cancelled();
    codec::Points content;
    content.base_color = model.materials.front().base_color;
    content.origin = model.origin;
    const std::uint64_t budget = std::min<std::uint64_t>(cloud.positions.size(), max_cloud_points);
    const auto stored = store_ordered(store, asset_id, {cloud, budget, points, original, std::move(content)}, progress);
    if (!stored) return stored.error();
    return store_tiles(store, asset_id, *stored);
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
