// The `lodestream-server` program: reads the command line and calls the command.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <optional>

#include "server/cli/commands.h"

namespace {

using namespace lodestream;

constexpr int exit_failed = 1;
constexpr int exit_usage = 2;

constexpr double bytes_per_mb = 1e6;

void add_limits(CLI::App* app, bake::Limits& limits) {
    app->add_option("--max-bake-s", limits.max_bake_s, "Seconds that one bake may take")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
    app->add_option_function<double>(
           "--max-memory-mb",
           [&limits](double mb) { limits.max_memory_bytes = static_cast<std::uint64_t>(mb * bytes_per_mb); },
           "Memory that one bake may need; left out: three quarters of the machine's")
        ->check(CLI::Range(1.0, 1e9));
}

int run(int argc, char** argv) {
    CLI::App app{
        "Lodestream server: one model, every device. Bakes 3D models and serves each device the level it can show."};
    app.set_version_flag("--version", "lodestream-server " LODESTREAM_VERSION);
    app.require_subcommand(1);
    app.footer(
        "Examples:\n"
        "  lodestream-server serve --listen 127.0.0.1:8080 --store ./store --samples\n"
        "  lodestream-server bake bunny.ply sample:teapot --store ./store --json\n"
        "  lodestream-server cut --store ./store --asset bunny --triangles 1000 --out bunny-1000.glb\n"
        "Run 'lodestream-server COMMAND --help' for one command's options.");
    std::function<Status()> command;

    cli::ServeArguments serve;
    CLI::App* serve_app = app.add_subcommand("serve", "Serve assets over HTTP until SIGINT or SIGTERM");
    serve_app->add_option("--listen", serve.listen, "HOST:PORT; port 0 takes a free one")->capture_default_str();
    serve_app->add_option("--store", serve.store, "Folder of the store; made where missing")->required();
    serve_app->add_option("--assets", serve.assets, "Folder of models, imported at start and watched");
    serve_app->add_flag("--samples", serve.samples, "Also serve the built-in teapot, terrain and ship");
    serve_app->add_option("--threads", serve.threads, "Threads that serve; 0: one a core")->check(CLI::Range(0, 1024));
    serve_app->add_option("--token-file", serve.token_file, "File with the token that uploads and removals need");
    add_limits(serve_app, serve.limits);
    serve_app->set_config("--config", "", "File with these options as KEY=VALUE lines (TOML or INI)");
    serve_app->callback([&] { command = [&] { return cli::serve(serve); }; });

    cli::BakeArguments bake;
    CLI::App* bake_app = app.add_subcommand("bake", "Import and bake models without a server");
    bake_app->add_option("INPUT", bake.inputs,
                         "Model files, or sample:teapot[:TRIANGLES], sample:terrain[:VERTICES], sample:ship[:OBJECTS], "
                         "sample:fine-ship[:OBJECTS]");
    bake_app->add_option("--store", bake.store, "Folder of the store; made where missing")->required();
    bake_app->add_flag("--json", bake.json, "Print one JSON object an input");
    bake_app->add_flag("--resume", bake.resume, "First go on with bakes that a crash or stop cut off");
    add_limits(bake_app, bake.limits);
    bake_app->callback([&] {
        if (bake.inputs.empty() && !bake.resume) throw CLI::RequiredError("INPUT");
        command = [&] { return cli::bake(bake); };
    });

    cli::CutArguments cut;
    CLI::App* cut_app = app.add_subcommand("cut", "Write the level of at most N triangles or points of a baked asset");
    cut_app->add_option("--store", cut.store, "Folder of the store")->required();
    cut_app->add_option("--asset", cut.asset, "The asset's name")->required();
    auto* cut_budget = cut_app->add_option_group("budget")->require_option(1);
    cut_budget->add_option("--triangles", cut.triangles, "The budget")->check(CLI::PositiveNumber);
    cut_budget->add_option("--points", cut.points, "The budget of a level of points")->check(CLI::PositiveNumber);
    cut_app->add_option("--out", cut.out, "FILE.glb or FILE.ply")->required();
    cut_app->add_flag("--json", cut.json, "Print the figures as JSON");
    cut_app->callback([&] { command = [&] { return cli::cut(cut); }; });

    cli::TilesetArguments tileset;
    CLI::App* tileset_app = app.add_subcommand(
        "tileset", "Write a baked asset as a 3D Tiles 1.1 tileset: a scene's tiles, or the levels of a single object");
    tileset_app->add_option("--store", tileset.store, "Folder of the store")->required();
    tileset_app->add_option("--asset", tileset.asset, "The asset's name")->required();
    tileset_app->add_option("--out", tileset.out, "Folder to write, or one archive FILE.3tz")->required();
    tileset_app->footer(
        "\nExamples:\n"
        "  lodestream-server tileset --store ./store --asset ship --out ./ship-tiles\n"
        "  lodestream-server tileset --store ./store --asset ship --out ship.3tz");
    tileset_app->callback([&] { command = [&] { return cli::tileset(tileset); }; });

    cli::SampleArguments sample;
    CLI::App* sample_app = app.add_subcommand("sample", "Write a built-in model to a file");
    sample_app
        ->add_option("NAME", sample.sample,
                     "teapot[:TRIANGLES], terrain[:VERTICES], ship[:OBJECTS] or fine-ship[:OBJECTS]")
        ->required();
    sample_app->add_option("--out", sample.out, "FILE.glb or FILE.ply")->required();
    sample_app->callback([&] { command = [&] { return cli::sample(sample); }; });

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : exit_usage;
    }
    const Status done = command();
    if (done) return 0;
    std::fprintf(stderr, "lodestream-server: %s\n", done.error().message.c_str());
    return exit_failed;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "lodestream-server: %s\n", error.what());
        return exit_failed;
    }
}
