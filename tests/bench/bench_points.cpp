// lodestream_bench_points: the point-cloud paper's tests of its levels on our renderer; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <optional>

#include "client/render/gl_context.h"
#include "client/report/crowd.h"
#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "common/points/level.h"
#include "common/points/resample.h"
#include "common/simplify/history.h"
#include "server/bake/executor.h"
#include "server/importer/importer.h"
#include "server/samples/samples.h"
#include "tests/bench/stopwatch.h"
#include "tests/bench/table.h"

namespace lodestream::bench {
namespace {

namespace fs = std::filesystem;
using report::crowd_levels;
using Levels = std::array<std::uint64_t, crowd_levels>;

struct Arguments {
    std::vector<std::string> models{"sample:teapot"};
    std::uint32_t side = 11;
    std::uint32_t directions = 8;
    std::string picture_folder;
    bool parameters = false;
    bool share = false;
    std::vector<std::uint32_t> crowds;
};

// The paper's Tables 3 and 12.
struct Paper {
    Levels levels;
    double f = 0.0;
};
const std::map<std::string, Paper> papers{
    {"buddha", {{300'000, 138'967, 89'022, 35'492, 22'301}, 0.959}},
    {"dragon", {{300'000, 109'486, 69'952, 27'251, 17'478}, 0.944}},
    {"bunny", {{14'904, 12'654, 7'092, 3'191, 800}, 0.965}},
    {"lucy", {{1'346'640, 81'566, 52'162, 39'897, 20'354}, 0.918}},
    {"armadillo", {{1'037'832, 64'200, 41'211, 31'621, 16'102}, 0.928}},
};
constexpr double other_level_ratio = 0.5;  // of a level's points to the finer one's, where the paper has none

mesh::Model load(const std::string& name) {
    constexpr std::string_view sample_prefix = "sample:";
    Result<mesh::Model> model = name.starts_with(sample_prefix)
                                    ? samples::make_sample(name.substr(sample_prefix.size()))
                                    : importer::import_file(name);
    if (!model) throw std::runtime_error(model.error().message);
    return *std::move(model);
}

template <class T>
T checked(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return *std::move(result);
}

// The paper's row whose name the file's stem begins with.
const Paper* paper_of(const std::string& name) {
    const std::string stem = fs::path(name).stem().string();
    for (const auto& [model, paper] : papers)
        if (stem.starts_with(model)) return &paper;
    return nullptr;
}

Levels levels_of(const mesh::Mesh& mesh, const Paper* paper, double scale) {
    Levels levels{};
    double points = static_cast<double>(mesh.triangles.size());
    for (std::size_t i = 0; i < crowd_levels; ++i) {
        const double own = paper ? static_cast<double>(paper->levels[i]) * scale : points;
        levels[i] = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::min(own, 300'000.0)));
        points *= other_level_ratio;
    }
    return levels;
}

struct Cloud {
    codec::Points content;
    double seconds = 0.0;
};

Cloud make_cloud(const mesh::Model& model, std::uint64_t points, const points::ResampleOptions& how,
                 std::optional<points::Parameters> parameters = {}) {
    const Stopwatch watch;
    const points::Parameters chosen = parameters.value_or(points::choose_parameters(model.mesh, points));
    points::OrderedCloud ordered = points::order(points::resample(model.mesh, chosen, how), points, how.executor);
    Cloud cloud;
    cloud.seconds = 1e-3 * watch.elapsed().wall_ms;
    const metric::SurfaceIndex index(model.mesh);
    cloud.content.levels = points::measured_levels(index, model.mesh, ordered, bake::all_cores());
    cloud.content.cloud = std::move(ordered.cloud);
    cloud.content.origin = model.origin;
    return cloud;
}

class Bench {
  public:
    explicit Bench(Arguments arguments)
        : arguments_(std::move(arguments)),
          context_(checked(render::create_headless_context())),
          full_(checked(render::Renderer::create())),
          points_(checked(render::Renderer::create())) {
        how_.executor = bake::all_cores();
    }

    void run() {
        std::cout << "F of silhouettes, " << arguments_.side << "^3 instances, "
                  << report::orbit_distances.size() * arguments_.directions << " views of 1024x1024 px, "
                  << context_.renderer() << "\n";
        std::vector<TableRow> table{
            {"model", "triangles", "points", "recall", "precision", "F", "paper's F", "resample s"}};
        for (const std::string& name : arguments_.models) score(name, table);
        std::cout << to_text(table);
        if (arguments_.parameters)
            for (const std::string& name : arguments_.models) vary(name);
        if (arguments_.share)
            for (const std::string& name : arguments_.models) compare_with_levels(name);
        if (!arguments_.crowds.empty())
            for (const std::string& name : arguments_.models) time_crowds(name);
    }

  private:
    report::CrowdModel upload(const mesh::Model& model, const codec::Points& points, const Levels& levels) {
        const codec::Decoded content = render::drawable(model, model.mesh);
        checked(full_.upload(content));
        checked(points_.upload(points));
        silhouettes_.emplace(content);
        return {*silhouettes_, points_, render::world_bounds(content), levels};
    }

    report::CrowdScore measure(report::CrowdModel& crowd, std::uint32_t directions) {
        report::CrowdOptions options;
        options.side = arguments_.side;
        options.directions = directions;
        return checked(report::score_crowd(crowd, options));
    }

    void score(const std::string& name, std::vector<TableRow>& table) {
        const mesh::Model model = load(name);
        const Paper* paper = paper_of(name);
        const auto vertices = static_cast<double>(model.mesh.positions.size());
        std::vector<double> scales{1.0};
        if (paper && vertices < static_cast<double>(paper->levels[0]))
            scales.push_back(vertices / static_cast<double>(paper->levels[0]));
        const Levels most = levels_of(model.mesh, paper, 1.0);
        const Cloud cloud = make_cloud(model, most[0], how_);
        for (const double scale : scales) {
            const Levels levels = levels_of(model.mesh, paper, scale);
            report::CrowdModel crowd = upload(model, cloud.content, levels);
            const report::CrowdScore scored = measure(crowd, arguments_.directions);
            const std::string label = fs::path(name).stem().string() + (scale < 1.0 ? ", scaled" : "");
            for (std::size_t level = 0; level < crowd_levels; ++level)
                if (scored.instances[level] > 0)
                    row(table, label + " L" + std::to_string(level), model, levels[level], scored.by_level[level], {},
                        {});
            row(table, label, model, levels[0], scored.all, paper ? std::optional(paper->f) : std::nullopt,
                cloud.seconds);
            save_pictures(label, crowd);
        }
    }

    static void row(std::vector<TableRow>& table, const std::string& label, const mesh::Model& model,
                    std::uint64_t points, const report::SilhouetteScore& score, std::optional<double> paper,
                    std::optional<double> seconds) {
        table.push_back({label, std::to_string(model.mesh.triangles.size()), std::to_string(points),
                         fixed(score.recall(), 4), fixed(score.precision(), 4), fixed(score.f_measure(), 4),
                         paper ? fixed(*paper, 3) : "", seconds ? fixed(*seconds, 2) : ""});
    }

    void save_pictures(const std::string& label, report::CrowdModel& crowd) {
        if (arguments_.picture_folder.empty()) return;
        const double radius = crowd.bounds.radius();
        shading::View view;
        view.target = crowd.bounds.center();
        view.eye = view.target + Vec3d(0.5, 0.4, 0.8) * (36.0 * radius);
        render::DrawOptions options;
        options.width = options.height = 1024;
        const std::array<std::uint32_t, 3> sides{arguments_.side, arguments_.side, arguments_.side};
        options.instances = report::crowd_of(crowd, sides, report::CrowdOptions{}.spacing, view.eye);
        std::vector<render::Image> images;
        for (render::Renderer* renderer : {&full_, &points_})
            images.push_back(checked(renderer->draw(view, options)).image);
        view.eye = view.target + Vec3d(0.5, 0.4, 0.8) * (2.9 * radius);
        options.instances = {render::Instance{}};
        for (render::Renderer* renderer : {&full_, &points_})
            images.push_back(checked(renderer->draw(view, options)).image);
        fs::create_directories(arguments_.picture_folder);
        const Status written =
            render::write_png(fs::path(arguments_.picture_folder) / (label + ".png"), render::side_by_side(images));
        if (!written) throw std::runtime_error(written.error().message);
    }

    // One parameter at a time: the filter, T1, T3 (T2 is one pixel by construction).
    void vary(const std::string& name) {
        const mesh::Model model = load(name);
        const Levels levels = levels_of(model.mesh, paper_of(name), 1.0);
        const points::Parameters usual = points::choose_parameters(model.mesh, levels[0]);
        std::vector<TableRow> table{{"filter", "T1", "T3", "points", "recall", "precision", "F"}};
        const auto measure_with = [&](points::HoleFilter filter, const char* label,
                                      const points::Parameters& parameters) {
            points::ResampleOptions how = how_;
            how.filter = filter;
            const Cloud cloud = make_cloud(model, levels[0], how, parameters);
            report::CrowdModel crowd = upload(model, cloud.content, levels);
            const report::SilhouetteScore score = measure(crowd, 2).all;
            table.push_back({label, std::to_string(parameters.slices), std::to_string(parameters.side),
                             std::to_string(cloud.content.cloud.positions.size()), fixed(score.recall(), 4),
                             fixed(score.precision(), 4), fixed(score.f_measure(), 4)});
        };
        measure_with(points::HoleFilter::none, "none", usual);
        measure_with(points::HoleFilter::median, "median", usual);
        measure_with(points::HoleFilter::gaussian, "gaussian", usual);
        for (const std::uint32_t divisor : {2u, 4u, 8u, 16u}) {
            measure_with(points::HoleFilter::median, "median", {std::max(1u, usual.slices / divisor), usual.side});
            measure_with(points::HoleFilter::median, "median", {usual.slices, std::max(1u, usual.side / divisor)});
        }
        std::cout << "\n" << name << ": parameters\n" << to_text(table);
    }

    // What a plan weighs against each other (server/planner/point_level.h): the RMS distance of the level of triangles
    // whose picture errs as much as that of the points, over the radius of their discs.
    void compare_with_levels(const std::string& name) {
        const mesh::Model model = load(name);
        const simplify::History history = checked(simplify::record_history(mesh::Mesh(model.mesh)));
        const metric::SurfaceIndex index(model.mesh);
        const Cloud cloud = make_cloud(model, model.mesh.triangles.size() / 2, how_);
        report::CrowdModel crowd = upload(model, cloud.content, {});
        std::vector<TableRow> table{{"points", "radius px", "error", "triangles", "RMS px", "RMS / radius"}};
        shading::View view = shading::framing_view(crowd.bounds);
        render::DrawOptions options;
        options.width = options.height = 800;
        options.samples = 1;
        const render::Image full = checked(full_.draw(view, options)).image;
        const double px = shading::pixels_per_unit(view, crowd.bounds, {options.width, options.height});
        const auto error_of = [&](render::Renderer& renderer) {
            return checked(render::compare(full, checked(renderer.draw(view, options)).image)).rms;
        };
        for (std::uint64_t points = 64; points <= cloud.content.cloud.positions.size(); points *= 4) {
            options.instances = {{{}, points}};
            const double error = error_of(points_);
            std::uint64_t low = 4, high = model.mesh.triangles.size();
            while (low + low / 16 + 1 < high) {
                const std::uint64_t middle = (low + high) / 2;
                checked(full_.upload(render::drawable(model, simplify::cut(history, middle))));
                (error_of(full_) > error ? low : high) = middle;
            }
            const double rms = metric::measure(index, model.mesh, simplify::cut(history, high)).rms * px;
            const double radius = points::level_of(cloud.content.levels, points).radius * px;
            table.push_back({std::to_string(points), fixed(radius, 2), fixed(error, 2), std::to_string(high),
                             fixed(rms, 3), fixed(rms / radius, 4)});
        }
        std::cout << "\n" << name << ": points and triangles of the same picture error\n" << to_text(table);
    }

    // Frames a second of a square of instances, full models against points by distance.
    void time_crowds(const std::string& name) {
        const mesh::Model model = load(name);
        const Levels levels = levels_of(model.mesh, paper_of(name), 1.0);
        const Cloud cloud = make_cloud(model, levels[0], how_);
        report::CrowdModel crowd = upload(model, cloud.content, levels);
        std::vector<TableRow> table{{"instances", "full ms", "points ms", "gain", "full triangles", "points drawn"}};
        shading::View view;
        view.target = crowd.bounds.center();
        for (const std::uint32_t side : arguments_.crowds) {
            const double extent = side * report::CrowdOptions{}.spacing * crowd.bounds.radius();
            view.eye = view.target + normalize(Vec3d(0.0, 0.6, 1.0)) * std::max(extent, 30.0 * crowd.bounds.radius());
            render::DrawOptions options;
            options.width = options.height = 1024;
            options.samples = 1;
            options.frames = 3;
            options.instances = report::crowd_of(crowd, {side, 1, side}, report::CrowdOptions{}.spacing, view.eye);
            const render::Frame points = checked(points_.draw(view, options));
            if (side > 17) options.frames = 1;
            const render::Frame full = checked(full_.draw(view, options));
            table.push_back({std::to_string(side * side), fixed(full.frame_ms, 1), fixed(points.frame_ms, 1),
                             fixed(full.frame_ms / points.frame_ms, 2), std::to_string(full.triangles),
                             std::to_string(points.points)});
        }
        std::cout << "\n" << name << ": frame times\n" << to_text(table);
    }

    Arguments arguments_;
    render::GlContext context_;
    render::Renderer full_, points_;
    std::optional<report::SilhouetteTree> silhouettes_;
    points::ResampleOptions how_;
};

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    CLI::App app("The point-cloud paper's tests: recall, precision and F of crowds of points against full models.");
    app.add_option("models", arguments.models, "Files, or sample:NAME");
    app.add_option("--side", arguments.side, "Instances along each axis")
        ->check(CLI::Range(1, 13))
        ->capture_default_str();
    app.add_option("--directions", arguments.directions, "Views on each of the five orbits")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_option("--pictures", arguments.picture_folder, "Write a picture of each model there");
    app.add_flag("--parameters", arguments.parameters, "F over filters, T1 and T3");
    app.add_flag("--share", arguments.share, "The level of triangles that errs as much as the points do");
    app.add_option("--crowds", arguments.crowds, "Frame times of squares of that many instances a side");
    app.footer("Example:\n  lodestream_bench_points sample:teapot bunny.ply --pictures out --crowds 5 11 17");
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::Bench(std::move(arguments)).run();
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_points: " << error.what() << '\n';
        return 1;
    }
}
