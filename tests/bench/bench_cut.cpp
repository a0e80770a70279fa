// lodestream_bench_cut: any budget from one bake; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iostream>
#include <random>

#include "tests/bench/engine.h"
#include "tests/bench/fit.h"
#include "tests/bench/inputs.h"
#include "tests/bench/stopwatch.h"
#include "tests/bench/table.h"

namespace lodestream::bench {
namespace {

struct Arguments {
    std::string model = "made:1.4M";
    std::string data = "../shared/data";
    std::string csv_file;
    int budgets = 1'000;
    std::uint64_t max_triangles = 10'000;
    std::uint64_t seed = 1;
};

struct CutResult {
    std::uint64_t asked = 0;
    std::uint64_t triangles = 0;
    double wall_ms = 0.0;
};

constexpr double median_target_ms = 5.0;

std::vector<std::uint64_t> random_budgets(const Arguments& arguments) {
    std::mt19937_64 random(arguments.seed);
    std::vector<std::uint64_t> budgets;
    for (int k = 0; k < arguments.budgets; ++k) budgets.push_back(1 + random() % arguments.max_triangles);
    return budgets;
}

CutResult timed_cut(const Recording& recording, std::uint64_t budget) {
    const Stopwatch time;
    const mesh::Mesh level = cut(recording, budget);
    return {budget, level.triangles.size(), time.elapsed().wall_ms};
}

// N, or N - 1, or the floor below which the engine does not go.
bool is_exact(const CutResult& result, std::uint64_t floor) {
    return result.triangles == result.asked || result.triangles + 1 == result.asked || result.triangles == floor;
}

void write_csv(const std::string& file, const std::vector<CutResult>& results) {
    std::ofstream out(file);
    out << "asked,triangles,cut_ms\n";
    for (const CutResult& r : results) out << r.asked << ',' << r.triangles << ',' << r.wall_ms << '\n';
    if (!out) throw std::runtime_error("cannot write " + file);
}

void print(const std::vector<CutResult>& results, std::uint64_t floor) {
    std::vector<double> times;
    std::vector<Sample> samples;
    std::uint64_t equal = 0, one_less = 0, inexact = 0;
    for (const CutResult& r : results) {
        times.push_back(r.wall_ms);
        samples.push_back({static_cast<double>(r.triangles), r.wall_ms});
        equal += r.triangles == r.asked ? 1 : 0;
        one_less += r.triangles + 1 == r.asked ? 1 : 0;
        inexact += is_exact(r, floor) ? 0 : 1;
    }
    const Line line = fit_line(samples);
    const double median = percentile(times, 0.5);
    std::cout << to_text({{"what", "value", "target", "verdict"},
                          {"cut, median ms", brief(median), "< 5", median < median_target_ms ? "pass" : "FAIL"},
                          {"cut, 95th percentile ms", brief(percentile(times, 0.95)), "", ""},
                          {"cut, longest ms", brief(percentile(times, 1.0)), "", ""},
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
    std::vector<CutResult> results;
    for (const std::uint64_t budget : random_budgets(arguments)) results.push_back(timed_cut(recording, budget));
    print(results, floor);
    if (!arguments.csv_file.empty()) write_csv(arguments.csv_file, results);
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
    app.add_option("--max-triangles", arguments.max_triangles, "the largest")
        ->check(CLI::Range(2ull, 100'000'000ull))
        ->capture_default_str();
    app.add_option("--seed", arguments.seed, "of the random budgets")->capture_default_str();
    app.add_option("--csv", arguments.csv_file, "where to write asked, reached and time of every cut");
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_cut: " << error.what() << std::endl;
        return 1;
    }
}
