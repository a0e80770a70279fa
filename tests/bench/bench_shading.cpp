// lodestream_bench_shading: what all Gouraud, all flat and hybrid make of the same price in the paper's operations; see
// README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "common/shading/importance.h"
#include "common/shading/normal_errors.h"
#include "common/shading/paper_criterion.h"
#include "common/simplify/history.h"
#include "tests/bench/judge.h"
#include "tests/bench/levels.h"
#include "tests/bench/table.h"

namespace lodestream::bench {
namespace {

namespace fs = std::filesystem;

struct Arguments {
    std::vector<std::string> models;
    std::string data = "../shared/data";
    double operations = 24000;
};

constexpr double gouraud_operations = 4.0;  // flat: 1

// Image errors, RMS over the views.
struct Row {
    std::string model;
    double operations = 0.0;
    double gouraud = 0.0, flat = 0.0;
    double hybrid = 0.0;                   // by what Gouraud shading is measured to gain
    double estimated = 0.0;                // by what the level's own normals tell of it
    double paper = 0.0;                    // the paper's choice at the measured split
    double triangles = 0.0, smooth = 0.0;  // of hybrid, means over the views
};

using Order = std::vector<std::uint32_t>;
enum class Criterion { measured, estimated, paper };

// A level and what is measured of it.
struct Level {
    mesh::Mesh mesh;
    shading::NormalErrors errors;
};

class Bench {
  public:
    Bench(mesh::Model model, Painter& painter)
        : model_(std::move(model)),
          views_(views_around(model_)),
          gallery_(painter, model_),
          history_(record_history(model_.mesh)),
          reference_(model_.mesh) {}

    // No mode may show all of the model.
    Row compare(const std::string& name, double most_operations) {
        const double operations = std::min(most_operations, static_cast<double>(model_.mesh.triangles.size()) / 2.0);
        const Level affordable = level(operations), smooth = level(operations / gouraud_operations);
        Row row{.model = name, .operations = operations};
        for (std::size_t view = 0; view < views_.size(); ++view) {
            add(row.gouraud, show(smooth, operations, Criterion::measured, view));
            add(row.flat, show(affordable, 0.0, Criterion::measured, view));
            const double worth = affordable_worth(affordable, operations, Criterion::measured, view);
            const Level hybrid = level(left_of(operations, worth));
            add(row.hybrid, show(hybrid, worth, Criterion::measured, view));
            add(row.paper, show(hybrid, worth, Criterion::paper, view));
            const double guessed = affordable_worth(affordable, operations, Criterion::estimated, view);
            add(row.estimated, show(level(left_of(operations, guessed)), guessed, Criterion::estimated, view));
            row.triangles += left_of(operations, worth) / static_cast<double>(views_.size());
            row.smooth += worth / static_cast<double>(views_.size());
        }
        for (double* sum : {&row.gouraud, &row.flat, &row.hybrid, &row.estimated, &row.paper}) *sum = std::sqrt(*sum);
        return row;
    }

  private:
    void add(double& mean_square, double error) const {
        mean_square += error * error / static_cast<double>(views_.size());
    }

    static double left_of(double operations, double gouraud) {
        return operations - (gouraud_operations - 1.0) * gouraud;
    }

    Level level(double triangles) const {
        Level result{simplify::cut(history_, static_cast<std::uint64_t>(triangles)), {}};
        result.errors = shading::normal_errors(result.mesh, reference_);
        return result;
    }

    shading::Importance importance(const Level& level, Criterion criterion, std::size_t view) const {
        return shading::importance(level.mesh, model_.materials,
                                   {.view = views_[view],
                                    .origin = model_.origin,
                                    .errors = criterion == Criterion::measured ? &level.errors : nullptr});
    }

    double affordable_worth(const Level& level, double operations, Criterion criterion, std::size_t view) const {
        return std::min(static_cast<double>(shading::worth_gouraud(importance(level, criterion, view))),
                        operations / gouraud_operations);
    }

    double show(const Level& level, double gouraud, Criterion criterion, std::size_t view) {
        const Order order =
            criterion == Criterion::paper
                ? shading::paper_criterion(level.mesh, model_.materials, views_[view], model_.origin).order
                : shading::order_by_gain(importance(level, criterion, view).gain);
        std::vector<std::uint8_t> labels(order.size(), 0);
        for (std::size_t i = 0; i < std::min(order.size(), static_cast<std::size_t>(gouraud)); ++i)
            labels[order[i]] = 1;
        return gallery_.show_split(level.mesh, labels, view);
    }

    mesh::Model model_;
    std::vector<shading::View> views_;
    Gallery gallery_;
    simplify::History history_;
    shading::ReferenceSurface reference_;
};

std::vector<std::string> default_models(const std::string& data) {
    std::vector<std::string> specs{"sample:teapot", "sample:terrain"};
    const std::vector<std::string> files =
        files_below(data, {"classic/bunny_69k.ply", "classic/armadillo_86k.obj", "classic/nefertiti_100k.obj",
                           "classic/lucy_100k.ply", "classic/buddha_100k.obj", "classic/dragon_202k_res2.ply",
                           "classic/fandisk.obj", "classic/rocker-arm.obj", "classic/homer.obj", "classic/cow.obj",
                           "classic/beetle_39k.obj", "scan/turbineblade_199k.ply", "scan/eros_49k.ply"});
    specs.insert(specs.end(), files.begin(), files.end());
    return specs;
}

std::string table_of(const std::vector<Row>& rows) {
    std::vector<TableRow> table{{"model", "price", "all Gouraud", "all flat", "hybrid", "estimated", "paper's choice",
                                 "triangles", "Gouraud", "hybrid best"}};
    std::size_t best = 0, estimated = 0, better = 0;
    for (const Row& r : rows) {
        const bool wins = r.hybrid < std::min(r.gouraud, r.flat);
        best += wins ? 1 : 0;
        estimated += r.estimated < std::min(r.gouraud, r.flat) ? 1 : 0;
        better += r.hybrid < r.paper ? 1 : 0;
        table.push_back({r.model, fixed(r.operations, 0), fixed(r.gouraud, 3), fixed(r.flat, 3), fixed(r.hybrid, 3),
                         fixed(r.estimated, 3), fixed(r.paper, 3), fixed(r.triangles, 0), fixed(r.smooth, 0),
                         wins ? "yes" : "no"});
    }
    const std::string of = " of " + std::to_string(rows.size());
    return to_text(table) + "\nhybrid below both pure modes: " + std::to_string(best) + of +
           " (target 8 of 10); by its own normals alone: " + std::to_string(estimated) + of +
           "\nits choice better than the paper's: " + std::to_string(better) + of + "\n";
}

void run(const Arguments& arguments) {
    Result<Painter> painter = Painter::create();
    if (!painter) throw std::runtime_error(painter.error().message);
    std::vector<Row> rows;
    for (const std::string& spec : arguments.models.empty() ? default_models(arguments.data) : arguments.models) {
        std::cerr << spec << std::endl;
        Bench bench(load_model(spec), *painter);
        rows.push_back(bench.compare(fs::path(spec).stem().string(), arguments.operations));
    }
    std::cout << table_of(rows);
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    CLI::App app{
        "Spends one price in the paper's operations on all Gouraud, all flat and hybrid levels: picture errors."};
    app.add_option("--models", arguments.models, "model files or sample:NAME; default: samples and those of --data");
    app.add_option("--operations", arguments.operations, "the price; of a small model half its triangles")
        ->capture_default_str();
    app.add_option("--data", arguments.data, "the folder of test models")->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_shading: " << error.what() << std::endl;
        return 1;
    }
}
