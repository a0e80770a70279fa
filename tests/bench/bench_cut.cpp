// lodestream_bench_cut: any budget from one bake; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iostream>
#include <random>

#include "tests/bench/engine.h"
#include "tests/bench/fit.h"
#include "tests/bench/inputs.h"
#include "tests/bench/plots.h"
#include "tests/bench/stopwatch.h"
#include "tests/bench/table.h"

namespace lodestream::bench {
namespace {

struct Arguments {
    std::string model = "made:1.4M";
    std::string data = "../shared/data";
    std::string csv_file, plot_file;
    int budgets = 1'000;
    int rounds = 5;
    std::uint64_t max_triangles = 10'000;
    std::uint64_t seed = 1;
};

struct CutResult {
    std::uint64_t asked = 0;
    std::uint64_t triangles = 0;
    Duration median;      // over the rounds
    double least_ms = 0;  // of CPU time: the cut without what other programs and cold caches add
};

constexpr double median_target_ms = 5.0;

std::vector<std::uint64_t> random_budgets(const Arguments& arguments) {
    std::mt19937_64 random(arguments.seed);
    std::vector<std::uint64_t> budgets;
    for (int k = 0; k < arguments.budgets; ++k) budgets.push_back(1 + random() % arguments.max_triangles);
    return budgets;
}

// All budgets in turn, round after round, so that no cut profits from the same one just before.
std::vector<CutResult> timed_cuts(const Recording& recording, const std::vector<std::uint64_t>& budgets, int rounds) {
    std::vector<std::vector<double>> wall(budgets.size()), cpu(budgets.size());
    std::vector<CutResult> results(budgets.size());
    for (int round = 0; round < rounds; ++round)
        for (std::size_t k = 0; k < budgets.size(); ++k) {
            const Stopwatch time;
            const mesh::Mesh level = cut(recording, budgets[k]);
            const Duration took = time.elapsed();
            wall[k].push_back(took.wall_ms);
            cpu[k].push_back(took.cpu_ms);
            results[k] = {budgets[k], level.triangles.size(), {}, 0.0};
        }
    for (std::size_t k = 0; k < budgets.size(); ++k) {
        results[k].median = {percentile(wall[k], 0.5), percentile(cpu[k], 0.5)};
        results[k].least_ms = percentile(cpu[k], 0.0);
    }
    return results;
}

// N, or N - 1, or the floor below which the engine does not go.
bool is_exact(const CutResult& result, std::uint64_t floor) {
    return result.triangles == result.asked || result.triangles + 1 == result.asked || result.triangles == floor;
}

void write_csv(const std::string& file, const std::vector<CutResult>& results) {
    std::ofstream out(file);
    out << "asked,triangles,median_wall_ms,median_cpu_ms,least_cpu_ms\n";
    for (const CutResult& r : results)
        out << r.asked << ',' << r.triangles << ',' << r.median.wall_ms << ',' << r.median.cpu_ms << ',' << r.least_ms
            << '\n';
    if (!out) throw std::runtime_error("cannot write " + file);
}

// CPU time over triangles.
std::vector<Sample> time_over_count(const std::vector<CutResult>& results) {
    std::vector<Sample> samples;
    for (const CutResult& r : results) samples.push_back({static_cast<double>(r.triangles), r.least_ms});
    return samples;
}

void write_plot(const std::string& file, const std::string& model, const std::vector<CutResult>& results) {
    const std::vector<Sample> samples = time_over_count(results);
    const Line line = fit_line(samples);
    report::Series cuts{"cuts", {}, false, true, false, {}};
    for (const Sample& s : samples) cuts.points.push_back({s.x, s.y, brief(s.x) + " triangles: " + brief(s.y) + " ms"});
    report::Series fitted{"line", {}, true, false, false, {}};
    const auto by_x = [](const Sample& a, const Sample& b) { return a.x < b.x; };
    const auto [least, most] = std::minmax_element(samples.begin(), samples.end(), by_x);
    for (const double x : {least->x, most->x}) fitted.points.push_back({x, line.intercept + line.slope * x, "line"});
    write_plots(file, "Cuts of " + model,
                {{"CPU time of a cut over its triangles, R squared " + fixed(line.r_squared, 3),
                  {"triangles", report::AxisScale::linear},
                  {"ms", report::AxisScale::linear},
                  {cuts, fitted},
                  {}}});
}

void print(const std::vector<CutResult>& results, std::uint64_t floor) {
    std::vector<double> wall, cpu;
    std::uint64_t equal = 0, one_less = 0, inexact = 0;
    for (const CutResult& r : results) {
        wall.push_back(r.median.wall_ms);
        cpu.push_back(r.median.cpu_ms);
        equal += r.triangles == r.asked ? 1 : 0;
        one_less += r.triangles + 1 == r.asked ? 1 : 0;
        inexact += is_exact(r, floor) ? 0 : 1;
    }
    const Line line = fit_line(time_over_count(results));
    const double median = percentile(wall, 0.5);
    std::cout << to_text({{"what", "value", "target", "verdict"},
                          {"cut, median ms", brief(median), "< 5", median < median_target_ms ? "pass" : "FAIL"},
                          {"cut, 95th percentile ms", brief(percentile(wall, 0.95)), "", ""},
                          {"cut, median ms of CPU", brief(percentile(cpu, 0.5)), "", ""},
                          {"cut, 95th percentile ms of CPU", brief(percentile(cpu, 0.95)), "", ""},
                          {"cut, longest ms", brief(percentile(wall, 1.0)), "", ""},
                          {"floor, triangles", std::to_string(floor), "", ""},
                          {"budgets met with N", std::to_string(equal), "", ""},
                          {"budgets met with N-1", std::to_string(one_less), "", ""},
                          {"neither, nor the floor", std::to_string(inexact), "0", inexact == 0 ? "pass" : "FAIL"},
                          {"line: ms at no triangles", brief(line.intercept), "", ""},
                          {"line: ms per 1,000 triangles", brief(1e3 * line.slope), "", ""},
                          {"line: R squared", fixed(line.r_squared, 3), "", ""}});
}

void run(const Arguments& arguments) {
    const Result<Input> input = load_input(arguments.model, arguments.data);
    if (!input) throw std::runtime_error(input.error().message);
    const Stopwatch recording_time;
    const Recording recording = record(input->mesh);
    std::cout << input->name << ": " << input->mesh.triangles.size() << " triangles, recorded in "
              << fixed(recording_time.elapsed().wall_ms, 0) << " ms\n";
    const std::uint64_t floor = cut(recording, 1).triangles.size();
    const std::vector<CutResult> results = timed_cuts(recording, random_budgets(arguments), arguments.rounds);
    print(results, floor);
    if (!arguments.csv_file.empty()) write_csv(arguments.csv_file, results);
    if (!arguments.plot_file.empty()) write_plot(arguments.plot_file, input->name, results);
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    CLI::App app{"Records one model and cuts random budgets from it: how long, how exact, how the time grows with N."};
    app.add_option("--model", arguments.model, "a file, \"made:1.4M\" or \"sample:terrain:40000\"")
        ->capture_default_str();
    app.add_option("--data", arguments.data, "the folder of test models")->capture_default_str();
    app.add_option("--budgets", arguments.budgets, "how many")->check(CLI::Range(2, 1'000'000))->capture_default_str();
    app.add_option("--rounds", arguments.rounds, "cuts of each budget")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    app.add_option("--max-triangles", arguments.max_triangles, "the largest")
        ->check(CLI::Range(2ull, 100'000'000ull))
        ->capture_default_str();
    app.add_option("--seed", arguments.seed, "of the random budgets")->capture_default_str();
    app.add_option("--csv", arguments.csv_file, "where to write asked, reached and time of every cut");
    app.add_option("--plot", arguments.plot_file, "where to write the plot, as a page");
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_cut: " << error.what() << std::endl;
        return 1;
    }
}
