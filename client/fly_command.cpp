#include "client/fly_command.h"

#include <algorithm>
#include <cstdio>

#include "client/files.h"
#include "client/fly/pilot.h"
#include "client/fly/plan_follower.h"
#include "client/render/gl_context.h"
#include "client/render/image.h"

namespace lodestream::client {
namespace {

// A PNG a frame.
auto png_writer(const std::filesystem::path& folder) {
    return [folder, next = std::size_t{0}](const render::Image& image, const control::FrameRequest&) mutable {
        return render::write_png(numbered_png(folder, next++), image);
    };
}

// Where a device is given, under a plan.
Result<std::optional<fly::PlanFollower>> plan_of(const FlyArguments& arguments, const fly::PilotOptions& options) {
    if (!arguments.device) return std::optional<fly::PlanFollower>();
    auto request = read_device_file(*arguments.device);
    if (!request) return request.error();
    request->asset = arguments.asset;
    auto follower =
        fly::PlanFollower::start(arguments.server, *std::move(request), options.control.predictive.first_guess,
                                 options.screen, options.control.target_fps);
    if (!follower) return follower.error();
    return std::optional<fly::PlanFollower>(*std::move(follower));
}

// One frame of the most exposures tells whether the driver has them.
Status check_blur(render::Renderer& renderer, const fly::Scenery& scenery, fly::PilotOptions& options) {
    if (!options.control.blur.enabled) return Nothing{};
    const std::vector<motion::Pose> poses(control::max_exposures);
    const auto blurred = fly::picture(renderer, scenery, scenery.levels.size() - 1, poses, options.screen);
    if (blurred) return Nothing{};
    if (blurred.error().code != ErrorCode::unsupported) return blurred.error();
    std::fprintf(stderr, "lodestream-client: no motion blur: %s\n", blurred.error().message.c_str());
    options.control.blur.enabled = false;
    return Nothing{};
}

void print_line(const FlyArguments& arguments, const control::FlightSummary& flown) {
    std::printf(
        "%s, %s: %zu frames, %.1f fps on average, %.1f worst, deviation %.1f, %.1f %% within %.1f ms, %u switches, "
        "error %.2f px → %s\n",
        arguments.asset.c_str(), arguments.controller.c_str(), flown.frames, flown.average_fps, flown.worst_fps,
        flown.deviation_fps, 100.0 * flown.within_deadline, 1000.0 / arguments.target_fps, flown.switches,
        flown.mean_error_px, arguments.out.string().c_str());
}

void print_splits(const std::vector<fly::SplitFrame>& splits) {
    std::size_t moved = 0;
    double bound = 0.0, change = 0.0;
    for (std::size_t i = 1; i < splits.size(); ++i) {
        moved += splits[i].bound_steps > 0.0 ? 1 : 0;
        bound = std::max(bound, splits[i].bound_steps);
        change = std::max(change, splits[i].change_steps);
    }
    std::printf(
        "border between Gouraud and flat: moved in %zu frames, each by at most %.3f of 255 steps (bound %.3f)\n", moved,
        change, bound);
}

void print_plans(const fly::PlanSummary& plans) {
    std::printf("plans asked for: %u, at first %llu triangles, at last %llu (%s)\n", plans.plans,
                static_cast<unsigned long long>(plans.first_triangles),
                static_cast<unsigned long long>(plans.last_triangles), plans.limited_by.c_str());
    if (plans.failures > 0)
        std::fprintf(stderr, "lodestream-client: %u plans failed: %s\n", plans.failures, plans.last_failure.c_str());
}

}  // namespace

std::string to_csv(const std::vector<control::FlownFrame>& frames, const std::vector<fly::SplitFrame>& splits) {
    const bool has_splits = !frames.empty() && splits.size() == frames.size();
    std::string out = "t_s,frame_ms,level,triangles,speed_deg_s,error_px,switched";
    out += has_splits ? ",gouraud_triangles,split_bound_steps,split_change_steps\n" : "\n";
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const control::FlownFrame& frame = frames[i];
        char cells[192];
        std::snprintf(cells, sizeof cells, "%.6f,%.4f,%u,%llu,%.4f,%.4f,%d", frame.t_s, frame.frame_ms, frame.level,
                      static_cast<unsigned long long>(frame.triangles), frame.speed_deg_s, frame.error_px,
                      frame.switched ? 1 : 0);
        out += cells;
        if (has_splits) {
            std::snprintf(cells, sizeof cells, ",%llu,%.6f,%.6f",
                          static_cast<unsigned long long>(splits[i].gouraud_triangles), splits[i].bound_steps,
                          splits[i].change_steps);
            out += cells;
        }
        out += '\n';
    }
    return out;
}

Status fly(const FlyArguments& arguments) {
    const auto kind = control::parse_kind(arguments.controller);
    if (!kind) return kind.error();
    const auto trace = read_motion(arguments.motion);
    if (!trace) return trace.error();
    auto client = sdk::Client::open(arguments.server);
    if (!client) return client.error();
    auto scenery = fly::fetch_scenery(*client, arguments.asset);
    if (!scenery) return scenery.error();
    const bool is_hybrid = arguments.shading == "hybrid";
    if (is_hybrid)
        if (auto made = fly::make_movable(*scenery); !made) return made;
    auto context = render::create_headless_context();
    if (!context) return context.error();
    auto renderer = render::Renderer::create();
    if (!renderer) return renderer.error();

    fly::PilotOptions options;
    options.kind = *kind;
    options.control.target_fps = arguments.target_fps;
    options.control.speed = control::speed_options(scenery->levels.size());
    options.control.blur.enabled = arguments.blur;
    options.split.max_change = arguments.split_bound_steps / 255.0;
    options.screen = {arguments.width, arguments.height, arguments.fov_y_deg};
    if (arguments.frames) {
        if (auto made = make_folder(*arguments.frames); !made) return made;
        options.on_frame = png_writer(*arguments.frames);
    }
    if (auto checked = check_blur(*renderer, *scenery, options); !checked) return checked;
    const auto costs = fly::measure_costs(*renderer, *scenery, options.screen, options.control.blur.enabled);
    if (!costs) return costs.error();
    options.control.predictive.first_guess = *costs;
    auto plan = plan_of(arguments, options);
    if (!plan) return plan.error();
    if (*plan)
        options.budget = [&](const std::optional<control::DrawnFrame>& before) { return (*plan)->budget(before); };
    if (*plan) options.distance_steps = [&] { return (*plan)->distance_steps(); };
    std::vector<fly::SplitFrame> splits;
    if (is_hybrid) options.on_split = [&](const fly::SplitFrame& split) { splits.push_back(split); };
    const auto frames = fly::fly(*renderer, *scenery, *trace, options);
    if (!frames) return frames.error();
    if (auto written = write_text(arguments.out, to_csv(*frames, splits)); !written) return written;
    print_line(arguments, control::summarize(*frames, options.control));
    if (is_hybrid) print_splits(splits);
    if (*plan) print_plans((*plan)->finish());
    return Nothing{};
}

}  // namespace lodestream::client
