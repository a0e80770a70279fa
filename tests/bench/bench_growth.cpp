// lodestream_bench_growth: bake time and memory over the size of the model; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>
#include <utility>

#include "tests/bench/copied_process.h"
#include "tests/bench/engine.h"
#include "tests/bench/fit.h"
#include "tests/bench/inputs.h"
#include "tests/bench/plots.h"
#include "tests/bench/stopwatch.h"
#include "tests/bench/table.h"

namespace lodestream::bench {
namespace {

struct Arguments {
    std::string data = "../shared/data";
    std::string csv_file, plot_file;
    std::vector<std::string> series{"terrain", "scan"};
    std::uint64_t max_triangles = 6'000'000;
    int rounds = 3;
};

struct GrowthResult {
    std::string series;
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    Duration record;  // median
    double bytes_per_vertex = 0.0;
};

constexpr double memory_target_bytes = 250.0;
// On smaller models the heaps of two threads would count as theirs.
constexpr std::uint64_t memory_least_vertices = 50'000;
// What timing noise may add to an exponent of 1.
constexpr double exponent_target = 1.05;

std::vector<std::string> specs_of(const std::string& series) {
    if (series == "scan") return {"made:86k", "made:346k", "made:1.4M", "made:5.5M"};
    std::vector<std::string> specs;
    for (const std::uint64_t vertices : {5'000, 15'000, 50'000, 150'000, 500'000, 1'500'000, 2'500'000})
        specs.push_back("sample:terrain:" + std::to_string(vertices));
    return specs;
}

Duration median_time(const mesh::Mesh& mesh, int rounds) {
    std::vector<double> wall, cpu;
    for (int round = 0; round < rounds; ++round) {
        mesh::Mesh own = mesh;
        const Stopwatch time;
        const Recording recording = record(std::move(own));
        const Duration took = time.elapsed();
        wall.push_back(took.wall_ms);
        cpu.push_back(took.cpu_ms);
    }
    return {percentile(wall, 0.5), percentile(cpu, 0.5)};
}

// In a copy of this process, whose heap stays as it was: the next model's memory is measured in it. Nothing where the
// model has more triangles than wanted.
std::optional<GrowthResult> measure_growth(const Arguments& arguments, const std::string& series,
                                           const std::string& spec) {
    GrowthResult result;
    result.series = series;
    const auto measure = [&](std::FILE* out) {
        const Result<Input> input = load_input(spec, arguments.data);
        if (!input) throw std::runtime_error(input.error().message);
        const std::uint64_t triangles = input->mesh.triangles.size(), vertices = input->mesh.positions.size();
        send_bytes(&triangles, sizeof triangles, out);
        send_bytes(&vertices, sizeof vertices, out);
        if (triangles > arguments.max_triangles) return;
        const Duration record = median_time(input->mesh, arguments.rounds);
        send_bytes(&record, sizeof record, out);
    };
    run_in_copy(measure, [&](std::FILE* in) {
        receive_bytes(&result.triangles, sizeof result.triangles, in);
        receive_bytes(&result.vertices, sizeof result.vertices, in);
        if (result.triangles <= arguments.max_triangles) receive_bytes(&result.record, sizeof result.record, in);
    });
    if (result.triangles > arguments.max_triangles) return std::nullopt;
    result.bytes_per_vertex =
        static_cast<double>(recording_peak_bytes(spec, arguments.data)) / static_cast<double>(result.vertices);
    return result;
}

double n_log_n(const GrowthResult& result) {
    const double n = static_cast<double>(result.triangles);
    return n * std::log2(n);
}

std::string growth_table(const std::vector<GrowthResult>& results) {
    std::vector<TableRow> rows{
        {"series", "triangles", "vertices", "wall ms", "CPU ms", "Mtri/s", "CPU ns / (n log2 n)", "bytes/vertex"}};
    for (const GrowthResult& r : results)
        rows.push_back({r.series, std::to_string(r.triangles), std::to_string(r.vertices), fixed(r.record.wall_ms, 0),
                        fixed(r.record.cpu_ms, 0), fixed(static_cast<double>(r.triangles) / r.record.wall_ms / 1e3, 3),
                        fixed(1e6 * r.record.cpu_ms / n_log_n(r), 2), fixed(r.bytes_per_vertex, 0)});
    return to_text(rows);
}

// The exponent p in t = c (n log n)^p: the slope of a line through the logarithms.
Line fit_growth(const std::vector<GrowthResult>& results, const std::string& series, double Duration::*time) {
    std::vector<Sample> samples;
    for (const GrowthResult& r : results)
        if (r.series == series) samples.push_back({std::log(n_log_n(r)), std::log(r.record.*time)});
    return fit_line(samples);
}

std::string fit_table(const std::vector<GrowthResult>& results, const std::vector<std::string>& series) {
    std::vector<TableRow> rows{{"series", "exponent of n log n, CPU", "wall", "R squared", "target", "verdict"}};
    for (const std::string& name : series) {
        const Line wall = fit_growth(results, name, &Duration::wall_ms);
        const Line cpu = fit_growth(results, name, &Duration::cpu_ms);
        rows.push_back({name, fixed(cpu.slope, 3), fixed(wall.slope, 3), fixed(cpu.r_squared, 4),
                        "<= " + fixed(exponent_target, 2), cpu.slope <= exponent_target ? "pass" : "FAIL"});
    }
    return to_text(rows);
}

void write_csv(const std::string& file, const std::vector<GrowthResult>& results) {
    std::ofstream out(file);
    out << "series,triangles,vertices,wall_ms,cpu_ms,peak_bytes_per_vertex\n";
    for (const GrowthResult& r : results)
        out << r.series << ',' << r.triangles << ',' << r.vertices << ',' << r.record.wall_ms << ',' << r.record.cpu_ms
            << ',' << r.bytes_per_vertex << '\n';
    if (!out) throw std::runtime_error("cannot write " + file);
}

// Through the smallest model of a series, growing as n log n does.
report::Series n_log_n_series(const report::Series& measured, const GrowthResult& first,
                              const std::vector<GrowthResult>& results) {
    report::Series series{measured.name + " if n log n", {}, true, false, true, measured.style};
    for (const GrowthResult& r : results)
        if (r.series == measured.name)
            series.points.push_back(
                {static_cast<double>(r.triangles), first.record.cpu_ms * n_log_n(r) / n_log_n(first), "n log n"});
    return series;
}

void write_plot(const std::string& file, const std::vector<GrowthResult>& results,
                const std::vector<std::string>& names) {
    using enum report::AxisScale;
    report::Plot time{"CPU time to record", {"triangles", logarithmic}, {"ms", logarithmic}, {}, {}};
    report::Plot memory{"Peak memory over the mesh", {"triangles", logarithmic}, {"bytes a vertex", linear}, {}, {}};
    for (std::size_t k = 0; k < names.size(); ++k) {
        report::Series times{names[k], {}, true, true, false, k}, bytes = times;
        for (const GrowthResult& r : results) {
            if (r.series != names[k]) continue;
            const double n = static_cast<double>(r.triangles);
            times.points.push_back({n, r.record.cpu_ms, brief(n) + " triangles: " + brief(r.record.cpu_ms) + " ms"});
            bytes.points.push_back({n, r.bytes_per_vertex, brief(r.bytes_per_vertex) + " bytes a vertex"});
        }
        const auto first = std::ranges::find(results, names[k], &GrowthResult::series);
        time.series.push_back(times);
        time.series.push_back(n_log_n_series(times, *first, results));
        memory.series.push_back(bytes);
    }
    write_plots(file, "Recording ever larger models", {time, memory});
}

void print_memory_verdict(const std::vector<GrowthResult>& results) {
    double most = 0;
    for (const GrowthResult& r : results)
        if (r.vertices >= memory_least_vertices) most = std::max(most, r.bytes_per_vertex);
    std::cout << "\nmost memory on at least " << memory_least_vertices << " vertices: " << fixed(most, 0)
              << " bytes a vertex; target <= " << fixed(memory_target_bytes, 0) << ": "
              << (most <= memory_target_bytes ? "pass" : "FAIL") << '\n';
}

void run(const Arguments& arguments) {
    std::vector<GrowthResult> results;
    for (const std::string& series : arguments.series)
        for (const std::string& spec : specs_of(series)) {
            std::cerr << spec << std::endl;
            std::optional<GrowthResult> result = measure_growth(arguments, series, spec);
            if (!result) break;
            results.push_back(*std::move(result));
        }
    std::cout << growth_table(results) << '\n' << fit_table(results, arguments.series);
    print_memory_verdict(results);
    if (!arguments.csv_file.empty()) write_csv(arguments.csv_file, results);
    if (!arguments.plot_file.empty()) write_plot(arguments.plot_file, results, arguments.series);
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    CLI::App app{"Records ever larger models: seeded terrain, and a scan with made detail."};
    app.add_option("--data", arguments.data, "the folder of test models")->capture_default_str();
    app.add_option("--series", arguments.series, "which models")
        ->delimiter(',')
        ->check(CLI::IsMember({"terrain", "scan"}))
        ->capture_default_str();
    app.add_option("--max-triangles", arguments.max_triangles, "larger models are left out")
        ->check(CLI::Range(350'000ull, 100'000'000ull))
        ->capture_default_str();
    app.add_option("--rounds", arguments.rounds, "runs of each model")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    app.add_option("--csv", arguments.csv_file, "where to write the numbers");
    app.add_option("--plot", arguments.plot_file, "where to write the plots, as a page");
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_growth: " << error.what() << std::endl;
        return 1;
    }
}
