// lodestream_bench_control: the report's flights, turn after turn, every controller with the real renderer; see
// README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "client/render/gl_context.h"
#include "client/report/measure_frame_rate.h"
#include "client/report/server_process.h"
#include "tests/bench/table.h"
#include "tests/bench/value_of.h"

namespace lodestream::bench {
namespace {

struct Arguments {
    std::string server;
    std::string csv;
    int turns = 5;
};

void write_frames(std::ofstream& file, int turn, const report::FlightResult& flight) {
    for (const control::FlownFrame& frame : flight.frames)
        file << turn << ',' << flight.controller << ',' << frame.t_s << ',' << frame.frame_ms << ','
             << frame.predicted_ms.value_or(0.0) << ',' << frame.level << ',' << frame.exposures << ','
             << frame.speed_deg_s << ',' << frame.error_px << ',' << frame.switched << '\n';
}

// Means over the turns, but for the worst frame.
std::vector<std::string> row_of(const std::vector<report::FrameRateResult>& turns, std::size_t kind) {
    control::FlightSummary sum;
    double image = 0.0, other = 0.0, least_within = 1.0;
    sum.worst_fps = turns.front().flights[kind].summary.worst_fps;
    for (const report::FrameRateResult& turn : turns) {
        const report::FlightResult& flight = turn.flights[kind];
        sum.average_fps += flight.summary.average_fps;
        sum.worst_fps = std::min(sum.worst_fps, flight.summary.worst_fps);
        sum.deviation_fps += flight.summary.deviation_fps;
        sum.deviation_ms += flight.summary.deviation_ms;
        sum.within_deadline += flight.summary.within_deadline;
        least_within = std::min(least_within, flight.summary.within_deadline);
        sum.switches += flight.summary.switches;
        sum.mean_level += flight.summary.mean_level;
        image += flight.image_error_percent;
        other += flight.other_cores.value_or(0.0);
    }
    const double count = static_cast<double>(turns.size());
    return {control::kind_name(control::kinds[kind]),
            fixed(sum.average_fps / count, 2),
            fixed(sum.worst_fps, 1),
            fixed(sum.deviation_fps / count, 2),
            fixed(sum.deviation_ms / count, 2),
            fixed(100.0 * sum.within_deadline / count, 2),
            fixed(100.0 * least_within, 2),
            fixed(sum.switches / count, 1),
            fixed(sum.mean_level / count, 2),
            fixed(image / count, 3),
            fixed(other / count, 2)};
}

std::string table_of(const std::vector<report::FrameRateResult>& turns) {
    std::vector<TableRow> table{{"controller", "fps", "worst", "deviation", "of frames, ms", "in time %", "least",
                                 "switches", "mean level", "picture off %", "other cores"}};
    for (std::size_t kind = 0; kind < std::size(control::kinds); ++kind) table.push_back(row_of(turns, kind));
    return to_text(table);
}

std::string scene_of(const report::FrameRateResult& turn) {
    std::string levels;
    for (const control::Level& level : turn.ladder) levels += " " + std::to_string(level.triangles);
    return turn.asset + ", " + fixed(turn.target_fps, 0) + " fps, " + std::to_string(turn.screen.width) + "x" +
           std::to_string(turn.screen.height) + " px, levels of" + levels + " triangles\n";
}

// What is flown over has to be there.
void wait_for_bakes(sdk::Client& client) {
    const auto bakes = [](const proto::Asset& asset) { return asset.status == proto::AssetStatus::baking; };
    for (;;) {
        const std::vector<proto::Asset> assets = value_of(client.assets());
        if (!assets.empty() && std::none_of(assets.begin(), assets.end(), bakes)) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
}

void run(const Arguments& arguments) {
    std::optional<report::ServerProcess> own;
    if (arguments.server.empty())
        own.emplace(value_of(report::ServerProcess::start(report::server_beside_this_program(), std::nullopt)));
    sdk::Client client = value_of(sdk::Client::open(own ? own->url() : arguments.server));
    wait_for_bakes(client);
    const render::GlContext context = value_of(render::create_headless_context());
    render::Renderer renderer = value_of(render::Renderer::create());
    std::ofstream csv;
    if (!arguments.csv.empty()) csv.open(arguments.csv);
    if (csv.is_open())
        csv << "turn,controller,t_s,frame_ms,predicted_ms,level,exposures,speed_deg_s,error_px,switched\n";
    const report::FrameRateOptions options{false, [](const std::string& step) {
                                               std::cerr << step << std::endl;
                                               return true;
                                           }};
    std::vector<report::FrameRateResult> turns;
    for (int turn = 0; turn < arguments.turns; ++turn) {
        turns.push_back(value_of(report::measure_flights(client, renderer, options)));
        for (const report::FlightResult& flight : turns.back().flights) write_frames(csv, turn, flight);
        std::cout << scene_of(turns.back()) << table_of({turns.back()}) << std::endl;
    }
    std::cout << "mean of " << turns.size() << " turns\n" << table_of(turns);
    if (csv.is_open() && !csv.flush()) throw std::runtime_error("cannot write " + arguments.csv);
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    CLI::App app{"Flies the report's scenario under every controller with the real renderer, turn after turn."};
    app.add_option("--server", arguments.server, "http://HOST:PORT; left out: one of its own with the samples");
    app.add_option("--turns", arguments.turns, "flights of each")->capture_default_str()->check(CLI::Range(1, 100));
    app.add_option("--csv", arguments.csv, "every frame, one a row");
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_control: " << error.what() << '\n';
        return 1;
    }
}
