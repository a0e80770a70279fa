#include "server/cli/commands.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <optional>
#include <span>

#include "common/mesh/instances.h"
#include "proto/records.h"
#include "proto/tileset.h"
#include "server/bake/bake.h"
#include "server/bake/points.h"
#include "server/bake/stopwatch.h"
#include "server/bake/tile_tree.h"
#include "server/cli/asset_folder.h"
#include "server/cli/files.h"
#include "server/cli/progress_bar.h"
#include "server/http/http_server.h"
#include "server/importer/importer.h"
#include "server/planner/planner.h"
#include "server/samples/samples.h"
#include "server/store/tile_archive.h"

namespace lodestream::cli {

namespace {

bool is_sample(const std::string& input) {
    return input.starts_with(sample_prefix);
}

Result<mesh::Model> read_input(const std::string& input) {
    if (is_sample(input)) return samples::make_sample(input.substr(std::string_view(sample_prefix).size()));
    return importer::import_file(input);
}

// Set by Ctrl-C. Bakes look at it whenever they tell their progress.
std::atomic<bool> interrupted{false};

class CancelOnInterrupt {
  public:
    CancelOnInterrupt() : before_(std::signal(SIGINT, [](int) { interrupted = true; })) {}
    ~CancelOnInterrupt() { std::signal(SIGINT, before_); }
    CancelOnInterrupt(const CancelOnInterrupt&) = delete;
    CancelOnInterrupt& operator=(const CancelOnInterrupt&) = delete;

  private:
    void (*before_)(int);
};

bake::BakeOptions options_for(const proto::Asset& asset, const bake::Limits& limits, const ProgressBar& bar) {
    bake::BakeOptions options;
    options.limits = limits;
    options.progress = [&bar, name = asset.name, triangles = asset.triangles](double share) {
        bar.show(name, triangles, share);
        return !interrupted;
    };
    return options;
}

Result<proto::Asset> finish_bake(store::Store& store, const proto::Asset& asset, const bake::Limits& limits) {
    const ProgressBar bar;
    return bake::bake_prepared(store, asset.id, options_for(asset, limits, bar));
}

Result<proto::Asset> bake_one(store::Store& store, const std::string& input, const bake::Limits& limits) {
    Result<mesh::Model> model = read_input(input);
    if (!model) return model.error();
    proto::Asset asset;
    asset.name = asset_name_of(input);
    Result<std::string> id = bake::asset_id(asset.name);
    if (!id) return id.error();
    asset.id = *id;
    asset.warnings = model.warnings;
    if (Result<proto::Asset> old = store.asset(asset.id))
        if (Status removed = store.remove_asset(old->id); !removed) return removed.error();
    Result<proto::Asset> prepared = bake::prepare(store, asset, *model, limits);
    if (!prepared) return prepared;
    *model = {};
    return finish_bake(store, *prepared, limits);
}

void print_baked(const proto::Asset& asset) {
    std::printf("%s: %s, %llu triangles, %llu vertices, baked in %.0f ms\n", asset.name.c_str(), asset.kind.c_str(),
                static_cast<unsigned long long>(asset.triangles), static_cast<unsigned long long>(asset.vertices),
                asset.bake_ms);
    std::printf("  %10s %10s %12s %10s %10s\n", "triangles", "vertices", "rms error %", "bytes", "encode ms");
    for (const proto::Level& level : asset.levels)
        std::printf("  %10llu %10llu %12.5f %10llu %10.1f\n", static_cast<unsigned long long>(level.triangles),
                    static_cast<unsigned long long>(level.vertices), level.rms_error_percent,
                    static_cast<unsigned long long>(level.bytes), level.encode_ms);
    for (const std::string& warning : asset.warnings) std::printf("  warning: %s\n", warning.c_str());
}

Result<std::string> read_token(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string token;
    if (!std::getline(in, token) || token.empty())
        return invalid_input("no token on the first line of " + file.string());
    while (!token.empty() && (token.back() == '\r' || token.back() == ' ')) token.pop_back();
    return token;
}

// A sample that the store knows already is served as it is, or is gone on with.
void submit_samples(store::Store& store, http::BakeQueue& bakes) {
    for (const std::string sample : served_samples) {
        const std::string name = asset_name_of(sample);
        if (Result<proto::Asset> known = store.asset(name); known && known->status != proto::AssetStatus::failed)
            continue;
        if (Result<proto::Asset> submitted = bakes.submit(name, sample); !submitted)
            std::fprintf(stderr, "%s: %s\n", sample.c_str(), submitted.error().message.c_str());
    }
}

double diagonal_of(const proto::Asset& asset) {
    if (!asset.bounds_min || !asset.bounds_max) return 0.0;
    const auto &low = *asset.bounds_min, &high = *asset.bounds_max;
    return glm::length(Vec3d(high[0], high[1], high[2]) - Vec3d(low[0], low[1], low[2]));
}

Status cut_points(store::Store& store, const CutArguments& arguments) {
    const Result<proto::Asset> asset = store.asset(arguments.asset);
    if (!asset) return asset.error();
    const bake::Stopwatch watch;
    const Result<codec::Points> all = bake::load_points(store, asset->id);
    if (!all) return all.error();
    const codec::Points cut = bake::cut_points(*all, *arguments.points);
    proto::PointCutRecord record;
    record.cut_ms = watch.ms();
    Result<Written> written = write_points(arguments.out, cut);
    if (!written) return written.error();

    const points::Level level = cut.levels.empty() ? points::Level{} : cut.levels.front();
    const double diagonal = diagonal_of(*asset);
    record.asset = arguments.asset;
    record.points = cut.cloud.positions.size();
    record.bytes = written->bytes;
    record.encode_ms = written->encode_ms;
    record.rms_error = level.error.rms;
    record.max_error = level.error.max;
    record.radius = level.radius;
    record.rms_error_percent = diagonal > 0.0 ? 100.0 * level.error.rms / diagonal : 0.0;
    record.out = arguments.out.string();
    if (arguments.json)
        std::printf("%s\n", proto::cut_record(record).c_str());
    else
        std::printf("%s: %llu points, %llu bytes, rms error %.5f %% of the diagonal; cut %.2f ms, encode %.1f ms\n",
                    record.out.c_str(), static_cast<unsigned long long>(record.points),
                    static_cast<unsigned long long>(record.bytes), record.rms_error_percent, record.cut_ms,
                    record.encode_ms);
    return Nothing{};
}

}  // namespace

std::string asset_name_of(const std::string& input) {
    if (!is_sample(input)) return std::filesystem::path(input).stem().string();
    const std::string spec = input.substr(std::string_view(sample_prefix).size());
    return spec.substr(0, spec.find(':'));
}

Status serve(const ServeArguments& arguments) {
    http::ServiceOptions service_options;
    if (arguments.token_file) {
        Result<std::string> token = read_token(*arguments.token_file);
        if (!token) return token.error();
        service_options.token = *token;
    }
    Result<store::Store> store = store::Store::open(arguments.store);
    if (!store) return store.error();
    planner::Planner planner(*store);
    http::BakeQueue bakes(*store, planner, arguments.limits);
    live::LiveScenes scenes(*store);
    http::Service service(*store, planner, bakes, scenes, service_options);

    if (arguments.samples) submit_samples(*store, bakes);
    std::optional<AssetFolder> folder;
    if (arguments.assets) {
        if (!std::filesystem::is_directory(*arguments.assets))
            return fail(ErrorCode::not_found, "--assets: " + arguments.assets->string() + " is not a folder");
        folder.emplace(*arguments.assets, *store, bakes);
    }

    http::ServerOptions options;
    options.listen = arguments.listen;
    options.threads = arguments.threads;
    return http::serve(service, options, [](std::uint16_t port) {
        std::printf("listening on http://127.0.0.1:%u\n", port);
        std::fflush(stdout);
    });
}

Status bake(const BakeArguments& arguments) {
    Result<store::Store> store = store::Store::open(arguments.store);
    if (!store) return store.error();
    const CancelOnInterrupt cancel_on_interrupt;
    std::optional<Error> first_failure;
    const auto tell = [&](const std::string& what, const Result<proto::Asset>& asset) {
        if (asset && arguments.json) std::printf("%s\n", proto::bake_record(*asset).c_str());
        if (asset && !arguments.json) print_baked(*asset);
        if (asset) return;
        Error failure = fail(asset.error().code, what + ": " + asset.error().message);
        if (first_failure) std::fprintf(stderr, "lodestream-server: %s\n", failure.message.c_str());
        if (!first_failure) first_failure = std::move(failure);
    };
    if (arguments.resume) {
        const Result<std::vector<std::string>> left = bake::recover(*store);
        if (!left) return left.error();
        for (const std::string& id : *left) {
            if (interrupted) break;
            const Result<proto::Asset> asset = store->asset(id);
            tell(id, asset ? finish_bake(*store, *asset, arguments.limits) : asset);
        }
    }
    for (const std::string& input : arguments.inputs) {
        if (interrupted) break;
        tell(input, bake_one(*store, input, arguments.limits));
    }
    if (first_failure) return *first_failure;
    if (interrupted) return fail(ErrorCode::unavailable, "interrupted");
    return Nothing{};
}

Status cut(const CutArguments& arguments) {
    Result<store::Store> store = store::Store::open(arguments.store);
    if (!store) return store.error();
    if (arguments.points) return cut_points(*store, arguments);
    planner::Planner planner(*store);
    Result<planner::Planner::Cut> level = planner.cut(arguments.asset, arguments.triangles);
    if (!level) return level.error();

    Result<Written> written = write_model(arguments.out, level->model, level->error.rms, {});
    if (!written) return written.error();
    const proto::CutRecord record{
        arguments.asset,    written->triangles, written->vertices, written->bytes,           level->cut_ms,
        written->encode_ms, level->error.rms,   level->error.max,  level->rms_error_percent, arguments.out.string()};
    if (arguments.json) {
        std::printf("%s\n", proto::cut_record(record).c_str());
    } else {
        std::printf("%s: %llu triangles, %llu bytes, rms error %.5f %% of the diagonal; cut %.2f ms, encode %.1f ms\n",
                    record.out.c_str(), static_cast<unsigned long long>(record.triangles),
                    static_cast<unsigned long long>(record.bytes), record.rms_error_percent, record.cut_ms,
                    record.encode_ms);
    }
    return Nothing{};
}

Status tileset(const TilesetArguments& arguments) {
    Result<store::Store> store = store::Store::open(arguments.store);
    if (!store) return store.error();
    Result<proto::Asset> asset = store->asset(arguments.asset);
    if (!asset) return asset.error();
    Result<bake::TileTree> tiles = bake::load_tiles(*store, *asset);
    if (!tiles) return tiles.error();
    std::optional<store::TileArchive> archive;
    if (arguments.out.extension() == store::archive_extension) {
        Result<store::TileArchive> created = store::TileArchive::create(arguments.out);
        if (!created) return created.error();
        archive = *std::move(created);
    }
    const auto put = [&](const std::string& name, std::span<const std::byte> bytes) {
        return archive ? archive->add(name, bytes) : write_file(arguments.out / name, bytes);
    };
    std::uint64_t bytes = 0;
    std::map<std::string, std::string> names;  // of contents, by hash
    for (std::size_t i = 0; i < tiles->nodes.size(); ++i) {
        const auto [name, is_new] = names.try_emplace(tiles->hashes[i], "tile-" + std::to_string(i) + ".glb");
        if (!is_new) {
            tiles->hashes[i] = name->second;
            continue;
        }
        Result<store::StoredFile> file = store->file(tiles->hashes[i], "glb");
        if (!file) return file.error();
        Result<std::vector<std::byte>> content = store::read_file(file->path, file->bytes);
        if (!content) return content.error();
        tiles->hashes[i] = name->second;
        if (Status written = put(tiles->hashes[i], *content); !written) return written;
        bytes += content->size();
    }
    proto::Tileset tileset{tiles->nodes, tiles->hashes, tiles->bytes, tiles->is_additive, tiles->matrices};
    proto::split_into_documents(
        tileset, [](std::uint64_t id, std::uint64_t) { return "tileset-" + std::to_string(id) + ".json"; });
    for (std::uint32_t tile = 0; tile < tileset.nodes.size(); ++tile) {
        if (tile > 0 && !proto::begins_document(tileset, tile)) continue;
        const std::string json = proto::to_json(tileset, tile),
                          name = tile > 0 ? tileset.documents[tile] : "tileset.json";
        if (Status written = put(name, std::as_bytes(std::span(json))); !written) return written;
    }
    if (archive)
        if (Status finished = archive->finish(); !finished) return finished;
    std::printf("%s: %zu tiles, %llu bytes\n", (archive ? arguments.out : arguments.out / "tileset.json").c_str(),
                tiles->nodes.size(), static_cast<unsigned long long>(bytes));
    return Nothing{};
}

Status sample(const SampleArguments& arguments) {
    Result<mesh::Model> model = samples::make_sample(arguments.sample);
    if (!model) return model.error();
    const std::uint64_t triangles = mesh::triangle_count(*model);
    if (triangles > samples::max_sample_triangles)
        return fail(ErrorCode::limit_exceeded, "sample \"" + arguments.sample + "\" has " + std::to_string(triangles) +
                                                   " triangles, a file at most " +
                                                   std::to_string(samples::max_sample_triangles));
    const mesh::Model flat = mesh::without_instances(*std::move(model));
    Result<Written> written = write_model(arguments.out, flat, 0.0, {});
    if (!written) return written.error();
    std::printf("%s: %llu triangles, %llu vertices, %llu bytes\n", arguments.out.c_str(),
                static_cast<unsigned long long>(written->triangles), static_cast<unsigned long long>(written->vertices),
                static_cast<unsigned long long>(written->bytes));
    return Nothing{};
}

}  // namespace lodestream::cli
