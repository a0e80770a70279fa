#include "server/bake/tile_levels.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/mesh/operations.h"

namespace lodestream::bake {

void add_chain(std::vector<std::uint64_t>& counts, std::uint64_t triangles, std::uint64_t end) {
    while (triangles > end) {
        triangles = std::max(end, static_cast<std::uint64_t>(chain_ratio * static_cast<double>(triangles)));
        counts.push_back(triangles);
    }
}

std::vector<std::uint64_t> tile_counts(std::uint64_t triangles_below, bool is_root) {
    const auto most = static_cast<std::uint64_t>(tile_ratio * static_cast<double>(triangles_below));
    std::vector<std::uint64_t> counts{std::clamp<std::uint64_t>(most, 1, tile_triangles)};
    if (is_root) add_chain(counts, counts.back(), coarsest_tile);
    return counts;
}

Result<std::vector<TileLevel>> cut_levels(SeenSurface seen, const std::vector<std::uint64_t>& counts,
                                          std::uint64_t fewer_than, const simplify::Executor& executor,
                                          const std::function<bool()>& progress) {
    const mesh::Mesh finest = seen.surfaces.front().mesh;
    std::vector<simplify::History> histories;
    for (Surface& surface : seen.surfaces) {
        simplify::RecordOptions options;
        options.executor = executor;
        options.progress = [&](double) { return progress(); };
        Result<simplify::History> history = simplify::record_history(std::move(surface.mesh), options);
        if (!history) return history.error();
        histories.push_back(*std::move(history));
    }
    std::vector<TileLevel> levels;
    for (const std::uint64_t count : counts) {
        TileLevel best;
        for (std::size_t i = 0; i < histories.size(); ++i) {
            mesh::Mesh level = simplify::cut(histories[i], count);
            const metric::SurfaceError error = metric::measure(seen.original, finest, level);
            if (i > 0 && !(error.rms < best.error.rms)) continue;
            best = {{std::move(level), seen.surfaces[i].is_bare}, error};
        }
        const std::size_t triangles = best.surface.mesh.triangles.size();
        if (triangles >= fewer_than) continue;
        fewer_than = triangles;
        best.surface.mesh = with_plausible_normals(std::move(best.surface.mesh));
        levels.push_back(std::move(best));
    }
    return levels;
}

codec::QuantizationGrid tile_grid(const mesh::Mesh& mesh, const metric::SurfaceError& error) {
    return codec::choose_window(mesh::bounds(mesh), error.rms, mesh::mean_edge_length(mesh));
}

double rounding_error(const codec::QuantizationGrid& grid) {
    return 0.5 * std::sqrt(3.0) * grid.step();
}

Result<codec::Encoded> encode_tile(const Surface& surface, const metric::SurfaceError& error,
                                   const codec::QuantizationGrid& grid, const mesh::Model& model,
                                   std::vector<codec::SmallerImage> images, const SceneColors* colors) {
    codec::EncodeOptions options;
    options.grid = grid;
    options.rounding = codec::Rounding::nearest;  // neighbours have borders in common
    codec::fit_normals(options, surface.mesh, error.normal_degrees);
    const std::vector<std::uint8_t> all_gouraud(surface.mesh.triangles.size(), 1);
    if (!surface.is_bare) {
        options.images = std::move(images);
        return codec::encode_level(model, surface.mesh, all_gouraud, options);
    }
    Result<mesh::Model> painted = colors->paint_as_seen(surface.mesh);
    if (!painted) return painted.error();
    painted->origin = model.origin;
    return codec::encode_level(*painted, painted->mesh, all_gouraud, options);
}

}  // namespace lodestream::bake
