#include "client/report/measure_frame_rate.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <thread>

#include "client/fly/pilot.h"
#include "client/probe/load_meter.h"
#include "common/simulate/sweep.h"

namespace lodestream::report {
namespace {

constexpr std::uint64_t max_flown_triangles =
    2'000'000;                                // finer levels are too slow for any renderer's 60 frames/s here
constexpr double horizontal_fov_deg = 120.0;  // the paper's
constexpr double fastest_deg_s = 200.0;
constexpr double targets_fps[] = {60.0, 30.0, 15.0};
constexpr std::size_t level_stride = 2;  // of a ladder that halves: a quarter of the triangles each, three levels
// Shares of the deadline. Still, the finest level fits, its upload included, with a tenth or so to spare: a frame that
// is waited for takes a fifth longer than one after the other. With four exposures it takes nearly three deadlines: no
// control drops to a third of the target.
constexpr double finest_share = 0.70;
constexpr double coarsest_share = 0.65;
constexpr double other_headings_deg[] = {90.0, 180.0, 270.0};  // the dearest view counts
constexpr std::uint32_t first_width = 320, most_width = 1280;  // 4:3
constexpr double width_step = 1.2;
constexpr std::size_t image_stride = 10;  // frames between two that are compared
constexpr double blur_turn_deg = 3.0;     // in a frame: 180 degrees/s at 60 frames/s
constexpr std::size_t quantiles = 50;

fly::Screen screen_of(double width) {
    fly::Screen screen;
    screen.width = static_cast<std::uint32_t>(std::lround(width / 4.0)) * 4;
    screen.height = screen.width * 3 / 4;
    screen.fov_y_deg = 2.0 * std::atan(std::tan(radians(horizontal_fov_deg / 2.0)) * 0.75) * 180.0 / pi;
    return screen;
}

Result<proto::Asset> flown_asset(sdk::Client& client) {
    auto assets = client.assets();
    if (!assets) return assets.error();
    std::erase_if(*assets, [](const proto::Asset& asset) { return asset.status != proto::AssetStatus::ready; });
    const auto less = [](const proto::Asset& a, const proto::Asset& b) {
        return std::pair(a.kind == "terrain", a.triangles) < std::pair(b.kind == "terrain", b.triangles);
    };
    const auto found = std::max_element(assets->begin(), assets->end(), less);
    if (found == assets->end()) return fail(ErrorCode::not_found, "no asset to fly over");
    return std::move(*found);
}

Status begin(const FrameRateOptions& options, const std::string& step) {
    if (options.progress(step)) return Nothing{};
    return fail(ErrorCode::unavailable, "interrupted");
}

// Three levels and a screen that make the paper's case on this renderer.
struct Scene {
    fly::Scenery scenery;
    fly::Screen screen;
    double target_fps = 0.0;
};

class FrameRate {
  public:
    FrameRate(render::Renderer& renderer, const FrameRateOptions& options) : renderer_(renderer), options_(options) {}

    Result<FrameRateResult> run(const proto::Asset& asset, const fly::Scenery& ladder);

  private:
    Result<bool> fits(const fly::Scenery& scenery, std::size_t level, const fly::Screen& screen, double exposures,
                      double limit_ms);
    Result<std::optional<std::size_t>> finest_level(const fly::Scenery& ladder, const fly::Screen& screen,
                                                    double deadline_ms);
    Result<std::optional<Scene>> scene_at(const fly::Scenery& ladder, double target_fps);
    Result<Scene> find_scene(const fly::Scenery& ladder);
    Result<fly::Screen> largest_screen(const fly::Scenery& scenery, double deadline_ms);
    Result<FlightResult> fly_one(const Scene& scene, const motion::Trace& trace, control::Kind kind,
                                 const control::FrameCosts& costs);
    Result<BlurResult> measure_blur(const Scene& scene, std::uint32_t exposures);

    render::Renderer& renderer_;
    const FrameRateOptions& options_;
};

Result<bool> FrameRate::fits(const fly::Scenery& scenery, std::size_t level, const fly::Screen& screen,
                             double exposures, double limit_ms) {
    const auto times = fly::time_level(renderer_, scenery, level, screen);
    if (!times) return times.error();
    double draw_ms = times->draw_ms;
    for (const double yaw_deg : other_headings_deg) {
        const auto turned_ms = fly::time_frame(renderer_, scenery, level, {{std::nullopt, yaw_deg, 0.0}}, screen);
        if (!turned_ms) return turned_ms.error();
        draw_ms = std::max(draw_ms, *turned_ms);
    }
    return exposures * draw_ms + times->upload_ms <= limit_ms;
}

// From coarse to fine, so that nothing much dearer than what fits is drawn.
Result<std::optional<std::size_t>> FrameRate::finest_level(const fly::Scenery& ladder, const fly::Screen& screen,
                                                           double deadline_ms) {
    std::optional<std::size_t> finest;
    for (std::size_t level = ladder.levels.size(); level-- > 0;) {
        const auto in_time = fits(ladder, level, screen, 1.0, finest_share * deadline_ms);
        if (!in_time) return in_time.error();
        if (!*in_time) break;
        finest = level;
    }
    return finest;
}

Result<fly::Screen> FrameRate::largest_screen(const fly::Scenery& scenery, double deadline_ms) {
    fly::Screen largest = screen_of(first_width);
    for (double width = first_width * width_step; width <= most_width; width *= width_step) {
        const fly::Screen screen = screen_of(width);
        const auto finest = fits(scenery, 0, screen, 1.0, finest_share * deadline_ms);
        if (!finest) return finest.error();
        const auto coarsest =
            fits(scenery, scenery.levels.size() - 1, screen, control::max_exposures, coarsest_share * deadline_ms);
        if (!coarsest) return coarsest.error();
        if (!*finest || !*coarsest) break;
        largest = screen;
    }
    return largest;
}

Result<std::optional<Scene>> FrameRate::scene_at(const fly::Scenery& ladder, double target_fps) {
    const double deadline_ms = 1000.0 / target_fps;
    const fly::Screen screen = screen_of(first_width);
    const auto coarsest =
        fits(ladder, ladder.levels.size() - 1, screen, control::max_exposures, coarsest_share * deadline_ms);
    if (!coarsest) return coarsest.error();
    if (!*coarsest) return std::optional<Scene>();
    const auto finest = finest_level(ladder, screen, deadline_ms);
    if (!finest) return finest.error();
    if (!*finest) return std::optional<Scene>();
    std::vector<std::size_t> levels;
    for (std::size_t level = **finest; level < ladder.levels.size() && levels.size() < 3; level += level_stride)
        levels.push_back(level);
    if (levels.size() < 3) return std::optional<Scene>();
    Scene scene{fly::chosen(ladder, levels), screen, target_fps};
    const auto largest = largest_screen(scene.scenery, deadline_ms);
    if (!largest) return largest.error();
    scene.screen = *largest;
    return std::optional<Scene>(std::move(scene));
}

Result<Scene> FrameRate::find_scene(const fly::Scenery& ladder) {
    for (const double target_fps : targets_fps) {
        auto scene = scene_at(ladder, target_fps);
        if (!scene) return scene.error();
        if (*scene) return **std::move(scene);
    }
    return fail(ErrorCode::unavailable, "no three levels can be drawn at 15 frames/s");
}

// What a frame showed, to be compared when time no longer counts.
struct Shown {
    render::Image image;
    std::vector<motion::Pose> poses;
};

Result<double> image_error_percent(render::Renderer& renderer, const Scene& scene, const std::vector<Shown>& shown) {
    double sum = 0.0;
    for (const Shown& frame : shown) {
        const auto finest = fly::picture(renderer, scene.scenery, 0, frame.poses, scene.screen);
        if (!finest) return finest.error();
        const auto difference = render::compare(*finest, frame.image);
        if (!difference) return difference.error();
        sum += 100.0 * difference->rms / 255.0;
    }
    return shown.empty() ? 0.0 : sum / static_cast<double>(shown.size());
}

Result<FlightResult> FrameRate::fly_one(const Scene& scene, const motion::Trace& trace, control::Kind kind,
                                        const control::FrameCosts& costs) {
    if (auto going_on = begin(options_, std::string("frame rate: ") + control::kind_name(kind)); !going_on)
        return going_on.error();
    std::vector<Shown> shown;
    std::size_t count = 0;
    fly::PilotOptions options;
    options.kind = kind;
    options.control.target_fps = scene.target_fps;
    options.control.predictive.first_guess = costs;
    options.screen = scene.screen;
    options.on_frame = [&](const render::Image& image, const control::FrameRequest& request) -> Status {
        if (count++ % image_stride == 0) shown.push_back({image, request.poses});
        return Nothing{};
    };
    const probe::LoadMeter load;
    auto frames = fly::fly(renderer_, scene.scenery, trace, options);
    const std::optional<double> other_cores = load.other_cores();
    if (!frames) return frames.error();
    const auto error_percent = image_error_percent(renderer_, scene, shown);
    if (!error_percent) return error_percent.error();
    const control::FlightSummary summary = control::summarize(*frames, options.control);
    return FlightResult{control::kind_name(kind), summary, *std::move(frames), *error_percent, other_cores};
}

Result<BlurResult> FrameRate::measure_blur(const Scene& scene, std::uint32_t exposures) {
    std::vector<motion::Pose> poses;
    for (std::uint32_t i = 1; i <= exposures; ++i) poses.push_back({std::nullopt, blur_turn_deg * i / exposures, 0.0});
    const auto coarse = fly::picture(renderer_, scene.scenery, scene.scenery.levels.size() - 1, poses, scene.screen);
    if (!coarse) return coarse.error();
    const auto fine = fly::picture(renderer_, scene.scenery, 0, poses, scene.screen);
    if (!fine) return fine.error();
    const auto difference = render::compare(*fine, *coarse);
    if (!difference) return difference.error();
    const auto frame_ms = fly::time_frame(renderer_, scene.scenery, 0, poses, scene.screen);
    if (!frame_ms) return frame_ms.error();
    return BlurResult{exposures, *frame_ms, 100.0 * difference->rms / 255.0};
}

using Sweep = std::vector<std::array<simulate::PerController, simulate::trace_count>>;

Result<Sweep> sweep_on_all_cores(const std::array<simulate::NamedTrace, simulate::trace_count>& traces,
                                 std::uint64_t devices) {
    const std::uint64_t parts = std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::future<Result<Sweep>>> running;
    for (std::uint64_t part = 0; part < parts; ++part) {
        const std::uint64_t first = devices * part / parts, last = devices * (part + 1) / parts;
        running.push_back(std::async(std::launch::async, [&traces, first, last] {
            return simulate::sweep(simulate::SweepOptions{}, traces, first, last - first);
        }));
    }
    Sweep all;
    for (auto& part : running) {
        const Result<Sweep> done = part.get();
        if (!done) return done.error();
        all.insert(all.end(), done->begin(), done->end());
    }
    return all;
}

SweepRow sweep_row(const Sweep& sweep, std::size_t trace, const std::string& motion, std::size_t kind) {
    SweepRow row{motion, control::kind_name(control::kinds[kind]), 0.0, 1.0, 0.0, 0.0, 0.0};
    const double count = static_cast<double>(sweep.size());
    for (const auto& device : sweep) {
        const control::FlightSummary& flown = device[trace][kind];
        row.within_deadline += flown.within_deadline / count;
        row.worst_device = std::min(row.worst_device, flown.within_deadline);
        row.deviation_fps += flown.deviation_fps / count;
        row.switches += flown.switches / count;
        row.error_px += flown.mean_error_px / count;
    }
    return row;
}

SweepDistribution distribution(const Sweep& sweep, std::size_t kind) {
    std::vector<double> all;
    for (const auto& device : sweep)
        for (const simulate::PerController& trace : device) all.push_back(trace[kind].within_deadline);
    std::sort(all.begin(), all.end());
    SweepDistribution out{control::kind_name(control::kinds[kind]), {}};
    for (std::size_t i = 0; i <= quantiles; ++i) out.within_deadline.push_back(all[(all.size() - 1) * i / quantiles]);
    return out;
}

Status add_sweep(const FrameRateOptions& options, FrameRateResult& result) {
    constexpr std::uint64_t all_devices = 1000, quick_devices = 60;
    constexpr double seconds = 8.0;
    result.devices = options.quick ? quick_devices : all_devices;
    if (auto going_on = begin(options, "frame rate: " + std::to_string(result.devices) + " simulated devices");
        !going_on)
        return going_on;
    const auto traces = simulate::sweep_traces(seconds);
    const auto sweep = sweep_on_all_cores(traces, result.devices);
    if (!sweep) return sweep.error();
    for (std::size_t trace = 0; trace < traces.size(); ++trace)
        for (std::size_t kind = 0; kind < std::size(control::kinds); ++kind)
            result.sweep.push_back(sweep_row(*sweep, trace, traces[trace].name, kind));
    for (std::size_t kind = 0; kind < std::size(control::kinds); ++kind)
        result.distributions.push_back(distribution(*sweep, kind));
    return Nothing{};
}

Result<FrameRateResult> FrameRate::run(const proto::Asset& asset, const fly::Scenery& ladder) {
    if (auto going_on = begin(options_, "frame rate: finding three levels of " + asset.name); !going_on)
        return going_on.error();
    const auto scene = find_scene(ladder);
    if (!scene) return scene.error();
    const auto trace = motion::built_in({motion::Kind::reversal, options_.quick ? 4.0 : 10.0, fastest_deg_s, 1});
    if (!trace) return trace.error();
    const auto costs = fly::measure_costs(renderer_, scene->scenery, scene->screen);
    if (!costs) return costs.error();

    FrameRateResult result;
    result.asset = asset.name;
    result.motion = "still, sudden start, sudden reversal, sudden stop";
    result.target_fps = scene->target_fps;
    result.screen = fly::display_of(scene->screen);
    result.fov_y_deg = scene->screen.fov_y_deg;
    result.ladder = fly::ladder_of(scene->scenery, fly::default_view(scene->scenery, result.fov_y_deg), result.screen);
    for (const control::Kind kind : control::kinds) {
        auto flight = fly_one(*scene, *trace, kind, *costs);
        if (!flight) return flight.error();
        result.flights.push_back(*std::move(flight));
    }
    for (const std::uint32_t exposures : {1u, 2u, 4u}) {
        const auto blur = measure_blur(*scene, exposures);
        if (!blur) return blur.error();
        result.blur.push_back(*blur);
    }
    return result;
}

}  // namespace

Result<FrameRateResult> measure_flights(sdk::Client& client, render::Renderer& renderer,
                                        const FrameRateOptions& options) {
    const auto asset = flown_asset(client);
    if (!asset) return asset.error();
    const auto ladder = fly::fetch_scenery(client, asset->id, max_flown_triangles);
    if (!ladder) return ladder.error();
    return FrameRate(renderer, options).run(*asset, *ladder);
}

Result<FrameRateResult> measure_frame_rate(sdk::Client& client, render::Renderer& renderer,
                                           const FrameRateOptions& options) {
    auto result = measure_flights(client, renderer, options);
    if (!result) return result;
    if (auto swept = add_sweep(options, *result); !swept) return swept.error();
    return result;
}

}  // namespace lodestream::report
