#include "client/view_command.h"

#include <cmath>
#include <cstdio>
#include <string>

#include "client/files.h"
#include "client/render/gl_context.h"
#include "client/render/renderer.h"
#include "client/sdk/client.h"

namespace lodestream::client {
namespace {

constexpr std::uint32_t timed_frames = 5;

struct Drawn {
    render::Frame frame;
    render::UploadStatistics uploaded;
    std::string renderer;
};

// framing_view() fits the height; a picture that is taller than wide needs the eye farther away.
shading::View fit(const Box& bounds, const budget::Display& display) {
    shading::View view = shading::framing_view(bounds);
    if (display.width >= display.height) return view;
    const double half_height = radians(view.fov_y_deg) / 2.0;
    const double half_width = std::atan(std::tan(half_height) * display.width / display.height);
    view.eye = view.target + (view.eye - view.target) * (std::sin(half_height) / std::sin(half_width));
    return view;
}

Result<proto::PlanRequest> make_request(sdk::Client& client, const ViewArguments& arguments) {
    auto request = read_device_file(arguments.device);
    if (!request) return request;
    const auto shading = proto::parse_shading_mode(arguments.shading);
    if (!shading) return shading.error();
    request->asset = arguments.asset;
    request->shading = *shading;
    if (arguments.primitives) {
        const auto primitives = proto::parse_primitives(*arguments.primitives);
        if (!primitives) return primitives.error();
        request->primitives = *primitives;
    }
    if (arguments.profile)
        request->profile = *arguments.profile == "lean" ? proto::Profile::lean : proto::Profile::plain;
    budget::Display display = request->budget.display.value_or(shading::default_display);
    display.width = arguments.width.value_or(display.width);
    display.height = arguments.height.value_or(display.height);
    request->budget.display = display;
    const auto asset = client.find_asset(arguments.asset);
    if (!asset) return asset.error();
    if (asset->kind == "points") request->primitives = proto::Primitives::points;
    if (request->view) return request;
    if (asset->bounds_min && asset->bounds_max) {
        const auto& low = *asset->bounds_min;
        const auto& high = *asset->bounds_max;
        Box bounds;
        bounds.add({low[0], low[1], low[2]});
        bounds.add({high[0], high[1], high[2]});
        request->view = fit(bounds, display);
    }
    return request;
}

Result<Drawn> draw(const sdk::Loaded& loaded, const shading::View& view, const budget::Display& display) {
    auto context = render::create_headless_context();
    if (!context) return context.error();
    auto renderer = render::Renderer::create();
    if (!renderer) return renderer.error();
    const auto uploaded = loaded.points ? renderer->upload(*loaded.points) : renderer->upload(loaded.content);
    if (!uploaded) return uploaded.error();
    render::DrawOptions options;
    options.width = display.width;
    options.height = display.height;
    options.frames = timed_frames;
    auto frame = renderer->draw(view, options);
    if (!frame) return frame.error();
    Result<Drawn> drawn(Drawn{*std::move(frame), *uploaded, context->renderer()});
    drawn.warnings = uploaded.warnings;
    return drawn;
}

// Quotes and escapes; what is printed here came over the network or the command line.
std::string json_string(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20) {
            char escaped[8];
            std::snprintf(escaped, sizeof escaped, "\\u%04x", byte);
            out += escaped;
            continue;
        }
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + '"';
}

void print_json(const sdk::Loaded& loaded, const Drawn& drawn, const ViewArguments& arguments) {
    std::printf("{\"asset\":%s,\"plan\":%s,\"triangles\":%llu,\"points\":%llu,\"bytes\":%llu,",
                json_string(arguments.asset).c_str(), proto::to_json(loaded.plan).c_str(),
                static_cast<unsigned long long>(drawn.uploaded.triangles),
                static_cast<unsigned long long>(drawn.uploaded.points), static_cast<unsigned long long>(loaded.bytes));
    std::printf("\"timing_ms\":{\"plan\":%.3f,\"fetch\":%.3f,\"decode\":%.3f},\"frame_ms\":%.3f,\"draw_calls\":%u,",
                loaded.timing.plan_ms, loaded.timing.fetch_ms, loaded.timing.decode_ms, drawn.frame.frame_ms,
                drawn.frame.draw_calls);
    std::printf("\"renderer\":%s,\"image\":%s,\"width\":%u,\"height\":%u}\n", json_string(drawn.renderer).c_str(),
                json_string(arguments.out.string()).c_str(), drawn.frame.image.width, drawn.frame.image.height);
}

void print_line(const sdk::Loaded& loaded, const Drawn& drawn, const ViewArguments& arguments) {
    const proto::PlanResponse& plan = loaded.plan;
    if (loaded.points)
        std::printf("%s: %llu points (limited by %s)", arguments.asset.c_str(),
                    static_cast<unsigned long long>(plan.level.points), plan.budget.limited_by.c_str());
    else
        std::printf("%s: %llu triangles (budget %llu by %s; %llu Gouraud, %llu flat)", arguments.asset.c_str(),
                    static_cast<unsigned long long>(plan.level.triangles),
                    static_cast<unsigned long long>(plan.budget.triangles), plan.budget.limited_by.c_str(),
                    static_cast<unsigned long long>(plan.shading.gouraud),
                    static_cast<unsigned long long>(plan.shading.flat));
    std::printf(", %llu bytes, error %.2f px, plan %.1f ms, fetch %.1f ms, decode %.1f ms, frame %.1f ms → %s\n",
                static_cast<unsigned long long>(loaded.bytes), plan.level.screen_space_error_px, loaded.timing.plan_ms,
                loaded.timing.fetch_ms, loaded.timing.decode_ms, drawn.frame.frame_ms, arguments.out.string().c_str());
}

}  // namespace

Status view(const ViewArguments& arguments) {
    auto client = sdk::Client::open(arguments.server);
    if (!client) return client.error();
    const auto request = make_request(*client, arguments);
    if (!request) return request.error();
    const auto loaded = client->load(*request);
    if (!loaded) return loaded.error();
    const budget::Display display = *request->budget.display;
    const auto bounds = [&] {
        return loaded->points ? render::world_bounds(*loaded->points) : render::world_bounds(loaded->content);
    };
    const shading::View seen = request->view ? *request->view : shading::framing_view(bounds());
    const auto drawn = draw(*loaded, seen, display);
    if (!drawn) return drawn.error();
    if (auto written = render::write_png(arguments.out, drawn->frame.image); !written) return written;
    for (const std::string& warning : loaded->plan.warnings)
        std::fprintf(stderr, "lodestream-client: %s\n", warning.c_str());
    for (const std::string& warning : drawn.warnings) std::fprintf(stderr, "lodestream-client: %s\n", warning.c_str());
    if (arguments.json)
        print_json(*loaded, *drawn, arguments);
    else
        print_line(*loaded, *drawn, arguments);
    return Nothing{};
}

}  // namespace lodestream::client
