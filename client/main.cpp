// The `lodestream-client` program: reads the command line and calls the command.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>

#include "client/fly_command.h"
#include "client/probe/probe.h"
#include "client/render/image.h"
#include "client/report/machine.h"
#include "client/report/report.h"
#include "client/roam_command.h"
#include "client/sdk/client.h"
#include "client/view_command.h"

namespace {

using namespace lodestream;

constexpr int exit_failed = 1;
constexpr int exit_usage = 2;

Status print_probe(bool json) {
    const auto report = probe::measure();
    if (!report) return report.error();
    std::fputs(json ? (probe::to_json(*report) + "\n").c_str() : probe::to_text(*report).c_str(), stdout);
    return Nothing{};
}

int run(int argc, char** argv) {
    CLI::App app{"Lodestream client: shows and measures what a device gets of a 3D asset."};
    app.set_version_flag("--version", "lodestream-client " LODESTREAM_VERSION);
    app.require_subcommand(1);
    app.footer(
        "Examples:\n"
        "  lodestream-client view --server http://127.0.0.1:8080 --asset teapot --device deploy/devices/pda.json --out "
        "pda.png\n"
        "  lodestream-client view --server http://127.0.0.1:8080 --asset teapot --device deploy/devices/phone.json \\\n"
        "      --out flat.png --width 320 --height 240 --shading flat --json\n"
        "  lodestream-client probe --json > this-device.json\n"
        "  lodestream-client fly --server http://127.0.0.1:8080 --asset teapot --motion builtin:mix --out flight.csv\n"
        "  lodestream-client roam --server http://127.0.0.1:8080 --asset ship --out tour.csv --frames tour\n"
        "  lodestream-client report --out report --quick\n"
        "Run 'lodestream-client COMMAND --help' for one command's options.");
    std::function<Status()> command;

    const CLI::Validator is_server(
        [](const std::string& url) {
            const auto parsed = sdk::parse_server_url(url);
            return parsed ? std::string() : parsed.error().message;
        },
        "URL");
    client::ViewArguments view;
    const CLI::Range sides(1u, image::max_side);
    CLI::App* view_app = app.add_subcommand("view", "Draw an asset as a device gets it into a PNG file");
    view_app->add_option("--server", view.server, "http://HOST:PORT")->required()->check(is_server);
    view_app->add_option("--asset", view.asset, "Name or id of the asset")->required();
    view_app->add_option("--device", view.device, "Device file: {\"device\":{\"cpu_mhz\":…},\"display\":{…},…}")
        ->required();
    view_app->add_option("--out", view.out, "The picture, FILE.png")->required();
    view_app->add_option("--width", view.width, "px; left out: the device's display, else 800")->check(sides);
    view_app->add_option("--height", view.height, "px; left out: the device's display, else 600")->check(sides);
    view_app->add_option("--shading", view.shading, "hybrid as planned, or all triangles alike to compare with")
        ->capture_default_str()
        ->check(CLI::IsMember({"hybrid", "gouraud", "flat"}));
    view_app->add_option("--profile", view.profile, "lean: fewer bytes, for this client; plain: what any viewer reads")
        ->check(CLI::IsMember({"plain", "lean"}));
    view_app
        ->add_option("--primitives", view.primitives, "What the level may be made of: points for the weakest devices")
        ->check(CLI::IsMember({"triangles", "points", "any"}));
    view_app->add_flag("--json", view.json, "Print plan, triangles, bytes and times as JSON");
    view_app->footer(
        "Example:\n  lodestream-client view --server http://127.0.0.1:8080 --asset teapot \\\n"
        "      --device deploy/devices/pda.json --out pda.png");
    view_app->callback([&] { command = [&] { return client::view(view); }; });

    bool probe_json = false;
    CLI::App* probe_app = app.add_subcommand("probe", "Measure this device, in at most three seconds");
    probe_app->add_flag("--json", probe_json, "Print a device file, as view --device and a plan take it");
    probe_app->footer("Example:\n  lodestream-client probe --json > this-device.json");
    probe_app->callback([&] { command = [&] { return print_probe(probe_json); }; });

    client::FlyArguments fly;
    CLI::App* fly_app = app.add_subcommand("fly", "Fly a motion over an asset, its level chosen frame by frame");
    fly_app->add_option("--server", fly.server, "http://HOST:PORT")->required()->check(is_server);
    fly_app->add_option("--asset", fly.asset, "Name or id of the asset")->required();
    fly_app
        ->add_option("--motion", fly.motion,
                     "FILE.csv with rows t_s,x,y,z,yaw_deg,pitch_deg, or builtin: and one of still, start, stop, "
                     "reversal, nod, circle, mix")
        ->required();
    fly_app->add_option("--controller", fly.controller, "Who chooses the level")
        ->capture_default_str()
        ->check(CLI::IsMember({"none", "sblc", "isblc", "acceleration", "reactive", "predictive"}));
    fly_app->add_option("--target-fps", fly.target_fps, "Frames a second to hold")
        ->capture_default_str()
        ->check(CLI::Range(control::min_target_fps, control::max_target_fps));
    fly_app->add_option("--out", fly.out, "The flight, FILE.csv")->required();
    fly_app->add_option("--device", fly.device,
                        "Device file: a plan bounds the levels of `predictive`, asked for anew where the frames' times "
                        "say that the device has become faster or slower");
    fly_app->add_option("--frames", fly.frames, "Folder for a PNG of every frame");
    fly_app->add_option("--width", fly.width, "px")->capture_default_str()->check(sides);
    fly_app->add_option("--height", fly.height, "px")->capture_default_str()->check(sides);
    fly_app->add_option("--fov", fly.fov_y_deg, "Vertical field of view, degrees")
        ->capture_default_str()
        ->check(CLI::Range(shading::min_fov_deg, shading::max_fov_deg));
    CLI::Option* fly_shading = fly_app->add_option(
        "--shading", fly.shading,
        "hybrid: how many triangles of a level are Gouraud shaded follows the viewer's distance, without a download; "
        "gouraud: all");
    fly_shading->capture_default_str()->check(CLI::IsMember({"gouraud", "hybrid"}));
    fly_app
        ->add_option("--split-bound", fly.split_bound_steps,
                     "The most that hybrid may change a picture by moving the border in one frame, whatever the light: "
                     "root mean square, in steps of 255")
        ->capture_default_str()
        ->check(CLI::Range(0.01, 255.0))
        ->needs(fly_shading);
    fly_app->add_flag("!--no-blur", fly.blur, "No motion blur: one exposure a frame however fast the view turns");
    fly_app->footer(
        "Examples:\n  lodestream-client fly --server http://127.0.0.1:8080 --asset teapot \\\n"
        "      --motion builtin:reversal --controller isblc --target-fps 30 --out flight.csv\n"
        "  printf 't_s,x,y,z,yaw_deg,pitch_deg\\n0,0,2,8,0,0\\n3,0,2,90,0,0\\n' > away.csv\n"
        "  lodestream-client fly --server http://127.0.0.1:8080 --asset teapot --motion away.csv --shading hybrid \\\n"
        "      --out flight.csv");
    fly_app->callback([&] { command = [&] { return client::fly(fly); }; });

    // Which CLI::Range does not ask.
    const CLI::Validator is_number(
        [](const std::string& text) {
            return std::isnan(std::strtod(text.c_str(), nullptr)) ? "must be a number" : std::string();
        },
        "");
    client::RoamArguments roam;
    CLI::App* roam_app = app.add_subcommand(
        "roam", "Move through a scene whose tiles come meanwhile, its levels fading into each other");
    roam_app->add_option("--server", roam.server, "http://HOST:PORT")->required()->check(is_server);
    roam_app->add_option("--asset", roam.asset, "Name or id of the asset")->required();
    roam_app->add_option("--motion", roam.motion,
                         "FILE.csv with rows t_s,x,y,z,yaw_deg,pitch_deg, or builtin:NAME as for fly; left out: a tour "
                         "past the scene, from afar close up and away again");
    roam_app->add_option("--out", roam.out, "A row of numbers a frame, FILE.csv")->required();
    roam_app->add_option("--frames", roam.frames, "Folder for a PNG of every frame");
    roam_app->add_option("--width", roam.width, "px")->capture_default_str()->check(sides);
    roam_app->add_option("--height", roam.height, "px")->capture_default_str()->check(sides);
    roam_app->add_option("--fov", roam.fov_y_deg, "Vertical field of view, degrees")
        ->capture_default_str()
        ->check(is_number & CLI::Range(shading::min_fov_deg, shading::max_fov_deg));
    roam_app->add_option("--fps", roam.fps, "Frames a second of the motion")
        ->capture_default_str()
        ->check(is_number & CLI::Range(roam::min_fps, roam::max_fps));
    roam_app->add_option("--tolerance-px", roam.tolerance_px, "Error on the screen that is not worth a finer tile")
        ->capture_default_str()
        ->check(is_number & CLI::Range(0.0, 1e6));
    roam_app->add_option("--triangles", roam.triangles,
                         "Triangles in view that may be asked for, the largest errors first; left out: any number");
    roam_app->add_option("--memory-mb", roam.memory_mb, "What all tiles together may take on the GPU")
        ->capture_default_str()
        ->check(is_number & CLI::Range(0.0, 1e6));
    roam_app->add_option("--fade-ms", roam.fade_ms, "How long a level fades into the next; 0: it pops")
        ->capture_default_str()
        ->check(is_number & CLI::Range(0.0, 1e6));
    roam_app->add_flag("!--no-prefetch", roam.looks_ahead, "Fetch nothing ahead of the motion");
    roam_app->add_option("--rtt-ms", roam.link.rtt_ms, "As if the server were so far away")
        ->capture_default_str()
        ->check(is_number & CLI::Range(0.0, 1e5));
    roam_app->add_option("--downlink-mbps", roam.link.downlink_mbps, "As if tiles came no faster; 0: as they come")
        ->capture_default_str()
        ->check(is_number & CLI::Range(0.0, 1e6));
    roam_app->add_flag("--json", roam.json, "Print what was met as JSON");
    roam_app->footer(
        "Popping is what a change of levels alone changes in a pixel, in steps of 255: the levels of the frame before\n"
        "are drawn once more in each frame's view.\n"
        "Examples:\n"
        "  lodestream-client roam --server http://127.0.0.1:8080 --asset ship --out tour.csv --frames tour\n"
        "  lodestream-client roam --server http://127.0.0.1:8080 --asset ship --rtt-ms 80 --downlink-mbps 10 \\\n"
        "      --triangles 50000 --memory-mb 16 --fade-ms 0 --no-prefetch --out phone.csv --json");
    roam_app->callback([&] { command = [&] { return client::roam(roam); }; });

    report::ReportOptions report;
    report.command_line = report::joined(argc, argv);
    CLI::App* report_app =
        app.add_subcommand("report", "Error against run time for every stage, as report.html and report.json");
    report_app->add_option("--out", report.out, "Folder to write; made where missing")->required();
    CLI::Option* assets =
        report_app->add_option("--assets", report.assets, "Folder of models to add to the built-in samples");
    report_app->add_option("--server", report.server_url, "http://HOST:PORT; left out: a server of its own")
        ->check(is_server)
        ->excludes(assets);
    report_app->add_option("--methods", report.methods,
                           "What `lodestream_bench_simplify --json FILE` wrote: adds the peers of simplification");
    report_app->add_option("--codecs", report.codecs,
                           "What `lodestream_bench_codec --sweep FILE` wrote: adds other codecs at equal error");
    report_app->add_option("--points", report.points,
                           "What `lodestream_bench_points --json FILE` wrote: adds the point-cloud paper's tests");
    report_app->add_option(
        "--scenes", report.scenes,
        "What `lodestream_bench_hlod --growth COUNTS --json FILE` wrote: adds bakes of growing scenes");
    report_app->add_flag("--quick", report.quick, "Fewer and smaller models, fewer frames");
    report_app->add_flag("--json", report.json, "Print report.json instead of the table");
    report_app->footer("Example:\n  lodestream-client report --out report --quick");
    report_app->callback([&] { command = [&] { return report::run(report); }; });

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : exit_usage;
    }
    const Status done = command();
    if (done) return 0;
    std::fprintf(stderr, "lodestream-client: %s\n", done.error().message.c_str());
    return exit_failed;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "lodestream-client: %s\n", error.what());
        return exit_failed;
    }
}
