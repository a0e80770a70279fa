#include "server/bake/bake.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>

#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "server/bake/textures.h"

namespace lodestream::bake {

namespace {

// Shares of the progress bar.
constexpr double recorded_share = 0.6;

class Stopwatch {
  public:
    double ms() const {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
    }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::uint64_t peak_memory_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::vector<std::uint64_t> ladder_counts(std::uint64_t triangles) {
    std::vector<std::uint64_t> counts{triangles};
    while (counts.size() < max_ladder_levels) {
        const auto next = static_cast<std::uint64_t>(static_cast<double>(counts.back()) * ladder_ratio);
        if (next < ladder_floor) break;
        counts.push_back(next);
    }
    return counts;
}

Result<proto::Level> make_level(store::Store& store, const std::string& asset_id, const BakedModel& baked,
                                const texture::Textures& textures, const metric::SurfaceIndex& original,
                                std::uint64_t triangles) {
    const mesh::Mesh& source = baked.model.mesh;
    const mesh::Mesh level = simplify::cut(source, baked.history, triangles);
    const metric::SurfaceError error = level.triangles.size() == source.triangles.size()
                                           ? metric::SurfaceError{}
                                           : metric::measure(original, source, level);

    const Stopwatch watch;
    const std::vector<std::uint8_t> all_gouraud(level.triangles.size(), 1);
    codec::EncodeOptions options;
    options.grid = level_grid(source, level, error);
    options.images = texture::choose(baked.model, textures, level_needs(error)).images;
    Result<codec::Encoded> encoded = codec::encode_level(baked.model, level, all_gouraud, options);
    if (!encoded) return encoded.error();
    const double encode_ms = watch.ms();

    Result<store::StoredFile> file =
        store.put_content(asset_id, ladder_key(level.triangles.size()), "glb", encoded->glb);
    if (!file) return file.error();

    proto::Level result;
    result.triangles = encoded->triangles;
    result.vertices = encoded->vertices;
    result.rms_error = error.rms;
    result.max_error = error.max;
    result.rms_error_percent = percent_of_diagonal(error.rms, mesh::bounds(source));
    result.bytes = encoded->glb.size();
    result.texture_bytes = encoded->texture_bytes;
    result.encode_ms = encode_ms;
    result.url = content_url(file->hash);
    return result;
}

// Everything of a bake that can fail; the caller turns a failure into the asset's status.
Result<proto::Asset> bake_stages(store::Store& store, proto::Asset asset, mesh::Model model,
                                 const BakeOptions& options) {
    const auto report = [&](double share) { return !options.progress || options.progress(share); };
    const Error cancelled = fail(ErrorCode::unavailable, "the bake of '" + asset.name + "' was cancelled");

    const Stopwatch watch;
    simplify::RecordOptions recording;
    recording.progress = [&](double share) { return report(share * recorded_share); };
    Result<simplify::History> history = simplify::record_history(model.mesh, recording);
    if (!history) return history.error();

    const BakedModel baked{std::move(model), std::move(*history)};
    Result<texture::Ladder> ladder = texture::make_ladder(baked.model);
    if (!ladder) return ladder.error();
    asset.warnings.insert(asset.warnings.end(), ladder.warnings.begin(), ladder.warnings.end());
    if (Status stored = put_textures(store, asset.id, *ladder); !stored) return stored.error();
    const texture::Textures textures = texture::textures_of(baked.model, *std::move(ladder));
    const metric::SurfaceIndex original(baked.model.mesh);
    const std::vector<std::uint64_t> counts = ladder_counts(baked.model.mesh.triangles.size());
    for (std::size_t i = 0; i < counts.size(); ++i) {
        if (!report(recorded_share +
                    (1.0 - recorded_share) * static_cast<double>(i) / static_cast<double>(counts.size())))
            return cancelled;
        Result<proto::Level> level = make_level(store, asset.id, baked, textures, original, counts[i]);
        if (!level) return level.error();
        if (!asset.levels.empty() && asset.levels.back().triangles == level->triangles) continue;
        asset.levels.push_back(std::move(*level));
    }
    if (Result<store::StoredFile> file = store.put_content(asset.id, baked_key, "bake", serialize(baked)); !file)
        return file.error();

    asset.bake_ms = watch.ms();
    asset.peak_memory_bytes = peak_memory_bytes();
    asset.status = proto::AssetStatus::ready;
    asset.progress = 1.0;
    if (Status stored = store.put_asset(asset); !stored) return stored.error();
    return asset;
}

}  // namespace

codec::QuantizationGrid level_grid(const mesh::Mesh& source, const mesh::Mesh& level,
                                   const metric::SurfaceError& error) {
    return codec::choose_grid(mesh::bounds(source), error.rms, mean_edge_length(level));
}

double mean_edge_length(const mesh::Mesh& mesh) {
    double sum = 0.0;
    for (const mesh::Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            sum += distance(Vec3d(mesh.positions[t[k]]), Vec3d(mesh.positions[t[(k + 1) % 3]]));
    return mesh.triangles.empty() ? 0.0 : sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

double percent_of_diagonal(double error, const Box& bounds) {
    const double diagonal = bounds.diagonal();
    return diagonal > 0.0 ? 100.0 * error / diagonal : 0.0;
}

std::string content_url(const std::string& hash) {
    return "/v1/content/" + hash + ".glb";
}

Result<proto::Asset> bake(store::Store& store, proto::Asset asset, mesh::Model model, const BakeOptions& options) {
    asset.kind = mesh::kind_name(model.kind);
    asset.triangles = model.mesh.triangles.size();
    asset.vertices = model.mesh.positions.size();
    Box world = mesh::bounds(model.mesh);
    asset.bounds_min = {world.min.x + model.origin.x, world.min.y + model.origin.y, world.min.z + model.origin.z};
    asset.bounds_max = {world.max.x + model.origin.x, world.max.y + model.origin.y, world.max.z + model.origin.z};
    asset.status = proto::AssetStatus::baking;
    asset.levels.clear();
    if (model.mesh.triangles.empty()) return invalid_input("'" + asset.name + "' has no triangles");
    if (Status stored = store.put_asset(asset); !stored) return stored.error();

    Error why;
    try {
        Result<proto::Asset> ready = bake_stages(store, asset, std::move(model), options);
        if (ready) return ready;
        why = ready.error();
    } catch (const std::bad_alloc&) {
        why = fail(ErrorCode::limit_exceeded, "'" + asset.name + "' needs more memory than there is");
    } catch (const std::exception& exception) {
        why = fail(ErrorCode::internal, "the bake of '" + asset.name + "' failed: " + exception.what());
    }
    asset.status = proto::AssetStatus::failed;
    asset.error = why.message;
    if (Status stored = store.put_asset(asset); !stored) return stored.error();
    return why;
}

Result<std::string> asset_id(std::string_view name) {
    if (name.empty()) return invalid_input("an asset's name must not be empty");
    if (name.size() > max_name_length)
        return invalid_input("an asset's name has at most " + std::to_string(max_name_length) + " characters");
    std::string id;
    for (const char c : name) {
        const bool lower = c >= 'a' && c <= 'z', digit = c >= '0' && c <= '9', upper = c >= 'A' && c <= 'Z';
        if (upper)
            id += static_cast<char>(c - 'A' + 'a');
        else
            id += lower || digit || c == '_' || (c == '.' && !id.empty()) ? c : '-';
    }
    return id;
}

}  // namespace lodestream::bake
