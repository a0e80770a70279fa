// lodestream_bench_simplify: the engine beside its peers; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "client/report/machine.h"
#include "tests/bench/comparison.h"
#include "tests/bench/engine.h"
#include "tests/bench/provenance_json.h"
#include "tests/bench/table.h"
#include "tests/bench/verdict.h"

namespace lodestream::bench {
namespace {

using nlohmann::json;

struct Arguments {
    std::vector<std::string> models;
    std::string data = "../shared/data";
    std::vector<std::string> only{"ours", "meshopt", "cgal", "openmesh"};
    std::vector<std::string> rows{"error", "image", "memory"};
    std::string json_file, picture_folder;
    std::string command_line;  // as typed
    int rounds = 5;
};

json to_json(const LevelResult& level, double diagonal) {
    json j{{"asked", level.asked},
           {"triangles", level.triangles},
           {"wall_ms", level.reached.wall_ms},
           {"cpu_ms", level.reached.cpu_ms}};
    if (level.error) {
        j["rms_error_percent"] = 100 * level.error->rms / diagonal;
        j["max_error_percent"] = 100 * level.error->max / diagonal;
    }
    if (level.image) {
        j["image_rms"] = level.image->rms;
        j["silhouette_percent"] = level.image->silhouette_percent;
    }
    if (level.own_normals_image) j["own_normals_image_rms"] = level.own_normals_image->rms;
    return j;
}

json to_json(const ModelResult& model) {
    json methods = json::array();
    for (const MethodResult& method : model.methods) {
        json j{{"method", method.method},
               {"rounds", method.rounds},
               {"prepare_ms", method.prepared.wall_ms},
               {"cut_ms", method.cut.wall_ms},
               {"levels", json::array()}};
        for (const LevelResult& level : method.levels) j["levels"].push_back(to_json(level, model.diagonal));
        if (method.peak_bytes_per_vertex) j["peak_bytes_per_vertex"] = *method.peak_bytes_per_vertex;
        methods.push_back(j);
    }
    return {{"model", model.name},
            {"triangles", model.triangles},
            {"vertices", model.vertices},
            {"dropped_triangles", model.repairs.dropped_triangles},
            {"split_vertices", model.repairs.split_vertices},
            {"methods", methods}};
}

json to_json(const Verdict& verdict) {
    json values = json::object();
    for (std::size_t k = 0; k < verdict.values.size(); ++k) values[verdict.models[k]] = verdict.values[k];
    json j{{"what", verdict.target.what}, {"at_least", verdict.target.at_least}, {"values", values}};
    if (verdict.target.bound) j["bound"] = *verdict.target.bound;
    if (verdict.target.bound) j["holds"] = verdict.holds();
    return j;
}

void write_json(const Arguments& arguments, const std::vector<ModelResult>& models, const std::vector<Verdict>& all) {
    json j{{"run", provenance_json(arguments.command_line)}, {"models", json::array()}, {"verdicts", json::array()}};
    for (const ModelResult& model : models) j["models"].push_back(to_json(model));
    for (const Verdict& verdict : all) j["verdicts"].push_back(to_json(verdict));
    std::ofstream out(arguments.json_file);
    out << j.dump(2) << '\n';
    if (!out) throw std::runtime_error("cannot write " + arguments.json_file);
}

// Folders become the model files below them.
std::vector<std::string> expanded(const std::vector<std::string>& specs) {
    static const std::set<std::string> extensions{".obj", ".ply", ".off", ".stl", ".glb", ".gltf"};
    std::vector<std::string> files;
    for (const std::string& spec : specs) {
        if (!std::filesystem::is_directory(spec)) {
            files.push_back(spec);
            continue;
        }
        for (const auto& entry : std::filesystem::directory_iterator(spec))
            if (extensions.contains(entry.path().extension().string())) files.push_back(entry.path().string());
    }
    std::sort(files.begin(), files.end());
    return files;
}

std::vector<Method> chosen_methods(const std::vector<std::string>& names) {
    std::vector<Method> chosen;
    for (const Method& method : methods())
        if (std::ranges::count(names, method.name) > 0) chosen.push_back(method);
    return chosen;
}

void run(const Arguments& arguments) {
    const auto wanted = [&](const char* row) { return std::ranges::count(arguments.rows, row) > 0; };
    ComparisonOptions options;
    options.methods = chosen_methods(arguments.only);
    options.max_rounds = arguments.rounds;
    options.errors = wanted("error");
    options.picture_folder = arguments.picture_folder;
    if (!arguments.picture_folder.empty()) std::filesystem::create_directories(options.picture_folder);

    const std::vector<std::string> specs =
        arguments.models.empty() ? default_inputs(arguments.data) : expanded(arguments.models);
    std::map<std::string, std::uint64_t> peak_bytes;  // first, as long as this process has done nothing else
    if (wanted("memory") && std::ranges::count(arguments.only, "ours") > 0)
        for (const std::string& spec : specs) peak_bytes[spec] = recording_peak_bytes(spec, arguments.data);

    std::optional<Painter> painter;
    if (wanted("image")) {
        Result<Painter> created = Painter::create();
        if (!created) throw std::runtime_error(created.error().message);
        painter.emplace(std::move(*created));
        options.painter = &*painter;
    }

    std::vector<ModelResult> models;
    for (const std::string& spec : specs) {
        Result<Input> input = load_input(spec, arguments.data);
        if (!input) throw std::runtime_error(input.error().message);
        std::cerr << input->name << ": " << input->mesh.triangles.size() << " triangles, "
                  << input->mesh.positions.size() << " vertices; made manifold by dropping "
                  << input->repairs.dropped_triangles << " triangles and splitting " << input->repairs.split_vertices
                  << " vertices" << std::endl;
        models.push_back(compare_methods(std::move(*input), options));
        for (MethodResult& method : models.back().methods)
            if (method.method == "ours" && peak_bytes.contains(spec))
                method.peak_bytes_per_vertex =
                    static_cast<double>(peak_bytes[spec]) / static_cast<double>(models.back().vertices);
        std::cout << comparison_table(models.back()) << std::endl;
    }
    const std::vector<Verdict> all = verdicts(models);
    std::cout << verdict_table(all)
              << "\nwall over CPU time of the peers (1 on a quiet machine): " << fixed(busyness(models), 2) << '\n';
    if (!arguments.json_file.empty()) write_json(arguments, models, all);
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    arguments.command_line = lodestream::report::joined(argc, argv);
    CLI::App app{
        "Simplifies large models with this project's engine, meshoptimizer, CGAL and OpenMesh in turns, and prints "
        "times, errors and ratios. Exits with 0 whatever the ratios: they depend on the machine."};
    app.add_option("--models", arguments.models,
                   "files, folders, \"made:1.4M\" or \"sample:terrain:40000\"; default: the large models of --data");
    app.add_option("--data", arguments.data, "the folder of test models")->capture_default_str();
    app.add_option("--only", arguments.only, "methods to run")
        ->delimiter(',')
        ->check(CLI::IsMember({"ours", "meshopt", "cgal", "openmesh"}))
        ->capture_default_str();
    app.add_option("--rows", arguments.rows, "what to measure beside the time; \"time\" alone for nothing else")
        ->delimiter(',')
        ->check(CLI::IsMember({"time", "error", "image", "memory"}))
        ->capture_default_str();
    app.add_option("--rounds", arguments.rounds, "runs of each method; slow ones get fewer")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    app.add_option("--json", arguments.json_file,
                   "where to write the numbers, for `lodestream-client report --methods` too");
    app.add_option("--pictures", arguments.picture_folder, "where to write a picture of each level: full model first");
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_simplify: " << error.what() << std::endl;
        return 1;
    }
}
