// lodestream_bench_frame_time: what a level's frame takes, predicted from the probe's figures alone, beside what it
// takes; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>

#include "client/probe/graphics.h"
#include "client/probe/load_meter.h"
#include "client/render/gl_context.h"
#include "common/mesh/operations.h"
#include "common/simplify/history.h"
#include "tests/bench/levels.h"
#include "tests/bench/table.h"
#include "tests/bench/value_of.h"

namespace lodestream::bench {
namespace {

namespace fs = std::filesystem;

constexpr budget::Display displays[] = {{320, 240}, {800, 600}, {1280, 1024}};
constexpr std::uint64_t level_triangles[] = {1'000, 4'000, 16'000, 64'000};
constexpr std::uint64_t most_triangles = 1'000'000;  // of a whole model that is drawn
constexpr double most_s = 0.4;                       // of a frame's runs
constexpr std::size_t enough_calm = 20, least_calm = 3, least_runs = 10;
constexpr int waking_frames = 2;

struct Arguments {
    std::vector<std::string> models;
    std::string data = "../shared/data";
    std::string csv;
};

enum class Mode { gouraud, flat, hybrid };
constexpr Mode modes[] = {Mode::gouraud, Mode::flat, Mode::hybrid};
constexpr const char* mode_names[] = {"gouraud", "flat", "hybrid"};

struct Row {
    std::string model;
    Mode mode = Mode::gouraud;
    budget::Display display;
    control::Work work;
    probe::Timing measured;
    bool calm = false;  // enough runs kept their cores
    double predicted_ms = 0.0;
    double off() const { return predicted_ms / measured.ms - 1.0; }
};

// As a client gets it: coded, and decoded in the coder's order. Hybrid: the half of the triangles that comes first.
codec::Decoded sent(const mesh::Model& model, const mesh::Mesh& level, Mode mode) {
    std::vector<std::uint8_t> gouraud(level.triangles.size(), mode == Mode::gouraud ? 1 : 0);
    if (mode == Mode::hybrid)
        std::fill_n(gouraud.begin(), static_cast<std::ptrdiff_t>(gouraud.size() / 2), std::uint8_t{1});
    codec::EncodeOptions options;
    options.grid = codec::fit_grid(mesh::bounds(level), level, 0.0, 0.0);
    options.lean = true;
    return value_of(codec::decode_level(value_of(codec::encode_level(model, level, gouraud, options)).glb));
}

class Bench {
  public:
    Bench() : context_(value_of(render::create_headless_context())), renderer_(value_of(render::Renderer::create())) {}

    // The probe anew for each model: a machine that others use is not equally fast all day.
    void compare(const std::string& name, const mesh::Model& model) {
        const probe::Graphics graphics = value_of(probe::measure_graphics(renderer_));
        const simplify::History history = record_history(model.mesh);
        Box bounds = mesh::bounds(model.mesh);
        bounds.min += model.origin;
        bounds.max += model.origin;
        const shading::View view = shading::framing_view(bounds);
        const std::uint64_t all = model.mesh.triangles.size();
        for (const std::uint64_t triangles : level_triangles)
            if (triangles < all) add(name, model, simplify::cut(history, triangles), view, graphics.costs);
        if (all <= most_triangles) add(name, model, model.mesh, view, graphics.costs);
    }

    const std::vector<Row>& rows() const { return rows_; }

  private:
    void add(const std::string& name, const mesh::Model& model, const mesh::Mesh& level, const shading::View& view,
             const control::FrameCosts& costs) {
        for (const Mode mode : modes) {
            const codec::Decoded content = sent(model, level, mode);
            value_of(renderer_.upload(content));
            for (const budget::Display& display : displays) {
                Row row{name, mode, display, probe::work_of(content, view, display), {}, false, 0.0};
                row.predicted_ms = control::frame_ms(costs, row.work);
                time(row, view);
                rows_.push_back(row);
            }
        }
    }

    void time(Row& row, const shading::View& view) {
        render::DrawOptions options;
        options.width = row.display.width;
        options.height = row.display.height;
        options.samples = 1;
        std::vector<probe::TimedRun> runs;
        std::size_t calm = 0;
        double passed_s = 0.0;
        for (int i = 0; calm < enough_calm && (passed_s < most_s || runs.size() < least_runs); ++i) {
            const double waited_ms = probe::waited_ms();
            const probe::TimedRun run{value_of(renderer_.draw(view, options)).frame_ms, probe::waited_ms() - waited_ms};
            if (i < waking_frames) continue;
            runs.push_back(run);
            passed_s += run.ms / 1000.0;
            calm += run.waited_ms <= probe::calm_share * run.ms ? 1 : 0;
        }
        row.measured = probe::timing_of(runs);
        row.calm = calm >= least_calm;
    }

    render::GlContext context_;
    render::Renderer renderer_;  // goes before the context
    std::vector<Row> rows_;
};

std::vector<std::string> default_models(const std::string& data) {
    std::vector<std::string> specs{"sample:teapot", "sample:terrain:200000", "sample:ship"};
    for (const std::string& file : files_below(
             data, {"classic/armadillo_86k.obj", "classic/beetle_39k.obj", "classic/bunny_69k.ply", "classic/cow.obj",
                    "classic/dragon_202k_res2.ply", "classic/fandisk.obj", "classic/homer.obj",
                    "classic/nefertiti_100k.obj", "classic/rocker-arm.obj", "classic/spot_uv.obj", "gltf/Duck.glb",
                    "gltf/dragon_attenuation.glb", "hard/capsule_uv/capsule.obj", "scan/eros_49k.ply",
                    "scan/turbineblade_199k.ply", "scene/CesiumMilkTruck.glb", "scene/carrier_truman.glb",
                    "scene/delft_city.glb", "terrain/stubai_10m.ply"}))
        specs.push_back(file);
    return specs;
}

// A share of the way through sorted |off|, in percent.
double quantile_percent(std::vector<double> off, double share) {
    if (off.empty()) return 0.0;
    std::sort(off.begin(), off.end());
    return 100.0 * off[static_cast<std::size_t>(share * static_cast<double>(off.size() - 1))];
}

std::string table_of(const std::vector<Row>& rows) {
    std::vector<std::string> order;
    std::map<std::string, std::vector<double>> groups;
    std::map<std::string, double> bias;
    std::size_t disturbed = 0;
    for (const Row& row : rows) {
        if (!row.calm) {
            ++disturbed;
            continue;
        }
        for (const std::string& group :
             {row.model, std::string(mode_names[static_cast<std::size_t>(row.mode)]),
              std::to_string(row.display.width) + "x" + std::to_string(row.display.height), std::string("all")}) {
            if (!groups.contains(group)) order.push_back(group);
            groups[group].push_back(std::abs(row.off()));
            bias[group] += row.off();
        }
    }
    std::sort(order.begin(), order.end(),
              [&](const auto& a, const auto& b) { return groups[a].size() < groups[b].size(); });
    std::vector<TableRow> table{{"frames of", "frames", "median off %", "90 % below", "worst", "mean"}};
    for (const std::string& group : order)
        table.push_back({group, std::to_string(groups[group].size()), fixed(quantile_percent(groups[group], 0.5), 1),
                         fixed(quantile_percent(groups[group], 0.9), 1), fixed(quantile_percent(groups[group], 1.0), 1),
                         fixed(100.0 * bias[group] / static_cast<double>(groups[group].size()), 1)});
    return to_text(table) + "\ntarget: median at most 10 % over all\nleft out, another process had their cores: " +
           std::to_string(disturbed) + " of " + std::to_string(rows.size()) + " frames\n";
}

void write_csv(const std::string& path, const std::vector<Row>& rows) {
    std::ofstream file(path);
    file << "model,shading,width,height,triangles,vertices,shaded_px,textured_px,extent_px,measured_ms,off_"
            "ms,runs,calm,"
            "predicted_ms\n";
    for (const Row& row : rows)
        file << row.model << ',' << mode_names[static_cast<std::size_t>(row.mode)] << ',' << row.display.width << ','
             << row.display.height << ',' << row.work.triangles << ',' << row.work.vertices << ',' << row.work.shaded_px
             << ',' << row.work.textured_px << ',' << row.work.extent_px << ',' << row.measured.ms << ','
             << row.measured.off_ms << ',' << row.measured.runs << ',' << row.measured.calm << ',' << row.predicted_ms
             << '\n';
    if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

void run(const Arguments& arguments) {
    Bench bench;
    for (const std::string& spec : arguments.models.empty() ? default_models(arguments.data) : arguments.models) {
        std::cerr << spec << std::endl;
        bench.compare(fs::path(spec).stem().string(), load_model(spec));
    }
    std::cout << table_of(bench.rows());
    if (!arguments.csv.empty()) write_csv(arguments.csv, bench.rows());
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    CLI::App app{"Predicts frame times from the probe's figures alone and compares them with the renderer's."};
    app.add_option("--models", arguments.models, "model files or sample:NAME; default: samples and those of --data");
    app.add_option("--data", arguments.data, "the folder of test models")->capture_default_str();
    app.add_option("--csv", arguments.csv, "every frame, one a row");
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_frame_time: " << error.what() << '\n';
        return 1;
    }
}
