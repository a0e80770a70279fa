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
    int rounds = 5;
    std::uint64_t max_triangles = 10'000;
    std::uint64_t seed = 1;
};

struct CutResult {
    std::uint64_t asked = 0;
    std::uint64_t triangles = 0;
    double median_ms = 0.0;  // over the rounds
    double least_ms = 0.0;   // without what other programs of the machine took
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
    std::vector<std::vector<double>> times(budgets.size());
    std::vector<CutResult> results(budgets.size());
    for (int round = 0; round < rounds; ++round)
        for (std::size_t k = 0; k < budgets.size(); ++k) {
            const Stopwatch time;
            const mesh::Mesh level = cut(recording, budgets[k]);
            times[k].push_back(time.elapsed().wall_ms);
            results[k] = {budgets[k], level.triangles.size(), 0.0, 0.0};
        }
    for (std::size_t k = 0; k < budgets.size(); ++k) {
        results[k].median_ms = percentile(times[k], 0.5);
        results[k].least_ms = percentile(times[k], 0.0);
    }
    return results;
}

// N, or N - 1, or the floor below which the engine does not go.
bool is_exact(const CutResult& result, std::uint64_t floor) {
    return result.triangles == result.asked || result.triangles + 1 == result.asked || result.triangles == floor;
}

void write_csv(const std::string& file, const std::vector<CutResult>& results) {
    std::ofstream out(file);
    out << "asked,triangles,median_ms,least_ms\n";
    for (const CutResult& r : results)
        out << r.asked << ',' << r.triangles << ',' << r.median_ms << ',' << r.least_ms << '\n';
    if (!out) throw std::runtime_error("cannot write " + file);
}

void print(const std::vector<CutResult>& results, std::uint64_t floor) {
    std::vector<double> times;
    std::vector<Sample> samples;
    std::uint64_t equal = 0, one_less = 0, inexact = 0;
    for (const CutResult& r : results) {
        times.push_back(r.median_ms);
        samples.push_back({static_cast<double>(r.triangles), r.least_ms});
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
    const std::vector<CutResult> results = timed_cuts(recording, random_budgets(arguments), arguments.rounds);
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
    app.add_option("--rounds", arguments.rounds, "cuts of each budget")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
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
