#include "server/cli/commands.h"

#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>

#include "proto/records.h"
#include "server/bake/bake.h"
#include "server/cli/asset_folder.h"
#include "server/cli/files.h"
#include "server/http/http_server.h"
#include "server/http/tileset.h"
#include "server/importer/importer.h"
#include "server/planner/planner.h"
#include "server/samples/samples.h"

namespace lodestream::cli {

namespace {

bool is_sample(const std::string& input) {
    return input.starts_with(sample_prefix);
}

Result<mesh::Model> read_input(const std::string& input) {
    if (is_sample(input)) return samples::make_sample(input.substr(std::string_view(sample_prefix).size()));
    return importer::import_file(input);
}

// A progress line on stderr, where that is a terminal.
std::function<bool(double)> terminal_progress(const std::string& name) {
    if (!isatty(STDERR_FILENO)) return {};
    return [name, last = -1](double share) mutable {
        const int percent = static_cast<int>(share * 100.0);
        if (percent != last) std::fprintf(stderr, "\r%s: %3d %%\033[K", name.c_str(), last = percent);
        return true;
    };
}

void end_progress() {
    if (isatty(STDERR_FILENO)) std::fprintf(stderr, "\r\033[K");
}

Result<proto::Asset> bake_one(store::Store& store, const std::string& input) {
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
    bake::BakeOptions options;
    options.progress = terminal_progress(asset.name);
    Result<proto::Asset> baked = bake::bake(store, asset, std::move(*model), options);
    end_progress();
    return baked;
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

// A sample that the store knows already is served as it is.
void submit_samples(store::Store& store, http::BakeQueue& bakes) {
    for (const std::string sample : served_samples) {
        const std::string name = asset_name_of(sample);
        if (Result<proto::Asset> known = store.asset(name); known && known->status == proto::AssetStatus::ready)
            continue;
        if (Result<proto::Asset> submitted = bakes.submit(name, sample); !submitted)
            std::fprintf(stderr, "%s: %s\n", sample.c_str(), submitted.error().message.c_str());
    }
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
    http::BakeQueue bakes(*store, planner);
    http::Service service(*store, planner, bakes, service_options);

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
    std::optional<Error> first_failure;
    for (const std::string& input : arguments.inputs) {
        Result<proto::Asset> asset = bake_one(*store, input);
        if (!asset) {
            Error failure = fail(asset.error().code, input + ": " + asset.error().message);
            if (!first_failure)
                first_failure = failure;
            else
                std::fprintf(stderr, "lodestream-server: %s\n", failure.message.c_str());
            continue;
        }
        if (arguments.json)
            std::printf("%s\n", proto::bake_record(*asset).c_str());
        else
            print_baked(*asset);
    }
    if (first_failure) return *first_failure;
    return Nothing{};
}

Status cut(const CutArguments& arguments) {
    Result<store::Store> store = store::Store::open(arguments.store);
    if (!store) return store.error();
    planner::Planner planner(*store);
    Result<planner::Planner::Cut> level = planner.cut(arguments.asset, arguments.triangles);
    if (!level) return level.error();

    Result<Written> written = write_model(arguments.out, level->model, level->error.rms, {});
    if (!written) return written.error();
    const proto::CutRecord record{arguments.asset,  written->triangles,       written->vertices,     written->bytes,
                                  level->cut_ms,    written->encode_ms,       level->error.rms,
                                  level->error.max, level->rms_error_percent, arguments.out.string()};
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
    if (!http::has_tileset(*asset)) return fail(ErrorCode::unavailable, "asset '" + asset->name + "' is not ready");

    for (std::size_t i = 0; i < asset->levels.size(); ++i) {
        proto::Level& level = asset->levels[i];
        Result<store::Store::Content> content = store->content(asset->id, bake::ladder_key(level.triangles));
        if (!content) return content.error();
        Result<std::vector<std::byte>> bytes = store::read_file(content->file.path, content->file.bytes);
        if (!bytes) return bytes.error();
        level.url = "level-" + std::to_string(i) + ".glb";
        if (Status written = write_file(arguments.out / level.url, *bytes); !written) return written.error();
    }
    const std::string json = http::tileset_json(*asset);
    if (Status written = write_file(arguments.out / "tileset.json", std::as_bytes(std::span(json))); !written)
        return written.error();
    std::printf("%s: %zu levels\n", (arguments.out / "tileset.json").c_str(), asset->levels.size());
    return Nothing{};
}

Status sample(const SampleArguments& arguments) {
    Result<mesh::Model> model = samples::make_sample(arguments.sample);
    if (!model) return model.error();
    Result<Written> written = write_model(arguments.out, *model, 0.0, {});
    if (!written) return written.error();
    std::printf("%s: %llu triangles, %llu vertices, %llu bytes\n", arguments.out.c_str(),
                static_cast<unsigned long long>(written->triangles), static_cast<unsigned long long>(written->vertices),
                static_cast<unsigned long long>(written->bytes));
    return Nothing{};
}

}  // namespace lodestream::cli
