#include "server/bake/bake.h"

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>
#include <string>

#include "common/codec/level_codec.h"
#include "common/mesh/instances.h"
#include "common/mesh/operations.h"
#include "server/bake/executor.h"
#include "server/bake/first_levels.h"
#include "server/bake/hlod.h"
#include "server/bake/points.h"
#include "server/bake/shapes.h"
#include "server/bake/shells.h"
#include "server/bake/source_model.h"
#include "server/bake/stopwatch.h"
#include "server/bake/textures.h"
#include "server/store/mapped_file.h"

namespace lodestream::bake {

namespace {

// Shares of the progress bar.
constexpr double tiled_share = 0.3;  // of a scene
constexpr double recorded_share = 0.5;
constexpr double measured_share = 0.7;
constexpr double shells_share = 0.8;  // of a scene
constexpr double points_share = 0.9;

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

// Triangle counts at which errors are measured beside the rungs: the error grows fastest where the first triangles and
// the last ones go.
std::vector<std::uint64_t> measured_counts(std::uint64_t triangles) {
    std::vector<std::uint64_t> counts = ladder_counts(triangles);
    for (const double share : {0.9, 0.7})
        counts.push_back(static_cast<std::uint64_t>(share * static_cast<double>(triangles)));
    for (const std::uint64_t few : {16, 8, 6, 5, 4, 3, 2, 1})
        if (few < triangles) counts.push_back(few);
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

Result<proto::Level> make_level(const LevelMaker& maker, std::uint64_t triangles) {
    const mesh::Mesh level = simplify::cut(maker.baked.history, triangles);
    const metric::SurfaceError error = error_of(maker.baked.errors, level.triangles.size());

    const Stopwatch watch;
    const std::vector<std::uint8_t> all_gouraud(level.triangles.size(), 1);
    codec::EncodeOptions options = level_options(maker.baked.grid_bounds, level, error);
    options.images = texture::choose(maker.baked.model, maker.textures, level_needs(error)).images;
    Result<codec::Encoded> encoded = codec::encode_level(maker.baked.model, level, all_gouraud, options);
    if (!encoded) return encoded.error();
    const double encode_ms = watch.ms();

    Result<store::StoredFile> file =
        maker.store.put_content(maker.asset_id, ladder_key(level.triangles.size()), "glb", encoded->glb);
    if (!file) return file.error();

    return described_level(*encoded, error, maker.baked.bounds, encode_ms, file->hash);
}

// The progress bar, moved from several threads; one call at a time. Ends the bake where the caller or a limit says so.
class Progress {
  public:
    explicit Progress(const BakeOptions& options) : options_(options) {}

    bool operator()(double share) {
        const std::lock_guard lock(mutex_);
        shown_ = std::max(shown_, share);
        if (!end_) end_ = why_end();
        return !end_;
    }
    // `done` of `all` steps between two places of the bar. Steps may end in any order.
    bool step(double from, double to, std::size_t done, std::size_t all) {
        return (*this)(from + (to - from) * static_cast<double>(done) / static_cast<double>(all));
    }
    // Why the bake was ended from outside, if it was.
    std::optional<Error> end() const { return end_; }
    bool paused() const { return paused_; }

  private:
    std::optional<Error> why_end() {
        paused_ = options_.pause && options_.pause();
        if (paused_) return fail(ErrorCode::unavailable, "the bake was stopped; it goes on after a restart");
        if (options_.progress && !options_.progress(shown_))
            return fail(ErrorCode::unavailable, "the bake was cancelled");
        if (watch_.ms() > 1e3 * options_.limits.max_bake_s)
            return fail(ErrorCode::limit_exceeded,
                        "the bake took longer than the limit of " + std::to_string(options_.limits.max_bake_s) + " s");
        return std::nullopt;
    }

    const BakeOptions& options_;
    const Stopwatch watch_;
    std::mutex mutex_;
    double shown_ = 0.0;
    bool paused_ = false;
    std::optional<Error> end_;
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

Result<proto::Asset> finished(store::Store& store, proto::Asset asset, const Stopwatch& watch) {
    asset.bake_ms = watch.ms();
    asset.peak_memory_bytes = peak_memory_bytes();
    asset.status = proto::AssetStatus::ready;
    asset.progress = 1.0;
    if (Status stored = store.put_asset(asset); !stored) return stored.error();
    return asset;
}

// The tiles of a scene, and what the asset tells of them.
Status make_hierarchy(store::Store& store, proto::Asset& asset, const SceneParts& scene,
                      const texture::Textures& textures, Progress& progress) {
    const Stopwatch watch;
    const Result<TileTree> tree =
        make_tiles(store, asset.id, scene, textures, [&](double share) { return progress(share * tiled_share); });
    if (!tree) return tree.error();
    proto::Hierarchy& hierarchy = asset.hierarchy.emplace();
    hierarchy.tiles = tree->nodes.size();
    hierarchy.depth = depth(tree->nodes);
    for (const scene::LodNode& node : tree->nodes) hierarchy.triangles += node.triangles;
    std::set<std::string> contents;  // instances share theirs
    for (std::size_t i = 0; i < tree->hashes.size(); ++i)
        if (contents.insert(tree->hashes[i]).second) hierarchy.bytes += tree->bytes[i];
    hierarchy.max_error = tree->nodes.front().error;
    hierarchy.bake_ms = watch.ms();
    return Nothing{};
}

// A cloud has no triangles to cut; any prefix of its ordered points is a level.
Result<proto::Asset> bake_cloud(store::Store& store, proto::Asset asset, const mesh::Model& model, Progress& progress) {
    const Stopwatch watch;
    if (Status made = make_cloud_points(store, asset.id, model, [&](double share) { return progress(share); }); !made)
        return made.error();
    return finished(store, std::move(asset), watch);
}

// Of levels whose finest one is off by so much itself.
void make_worse(std::vector<ErrorSample>& errors, const metric::SurfaceError& off) {
    for (ErrorSample& sample : errors) sample.error = sum(sample.error, off);
}

std::string roughened(const WholeModel& whole, std::uint64_t triangles) {
    std::ostringstream text;
    text << "levels of the whole scene and its points are made of " << whole.model.mesh.triangles.size() << " of its "
         << triangles << " triangles: instances that are off by at most " << whole.error.max
         << ", which their errors include; its tiles show all of it";
    return text.str();
}

// Everything of a bake that can fail; the caller turns a failure into the asset's status.
Result<proto::Asset> bake_stages(store::Store& store, proto::Asset asset, mesh::Model model, Progress& progress) {
    const Error ended = fail(ErrorCode::unavailable, "the bake was ended");  // Progress knows why
    const Stopwatch watch;
    if (!progress(0.0)) return ended;
    if (model.kind == mesh::Kind::points) return bake_cloud(store, std::move(asset), model, progress);
    Result<texture::Ladder> ladder = load_textures(store, asset.id, model.images.size());
    if (!ladder) return ladder.error();
    const Result<std::vector<ShapeLevels>> shapes = make_shape_levels(model, [&] { return progress(0.0); });
    if (!shapes) return shapes.error();
    std::optional<WholeModel> flat;
    if (!model.instances.empty()) flat = whole_model(model, *shapes);
    const mesh::Model& shown = flat ? flat->model : model;
    const texture::Textures textures =
        texture::textures_of(*std::move(ladder), texture::image_uses(shown), texture::texel_sizes(shown));
    if (model.objects > 1)
        if (Status made = make_hierarchy(store, asset, {model, *shapes, shown.mesh}, textures, progress); !made)
            return made.error();
    const bool is_cut_from_instances = flat.has_value();
    if (flat && flat->error.max > 0.0) asset.warnings.push_back(roughened(*flat, asset.triangles));
    WholeModel whole = flat ? *std::move(flat) : WholeModel{std::move(model), {}};
    model = {};

    const double begun = model.objects > 1 ? tiled_share : 0.0;
    simplify::RecordOptions recording;
    recording.progress = [&](double share) { return progress(std::lerp(begun, recorded_share, share)); };
    recording.executor = all_cores();
    BakedModel baked = describe_model(whole.model);
    Result<simplify::History> history = simplify::record_history(std::move(whole.model.mesh), recording);
    if (!history) return history.error();
    whole.model = {};
    set_history(baked, std::move(*history));
    const mesh::Mesh source = simplify::cut(baked.history, simplify::triangle_count(simplify::view(baked.history)));
    if (!progress(recorded_share)) return ended;

    const metric::SurfaceIndex original(source);
    const LevelMaker maker{store, asset.id, baked, textures, source, original};
    const std::uint64_t finest = source.triangles.size();
    if (!is_cut_from_instances) asset.triangles = finest;
    const auto measure = [&](std::uint64_t triangles) { return measure_level(maker, triangles); };
    if (!make_all(measured_counts(finest), baked.errors, progress, recorded_share, measured_share, measure))
        return ended;
    baked.errors = in_order(std::move(baked.errors));
    if (asset.hierarchy) {
        Result<std::vector<Shell>> shells = make_shells(
            baked, source, [&](double share) { return progress(std::lerp(measured_share, shells_share, share)); });
        if (!shells) return shells.error();
        for (Shell& shell : *shells) {
            make_worse(shell.baked.errors, whole.error);
            make_worse(shell.seen_errors, whole.error);
        }
        if (Status stored = put_shells(store, asset.id, *shells); !stored) return stored.error();
    }
    make_worse(baked.errors, whole.error);
    const double done = asset.hierarchy ? shells_share : measured_share;
    const auto making_points = [&](double share) { return progress(std::lerp(done, points_share, share)); };
    const simplify::HistoryView cuts = simplify::view(baked.history);
    const PointsSource points{baked.model, source, original, whole.error, asset.hierarchy ? nullptr : &cuts};
    if (Status made = make_points(store, asset.id, points, making_points); !made) return made.error();

    std::vector<std::optional<Result<proto::Level>>> levels;
    const auto make = [&](std::uint64_t triangles) { return make_level(maker, triangles); };
    if (!make_all(ladder_counts(finest), levels, progress, points_share, 1.0, make)) return ended;
    asset.levels.clear();
    for (std::optional<Result<proto::Level>>& level : levels) {
        if (!*level) return level->error();
        if (!asset.levels.empty() && asset.levels.back().triangles == (*level)->triangles) continue;
        asset.levels.push_back(**std::move(level));
    }
    if (Result<store::StoredFile> file = store.put_content(asset.id, baked_key, "bake", serialize(baked)); !file)
        return file.error();

    return finished(store, std::move(asset), watch);
}

Result<mesh::Model> load_source(const store::Store& store, const std::string& asset_id) {
    Result<store::Store::Content> content = store.content(asset_id, imported_key);
    if (!content) return content.error();
    Result<store::MappedFile> file = store::MappedFile::open(content->file.path, content->file.bytes);
    if (!file) return file.error();
    return open_source_model(file->bytes());
}

std::uint32_t starts_of(const store::Store& store, const std::string& asset_id) {
    const Result<store::Store::Content> content = store.content(asset_id, imported_key);
    return content ? static_cast<std::uint32_t>(std::strtoul(content->record.c_str(), nullptr, 10)) : 0;
}

Status mark_failed(store::Store& store, proto::Asset asset, const std::string& why) {
    asset.status = proto::AssetStatus::failed;
    asset.error = why;
    asset.levels.clear();
    if (Status stored = store.put_asset(asset); !stored) return stored.error();
    return store.remove_content(asset.id, imported_key);
}

void describe(proto::Asset& asset, const mesh::Model& model) {
    asset.kind = mesh::kind_name(model.kind);
    asset.triangles = mesh::triangle_count(model);
    asset.vertices = mesh::vertex_count(model);
    Box box = mesh::bounds(model);
    if (model.kind == mesh::Kind::points)
        for (const Vec3f& p : model.mesh.positions) box.add(Vec3d(p));
    asset.bounds_min = {box.min.x + model.origin.x, box.min.y + model.origin.y, box.min.z + model.origin.z};
    asset.bounds_max = {box.max.x + model.origin.x, box.max.y + model.origin.y, box.max.z + model.origin.z};
    asset.status = proto::AssetStatus::baking;
    asset.levels.clear();
}

Result<proto::Asset> prepare_stages(store::Store& store, proto::Asset asset, const mesh::Model& imported) {
    const std::string id = asset.id;
    if (auto kept = store.put_content(id, imported_key, "model", serialize(imported), "0"); !kept) return kept.error();
    if (imported.kind == mesh::Kind::points) return asset;
    std::optional<WholeModel> flat;
    if (!imported.instances.empty()) {
        const Result<std::vector<ShapeLevels>> shapes = make_shape_levels(imported, [] { return true; });
        if (!shapes) return shapes.error();
        flat = whole_model(imported, *shapes);
    }
    const mesh::Model& model = flat ? flat->model : imported;
    std::vector<texture::ImageUse> uses = texture::image_uses(model);
    Result<texture::Ladder> ladder = texture::make_ladder(model, uses);
    if (!ladder) return ladder.error();
    asset.warnings.insert(asset.warnings.end(), ladder.warnings.begin(), ladder.warnings.end());
    if (Status stored = put_textures(store, id, *ladder); !stored) return stored.error();
    const texture::Textures textures =
        texture::textures_of(*std::move(ladder), std::move(uses), texture::texel_sizes(model));
    Result<std::vector<proto::Level>> levels =
        make_first_levels(store, id, model, flat ? flat->error : metric::SurfaceError{}, textures);
    if (!levels) return levels.error();
    asset.levels = *std::move(levels);
    if (Status stored = store.put_asset(asset); !stored) return stored.error();
    return asset;
}

// Turns what is thrown into an error.
template <class Make>
Result<proto::Asset> without_throwing(const Make& make) {
    try {
        return make();
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "it needs more memory than there is");
    } catch (const std::exception& exception) {
        return fail(ErrorCode::internal, std::string("the bake failed: ") + exception.what());
    }
}

Error of_asset(const proto::Asset& asset, const Error& error) {
    return fail(error.code, "'" + asset.name + "': " + error.message);
}

}  // namespace

bool is_empty(const mesh::Model& model) {
    return model.kind == mesh::Kind::points ? model.mesh.positions.empty() : mesh::triangle_count(model) == 0;
}

codec::EncodeOptions level_options(const Box& grid_bounds, const mesh::Mesh& level, const metric::SurfaceError& error,
                                   bool lean) {
    codec::EncodeOptions options;
    options.lean = lean;
    options.grid = codec::fit_grid(grid_bounds, level, error.rms, error.normal_degrees, lean);
    codec::fit_normals(options, level, error.normal_degrees);
    return options;
}

double percent_of_diagonal(double error, const Box& bounds) {
    const double diagonal = bounds.diagonal();
    return diagonal > 0.0 ? 100.0 * error / diagonal : 0.0;
}

std::string content_url(const std::string& hash) {
    return "/v1/content/" + hash + ".glb";
}

proto::Level described_level(const codec::Encoded& encoded, const metric::SurfaceError& error, const Box& bounds,
                             double encode_ms, const std::string& hash) {
    proto::Level level;
    level.triangles = encoded.triangles;
    level.vertices = encoded.vertices;
    level.rms_error = error.rms;
    level.max_error = error.max;
    level.normal_error_degrees = error.normal_degrees;
    level.rms_error_percent = percent_of_diagonal(error.rms, bounds);
    level.bytes = encoded.glb.size();
    level.texture_bytes = encoded.texture_bytes;
    level.encode_ms = encode_ms;
    level.url = content_url(hash);
    return level;
}

Result<proto::Asset> prepare(store::Store& store, proto::Asset asset, const mesh::Model& model, const Limits& limits) {
    describe(asset, model);
    if (is_empty(model)) return invalid_input("'" + asset.name + "' has no triangles");
    if (Status fits = check_memory(model, limits); !fits) return of_asset(asset, fits.error());
    if (Status stored = store.put_asset(asset); !stored) return stored.error();
    Result<proto::Asset> prepared = without_throwing([&] { return prepare_stages(store, asset, model); });
    if (prepared) return prepared;
    if (Status marked = mark_failed(store, asset, prepared.error().message); !marked) return marked.error();
    return of_asset(asset, prepared.error());
}

Result<proto::Asset> bake_prepared(store::Store& store, const std::string& asset_id, const BakeOptions& options) {
    const Result<proto::Asset> asset = store.asset(asset_id);
    if (!asset) return asset;
    const std::uint32_t starts = starts_of(store, asset_id);
    if (Status noted = store.set_record(asset_id, imported_key, std::to_string(starts + 1)); !noted)
        return noted.error();
    Progress progress(options);
    Result<proto::Asset> baked = without_throwing([&]() -> Result<proto::Asset> {
        Result<mesh::Model> model = load_source(store, asset_id);
        if (!model) return model.error();
        if (Status fits = check_memory(*model, options.limits); !fits) return fits.error();
        return bake_stages(store, *asset, *std::move(model), progress);
    });
    if (baked) {
        if (Status removed = store.remove_content(asset_id, imported_key); !removed) return removed.error();
        return baked;
    }
    const Error why = progress.end().value_or(baked.error());
    Status left = progress.paused() ? store.set_record(asset_id, imported_key, std::to_string(starts))
                                    : mark_failed(store, *asset, why.message);
    return of_asset(*asset, left ? why : left.error());
}

Result<proto::Asset> bake(store::Store& store, proto::Asset asset, mesh::Model model, const BakeOptions& options) {
    const Result<proto::Asset> prepared = prepare(store, std::move(asset), model, options.limits);
    if (!prepared) return prepared;
    model = {};
    return bake_prepared(store, prepared->id, options);
}

Result<std::vector<std::string>> recover(store::Store& store) {
    std::vector<std::string> going_on;
    for (const std::string& id : store.interrupted()) {
        const Result<proto::Asset> asset = store.asset(id);
        if (!asset) return asset.error();
        if (starts_of(store, id) < max_bake_starts) {
            going_on.push_back(id);
            continue;
        }
        const std::string why = "its bake ended the program " + std::to_string(max_bake_starts) +
                                " times (a crash, or killed while at it); send it again";
        if (Status marked = mark_failed(store, *asset, why); !marked) return marked.error();
    }
    return going_on;
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
