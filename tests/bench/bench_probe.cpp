// lodestream_bench_probe: how far the probe's figures differ from run to run, alone and beside a busy process; see
// README.md.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/bench/table.h"

namespace lodestream::bench {
namespace {

constexpr const char* figures[] = {
    "gouraud_triangles_per_second",     "flat_triangles_per_second",    "points_per_second", "pixels_per_second",
    "cpu_single_operations_per_second", "cpu_all_operations_per_second"};

struct Arguments {
    std::string client;
    int runs = 10;
    int busy_runs = 3;
};

// `measured` of a device file. A process of its own each time: it finds its memory elsewhere.
nlohmann::json probe(const std::string& client) {
    std::FILE* pipe = ::popen(("'" + client + "' probe --json").c_str(), "r");
    if (!pipe) throw std::runtime_error("cannot run " + client);
    std::string text;
    char part[4096];
    while (const std::size_t read = std::fread(part, 1, sizeof part, pipe)) text.append(part, read);
    if (::pclose(pipe) != 0) throw std::runtime_error(client + " probe failed");
    return nlohmann::json::parse(text).at("measured");
}

// Spins until it is destroyed.
class BusyProcess {
  public:
    BusyProcess() : child_(::fork()) {
        if (child_ == 0)
            for (volatile unsigned long spins = 0;;) spins = spins + 1;
        if (child_ < 0) throw std::runtime_error("cannot fork");
    }
    BusyProcess(const BusyProcess&) = delete;
    BusyProcess& operator=(const BusyProcess&) = delete;
    ~BusyProcess() {
        ::kill(child_, SIGKILL);
        ::waitpid(child_, nullptr, 0);
    }

  private:
    pid_t child_;
};

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

std::string table_of(const std::vector<nlohmann::json>& reports) {
    std::vector<TableRow> table{{"figure", "median", "least", "most", "farthest off %", "stated ±%"}};
    const auto add = [&](const std::string& name, const auto& value_of, std::string stated) {
        std::vector<double> values;
        for (const nlohmann::json& report : reports) values.push_back(value_of(report));
        const auto [least, most] = std::minmax_element(values.begin(), values.end());
        const double middle = median(values), farthest = std::max(*most - middle, middle - *least);
        table.push_back({name, fixed(middle, 3), fixed(*least, 3), fixed(*most, 3),
                         fixed(100.0 * farthest / std::max(middle, 1e-9), 1), std::move(stated)});
    };
    for (const std::string name : figures) {
        std::vector<double> stated;
        for (const nlohmann::json& report : reports) stated.push_back(report.at(name + "_uncertainty_percent"));
        add(
            name + ", millions", [&](const nlohmann::json& report) { return 1e-6 * report.at(name).get<double>(); },
            fixed(median(stated), 1));
    }
    for (const auto& cost : reports.front().at("frame_costs").items()) {
        const std::string name = cost.key();
        add(
            name, [&](const nlohmann::json& report) { return report.at("frame_costs").at(name).get<double>(); }, "");
    }
    add(
        "seconds", [](const nlohmann::json& report) { return report.at("seconds").get<double>(); }, "");
    const auto disturbed = std::count_if(reports.begin(), reports.end(), [](const nlohmann::json& report) {
        return report.at("disturbed").get<bool>();
    });
    return to_text(table) + "said to be disturbed: " + std::to_string(disturbed) + " of " +
           std::to_string(reports.size()) + "\n\n";
}

void run(const Arguments& arguments) {
    const auto probes = [&](int count) {
        std::vector<nlohmann::json> reports;
        for (int i = 0; i < count; ++i) reports.push_back(probe(arguments.client));
        return reports;
    };
    std::cout << "alone, as far as this machine is (target: rates at most 10 % off their median, none disturbed)\n"
              << table_of(probes(arguments.runs)) << std::flush;
    const BusyProcess busy;
    std::cout << "beside a busy process (target: all disturbed)\n" << table_of(probes(arguments.busy_runs));
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    arguments.client = (std::filesystem::path(argv[0]).parent_path() / "lodestream-client").string();
    CLI::App app{"Runs the probe again and again and tells how far its figures differ."};
    app.add_option("--client", arguments.client, "the program")->capture_default_str();
    app.add_option("--runs", arguments.runs, "alone")->capture_default_str()->check(CLI::Range(2, 1000));
    app.add_option("--busy-runs", arguments.busy_runs, "beside a busy process")
        ->capture_default_str()
        ->check(CLI::Range(1, 1000));
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_probe: " << error.what() << '\n';
        return 1;
    }
}
