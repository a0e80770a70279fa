#include "server/bake/bake.h"

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <optional>

#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "server/bake/executor.h"
#include "server/bake/textures.h"

namespace lodestream::bake {

namespace {

// Shares of the progress bar.
constexpr double recorded_share = 0.5;
constexpr double measured_share = 0.8;

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

// Triangle counts at which errors are measured beside the rungs: the error grows fastest where the first triangles go.
std::vector<std::uint64_t> measured_counts(std::uint64_t triangles) {
    std::vector<std::uint64_t> counts = ladder_counts(triangles);
    for (const double share : {0.9, 0.7})
        counts.push_back(static_cast<std::uint64_t>(share * static_cast<double>(triangles)));
    counts.push_back(1);
    return counts;
}

// What the making of levels needs of a bake.
struct LevelMaker {
    store::Store& store;
    const std::string& asset_id;
    const BakedModel& baked;
    const texture::Textures& textures;
    const mesh::Mesh& source;
    const metric::SurfaceIndex& original;
};

ErrorSample measure_level(const LevelMaker& maker, std::uint64_t triangles) {
    const mesh::Mesh level = simplify::cut(maker.baked.history, triangles);
    const bool whole = level.triangles.size() == maker.source.triangles.size();
    return {level.triangles.size(),
            whole ? metric::SurfaceError{} : metric::measure(maker.original, maker.source, level)};
}

// Errors that do not fall where triangles do: a coarser level is never said to be better.
std::vector<ErrorSample> in_order(std::vector<ErrorSample> samples) {
    std::sort(samples.begin(), samples.end(),
              [](const ErrorSample& a, const ErrorSample& b) { return a.triangles > b.triangles; });
    const auto same = [](const ErrorSample& a, const ErrorSample& b) { return a.triangles == b.triangles; };
    samples.erase(std::unique(samples.begin(), samples.end(), same), samples.end());
    metric::SurfaceError worst;
    for (ErrorSample& sample : samples) {
        worst.rms = sample.error.rms = std::max(worst.rms, sample.error.rms);
        worst.max = sample.error.max = std::max(worst.max, sample.error.max);
    }
    return samples;
}

Result<proto::Level> make_level(const LevelMaker& maker, std::uint64_t triangles) {
    const mesh::Mesh level = simplify::cut(maker.baked.history, triangles);
    const metric::SurfaceError error = error_of(maker.baked.errors, level.triangles.size());

    const Stopwatch watch;
    const std::vector<std::uint8_t> all_gouraud(level.triangles.size(), 1);
    codec::EncodeOptions options;
    options.grid = level_grid(maker.baked.grid_bounds, level, error);
    options.images = texture::choose(maker.baked.model, maker.textures, level_needs(error)).images;
    Result<codec::Encoded> encoded = codec::encode_level(maker.baked.model, level, all_gouraud, options);
    if (!encoded) return encoded.error();
    const double encode_ms = watch.ms();

    Result<store::StoredFile> file =
        maker.store.put_content(maker.asset_id, ladder_key(level.triangles.size()), "glb", encoded->glb);
    if (!file) return file.error();

    proto::Level result;
    result.triangles = encoded->triangles;
    result.vertices = encoded->vertices;
    result.rms_error = error.rms;
    result.max_error = error.max;
    result.rms_error_percent = percent_of_diagonal(error.rms, maker.baked.bounds);
    result.bytes = encoded->glb.size();
    result.texture_bytes = encoded->texture_bytes;
    result.encode_ms = encode_ms;
    result.url = content_url(file->hash);
    return result;
}

// The progress bar, moved from several threads; one call at a time.
class Progress {
  public:
    explicit Progress(const BakeOptions& options) : options_(options) {}

    bool operator()(double share) {
        const std::lock_guard lock(mutex_);
        shown_ = std::max(shown_, share);
        cancelled_ = cancelled_ || (options_.progress && !options_.progress(shown_));
        return !cancelled_;
    }
    // `done` of `all` steps between two places of the bar. Steps may end in any order.
    bool step(double from, double to, std::size_t done, std::size_t all) {
        return (*this)(from + (to - from) * static_cast<double>(done) / static_cast<double>(all));
    }

  private:
    const BakeOptions& options_;
    std::mutex mutex_;
    double shown_ = 0.0;
    bool cancelled_ = false;
};

// Runs make(counts[i]) for all i side by side; false where the bake was cancelled meanwhile.
template <class Made, class Make>
bool make_all(const std::vector<std::uint64_t>& counts, std::vector<Made>& made, Progress& progress, double from,
              double to, Make make) {
    made.resize(counts.size());
    std::atomic<std::size_t> done{0};
    std::atomic<bool> going{true};
    all_cores()(counts.size(), [&](std::size_t i) {
        if (!going) return;
        made[i] = make(counts[i]);
        if (!progress.step(from, to, ++done, counts.size())) going = false;
    });
    return going;
}

// Everything of a bake that can fail; the caller turns a failure into the asset's status.
Result<proto::Asset> bake_stages(store::Store& store, proto::Asset asset, mesh::Model model,
                                 const BakeOptions& options) {
    Progress progress(options);
    const Error cancelled = fail(ErrorCode::unavailable, "the bake of '" + asset.name + "' was cancelled");

    const Stopwatch watch;
    simplify::RecordOptions recording;
    recording.progress = [&](double share) { return progress(share * recorded_share); };
    recording.executor = all_cores();
    Result<simplify::History> history = simplify::record_history(model.mesh, recording);
    if (!history) return history.error();

    const mesh::Mesh source = model.mesh;
    BakedModel baked = make_baked_model(std::move(model), std::move(*history));
    Result<texture::Ladder> ladder = texture::make_ladder(baked.model, baked.image_uses);
    if (!ladder) return ladder.error();
    asset.warnings.insert(asset.warnings.end(), ladder.warnings.begin(), ladder.warnings.end());
    if (Status stored = put_textures(store, asset.id, *ladder); !stored) return stored.error();
    const texture::Textures textures = texture::textures_of(*std::move(ladder), baked.image_uses, baked.texel_sizes);

    const metric::SurfaceIndex original(source);
    const LevelMaker maker{store, asset.id, baked, textures, source, original};
    asset.triangles = simplify::triangle_count(simplify::view(baked.history));
    const auto measure = [&](std::uint64_t triangles) { return measure_level(maker, triangles); };
    if (!make_all(measured_counts(asset.triangles), baked.errors, progress, recorded_share, measured_share, measure))
        return cancelled;
    baked.errors = in_order(std::move(baked.errors));

    std::vector<std::optional<Result<proto::Level>>> levels;
    const auto make = [&](std::uint64_t triangles) { return make_level(maker, triangles); };
    if (!make_all(ladder_counts(asset.triangles), levels, progress, measured_share, 1.0, make)) return cancelled;
    for (std::optional<Result<proto::Level>>& level : levels) {
        if (!*level) return level->error();
        if (!asset.levels.empty() && asset.levels.back().triangles == (*level)->triangles) continue;
        asset.levels.push_back(**std::move(level));
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

codec::QuantizationGrid level_grid(const Box& grid_bounds, const mesh::Mesh& level, const metric::SurfaceError& error) {
    return codec::choose_grid(grid_bounds, error.rms, mean_edge_length(level));
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
