#include "client/roam_command.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

#include "client/files.h"
#include "client/fly/scenery.h"
#include "client/render/gl_context.h"
#include "client/render/image.h"
#include "client/roam/http_tiles.h"
#include "client/roam/revisions.h"
#include "client/roam/tour.h"

namespace lodestream::client {
namespace {

constexpr double bytes_per_mb = 1 << 20;
constexpr std::size_t max_told = 5;

struct Scene {
    std::string id, kind;
    proto::Tileset tileset;
};

Result<Scene> fetch_scene(sdk::Client& client, const std::string& id_or_name) {
    const auto asset = client.find_asset(id_or_name);
    if (!asset) return asset.error();
    auto tileset = client.root_document(asset->id);
    if (!tileset) return tileset.error();
    const auto unknown = std::ranges::find(tileset->bytes, 0u);
    if (unknown != tileset->bytes.end())
        return fail(ErrorCode::unsupported, "tile " + std::to_string(unknown - tileset->bytes.begin()) +
                                                " of the tileset does not tell its bytes");
    return Scene{asset->id, asset->kind, *std::move(tileset)};
}

// Keeps the motion from running ahead of the clock, so that tiles have the time that they have on a screen.
auto clock_keeper() {
    return [start = std::chrono::steady_clock::now()](double t_s) {
        std::this_thread::sleep_until(start + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                                  std::chrono::duration<double>(t_s)));
    };
}

roam::RoamOptions options_of(const RoamArguments& arguments) {
    roam::RoamOptions options;
    options.fps = arguments.fps;
    options.fade_s = arguments.fade_ms / 1e3;
    options.looks_ahead = arguments.looks_ahead;
    options.stream.tolerance_px = arguments.tolerance_px;
    options.stream.max_triangles = arguments.triangles.value_or(options.stream.max_triangles);
    options.stream.max_bytes = static_cast<std::uint64_t>(arguments.memory_mb * bytes_per_mb);
    options.width = arguments.width;
    options.height = arguments.height;
    options.wait_until = clock_keeper();
    if (arguments.frames)
        options.on_frame = [folder = *arguments.frames, next = std::size_t{0}](const render::Image& image) mutable {
            return render::write_png(numbered_png(folder, next++), image);
        };
    return options;
}

std::uint64_t fetched_bytes(const roam::Roamed& roamed) {
    return roamed.frames.empty() ? 0 : roamed.frames.back().fetched_bytes;
}

void print_line(const RoamArguments& arguments, const roam::Roamed& roamed, const roam::RoamSummary& met) {
    std::printf("%s: %zu frames, first picture after %.2f s, %.1f ms a frame (worst %.1f), error %.2f px, ",
                arguments.asset.c_str(), met.frames, met.first_picture_s, met.mean_frame_ms, met.worst_frame_ms,
                met.mean_error_px);
    std::printf("missed %.2f px, tiles missing in %.1f %% of frames, %llu tiles of %.2f MB fetched, ",
                met.mean_missed_px, 100.0 * met.missing_frames, static_cast<unsigned long long>(roamed.fetched_tiles),
                static_cast<double>(fetched_bytes(roamed)) / 1e6);
    std::printf("%.1f MB on the GPU at most, popping %.0f of 255 (p99.9 %.0f, RMS %.2f) → %s\n",
                static_cast<double>(met.peak_gpu_bytes) / 1e6, met.popping_largest, met.popping_p999, met.popping_rms,
                arguments.out.string().c_str());
}

void print_json(const roam::Roamed& roamed, const roam::RoamSummary& met) {
    std::printf("{\"frames\":%zu,\"first_picture_s\":%.4f,\"frame_ms\":%.4f,\"frame_ms_worst\":%.4f,", met.frames,
                met.first_picture_s, met.mean_frame_ms, met.worst_frame_ms);
    std::printf("\"error_px\":%.4f,\"missed_px\":%.4f,\"missing_frames\":%.6f,\"fetched_tiles\":%llu,",
                met.mean_error_px, met.mean_missed_px, met.missing_frames,
                static_cast<unsigned long long>(roamed.fetched_tiles));
    std::printf("\"fetched_bytes\":%llu,\"failed_tiles\":%zu,\"gpu_bytes_peak\":%llu,\"changes\":%zu,",
                static_cast<unsigned long long>(fetched_bytes(roamed)), roamed.failures.size(),
                static_cast<unsigned long long>(met.peak_gpu_bytes), met.changes);
    std::printf("\"revisions\":%llu,\"popping\":{\"largest\":%.0f,\"p999\":%.0f,\"rms\":%.4f}}\n",
                static_cast<unsigned long long>(roamed.revisions), met.popping_largest, met.popping_p999,
                met.popping_rms);
}

void warn_of(const std::vector<std::string>& tiles, const char* what) {
    for (std::size_t i = 0; i < std::min(tiles.size(), max_told); ++i)
        std::fprintf(stderr, "lodestream-client: %s%s\n", what, tiles[i].c_str());
    if (tiles.size() > max_told) std::fprintf(stderr, "lodestream-client: and %zu more\n", tiles.size() - max_told);
}

}  // namespace

std::string to_csv(const std::vector<roam::RoamFrame>& frames) {
    std::string out =
        "frame,t_s,frame_ms,tiles,triangles,error_px,missed_px,missing_tiles,fetched_bytes,gpu_bytes,fading_tiles,"
        "pop_largest,pop_p999,pop_rms,outdated_tiles,points\n";
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const roam::RoamFrame& frame = frames[i];
        char row[384];
        std::snprintf(
            row, sizeof row, "%zu,%.6f,%.4f,%zu,%llu,%.4f,%.4f,%zu,%llu,%llu,%zu,%.0f,%.0f,%.4f,%zu,%llu\n", i,
            frame.t_s, frame.frame_ms, frame.tiles, static_cast<unsigned long long>(frame.triangles), frame.error_px,
            frame.missed_px, frame.missing_tiles, static_cast<unsigned long long>(frame.fetched_bytes),
            static_cast<unsigned long long>(frame.gpu_bytes), frame.fading_tiles, frame.popping.largest,
            frame.popping.p999, frame.popping.rms, frame.outdated_tiles, static_cast<unsigned long long>(frame.points));
        out += row;
    }
    return out;
}

Status roam(const RoamArguments& arguments) {
    auto client = sdk::Client::open(arguments.server);
    if (!client) return client.error();
    const auto scene = fetch_scene(*client, arguments.asset);
    if (!scene) return scene.error();
    const Box& bounds = scene->tileset.nodes.front().box;
    const auto motion = arguments.motion ? read_motion(*arguments.motion) : Result(roam::tour(bounds));
    if (!motion) return motion.error();
    auto context = render::create_headless_context();
    if (!context) return context.error();
    auto renderer = render::Renderer::create();
    if (!renderer) return renderer.error();
    if (arguments.frames)
        if (auto made = make_folder(*arguments.frames); !made) return made;

    const auto tiles = roam::HttpTiles::open(arguments.server, bounds);
    if (!tiles) return tiles.error();
    roam::SlowLink slow(**tiles, arguments.link);
    const auto revisions = roam::Revisions::open(arguments.server, scene->id, scene->tileset);
    if (!revisions) return revisions.error();
    const bool is_slow = arguments.link.rtt_ms > 0.0 || arguments.link.downlink_mbps > 0.0;
    roam::Tiles& source = is_slow ? static_cast<roam::Tiles&>(slow) : **tiles;
    const shading::View home = fly::default_view({{}, bounds, scene->kind}, arguments.fov_y_deg);
    roam::RoamOptions options = options_of(arguments);
    options.newer = [&] { return (*revisions)->take(); };
    options.open = [&](const std::vector<std::string>& documents) { (*revisions)->open_documents(documents); };
    const auto roamed = roam::roam(*renderer, scene->tileset, source, *motion, home, options);
    if (!roamed) return roamed.error();
    if (auto written = write_text(arguments.out, to_csv(roamed->frames)); !written) return written;
    warn_of(roamed->failures, "covered by the level above: ");
    warn_of(roamed->warnings, "");
    const roam::RoamSummary met = roam::summarize(*roamed);
    if (arguments.json)
        print_json(*roamed, met);
    else
        print_line(arguments, *roamed, met);
    return Nothing{};
}

}  // namespace lodestream::client
