#include "client/fly_command.h"

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

Result<std::vector<control::FlownFrame>> fly_scenery(render::Renderer& renderer, const fly::Scenery& scenery,
                                                     const motion::Trace& trace, fly::PilotOptions& options) {
    auto frames = fly::fly(renderer, scenery, trace, options);
    if (frames || frames.error().code != ErrorCode::unsupported || !options.control.blur.enabled) return frames;
    std::fprintf(stderr, "lodestream-client: no motion blur: %s\n", frames.error().message.c_str());
    options.control.blur.enabled = false;
    return fly::fly(renderer, scenery, trace, options);
}

void print_line(const FlyArguments& arguments, const control::FlightSummary& flown) {
    std::printf(
        "%s, %s: %zu frames, %.1f fps on average, %.1f worst, deviation %.1f, %.1f %% within %.1f ms, %u switches, "
        "error %.2f px → %s\n",
        arguments.asset.c_str(), arguments.controller.c_str(), flown.frames, flown.average_fps, flown.worst_fps,
        flown.deviation_fps, 100.0 * flown.within_deadline, 1000.0 / arguments.target_fps, flown.switches,
        flown.mean_error_px, arguments.out.string().c_str());
}

void print_plans(const fly::PlanSummary& plans) {
    std::printf("plans asked for: %u, at first %llu triangles, at last %llu (%s)\n", plans.plans,
                static_cast<unsigned long long>(plans.first_triangles),
                static_cast<unsigned long long>(plans.last_triangles), plans.limited_by.c_str());
    if (plans.failures > 0)
        std::fprintf(stderr, "lodestream-client: %u plans failed: %s\n", plans.failures, plans.last_failure.c_str());
}

}  // namespace

std::string to_csv(const std::vector<control::FlownFrame>& frames) {
    std::string out = "t_s,frame_ms,level,triangles,speed_deg_s,error_px,switched\n";
    for (const control::FlownFrame& frame : frames) {
        char row[192];
        std::snprintf(row, sizeof row, "%.6f,%.4f,%u,%llu,%.4f,%.4f,%d\n", frame.t_s, frame.frame_ms, frame.level,
                      static_cast<unsigned long long>(frame.triangles), frame.speed_deg_s, frame.error_px,
                      frame.switched ? 1 : 0);
        out += row;
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
    const auto scenery = fly::fetch_scenery(*client, arguments.asset);
    if (!scenery) return scenery.error();
    auto context = render::create_headless_context();
    if (!context) return context.error();
    auto renderer = render::Renderer::create();
    if (!renderer) return renderer.error();

    fly::PilotOptions options;
    options.kind = *kind;
    options.control.target_fps = arguments.target_fps;
    options.control.blur.enabled = arguments.blur;
    options.screen = {arguments.width, arguments.height, arguments.fov_y_deg};
    if (arguments.frames) {
        if (auto made = make_folder(*arguments.frames); !made) return made;
        options.on_frame = png_writer(*arguments.frames);
    }
    const auto costs = fly::measure_costs(*renderer, *scenery, options.screen);
    if (!costs) return costs.error();
    options.control.predictive.first_guess = *costs;
    auto plan = plan_of(arguments, options);
    if (!plan) return plan.error();
    if (*plan)
        options.budget = [&](const std::optional<control::DrawnFrame>& before) { return (*plan)->budget(before); };
    const auto frames = fly_scenery(*renderer, *scenery, *trace, options);
    if (!frames) return frames.error();
    if (auto written = write_text(arguments.out, to_csv(*frames)); !written) return written;
    print_line(arguments, control::summarize(*frames, options.control));
    if (*plan) print_plans((*plan)->finish());
    return Nothing{};
}

}  // namespace lodestream::client
