// lodestream_bench_points: the point-cloud paper's tests of its levels on our renderer; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <numeric>
#include <optional>

#include "client/render/gl_context.h"
#include "client/render/slices.h"
#include "client/report/choice_groups.h"
#include "client/report/crowd.h"
#include "client/report/machine.h"
#include "client/report/text.h"
#include "common/base/directions.h"
#include "common/mesh/instances.h"
#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "common/points/level.h"
#include "common/points/resample.h"
#include "common/simplify/history.h"
#include "server/bake/executor.h"
#include "server/importer/importer.h"
#include "server/samples/samples.h"
#include "tests/bench/point_choice.h"
#include "tests/bench/point_codecs.h"
#include "tests/bench/points_json.h"
#include "tests/bench/points_paper.h"
#include "tests/bench/process_memory.h"
#include "tests/bench/stopwatch.h"
#include "tests/bench/table.h"
#include "tests/bench/value_of.h"
#include "tests/support/cloud_difference.h"

namespace lodestream::bench {
namespace {

namespace fs = std::filesystem;
using points::HoleFilter;
using report::crowd_levels;

struct Arguments {
    std::vector<std::string> models{"sample:teapot"};
    std::uint32_t side = 11;
    std::uint32_t directions = 8;
    bool scores = false;
    bool parameters = false;
    bool levels = false, paths = false;
    bool share = false;
    bool codecs = false;
    std::vector<std::uint32_t> crowds;
    std::string store, picture_folder, json_file, command_line;
};

constexpr double other_level_ratio = 0.5;  // of a level's points to the finer one's, where the paper has none
constexpr std::uint64_t most_points = 300'000;

// Pictures from close by, in which holes show.
constexpr std::uint32_t close_side = 512;  // px
constexpr std::size_t close_views = 26;
constexpr double close_distance = 3.0;     // of the eye, radii
constexpr std::uint32_t panel_side = 200;  // px, of a picture in the report
const Vec3d panel_direction{0.5, 0.4, 0.8};

struct NamedFilter {
    HoleFilter filter;
    const char* name;
};
constexpr std::array<NamedFilter, 4> filters{{{HoleFilter::none, "none"},
                                              {HoleFilter::gaussian, "gaussian"},
                                              {HoleFilter::median, "median"},
                                              {HoleFilter::opposites, "opposites"}}};
// The paper's figures 5 to 7: T3 and T1 in the same steps, and points from 10 px to 2, of which 6 fit.
constexpr std::array<std::uint32_t, 5> paper_steps{100, 80, 60, 40, 20};
constexpr std::array<double, 5> paper_point_sizes{10.0 / 6.0, 8.0 / 6.0, 1.0, 4.0 / 6.0, 2.0 / 6.0};

constexpr std::uint64_t most_crowd_triangles = 700'000'000;     // of full models in a frame: a minute
constexpr std::uint64_t repeated_crowd_triangles = 50'000'000;  // frames of more are timed once
constexpr int turns = 3;
constexpr double crowd_nearest = 30.0;  // of the eye, radii

mesh::Model load(const std::string& name) {
    constexpr std::string_view sample_prefix = "sample:";
    Result<mesh::Model> model = name.starts_with(sample_prefix)
                                    ? samples::make_sample(name.substr(sample_prefix.size()))
                                    : importer::import_file(name);
    if (!model) throw std::runtime_error(model.error().message);
    return mesh::without_instances(*std::move(model));
}

double longest_side(const Box& box) {
    const Vec3d extent = box.extent();
    return std::max({extent.x, extent.y, extent.z});
}

double median(std::vector<double> values) {
    std::ranges::sort(values);
    return values[values.size() / 2];
}

std::string stem_of(const std::string& name) {
    return name.starts_with("sample:") ? name.substr(7) : fs::path(name).stem().string();
}

// The paper's row whose name the model's begins with.
const PointsPaper* paper_of(const std::string& name) {
    for (const auto& [model, paper] : points_papers)
        if (stem_of(name).starts_with(model)) return &paper;
    return nullptr;
}

PointLevels levels_of(const mesh::Mesh& mesh, const PointsPaper* paper, double scale) {
    PointLevels levels{};
    double points = static_cast<double>(mesh.triangles.size());
    for (std::size_t i = 0; i < crowd_levels; ++i) {
        const double own = paper ? static_cast<double>(paper->levels[i]) * scale : points;
        levels[i] = std::clamp<std::uint64_t>(static_cast<std::uint64_t>(own), 1, most_points);
        points *= other_level_ratio;
    }
    return levels;
}

// Of the paper's scan to the one at hand: 1 where that is as large.
double scale_of(const mesh::Mesh& mesh, const PointsPaper* paper) {
    const auto vertices = static_cast<double>(mesh.positions.size());
    return paper ? std::min(1.0, vertices / static_cast<double>(paper->levels[0])) : 1.0;
}

proto::SilhouetteMatch match_of(const report::SilhouetteScore& score) {
    return {score.recall(), score.precision(), score.f_measure()};
}

// All that a drawing needs of a cloud; its errors are not measured.
codec::Points content_of(const mesh::Model& model, points::OrderedCloud ordered, const simplify::Executor& executor) {
    constexpr std::size_t few_samples = 1;
    const metric::SurfaceIndex index(model.mesh, few_samples);
    codec::Points content;
    content.levels = points::measured_levels(index, model.mesh, ordered, executor);
    content.cloud = std::move(ordered.cloud);
    content.origin = model.origin;
    return content;
}

// The points that face the eye, so that none behind shows through a hole.
codec::Points facing(const codec::Points& all, const Vec3d& eye) {
    codec::Points front;
    front.origin = all.origin;
    const Vec3d from(eye - all.origin);
    for (std::size_t i = 0; i < all.cloud.positions.size(); ++i) {
        const Vec3f &position = all.cloud.positions[i], &normal = all.cloud.normals[i];
        if (!(dot(Vec3d(normal), from - Vec3d(position)) > 0.0)) continue;
        front.cloud.positions.push_back(position);
        front.cloud.normals.push_back(normal);
    }
    front.levels = {{front.cloud.positions.size(), {}, all.levels.front().radius}};
    return front;
}

// The triangles that face the eye.
mesh::Mesh facing(const mesh::Model& model, const Vec3d& eye) {
    mesh::Mesh front = model.mesh;
    front.triangle_materials.clear();
    const Vec3d from = eye - model.origin;
    std::erase_if(front.triangles, [&](const mesh::Triangle& t) {
        const Vec3f& corner = front.positions[t[0]];
        return !(dot(mesh::face_normal(corner, front.positions[t[1]], front.positions[t[2]]), from - Vec3d(corner)) >
                 0.0);
    });
    return front;
}

// A model from close by: what it covers, and what of it faces the eye.
struct CloseView {
    shading::View view;
    report::Mask full, front;
};

report::Mask covered_by(const codec::Decoded& content, const shading::View& view) {
    report::Mask mask(close_side, close_side);
    report::SilhouetteTree(content).cover(render::pixels_from_world(view, close_side, close_side), Vec3d(0.0), mask);
    return mask;
}

std::vector<CloseView> views_around(const mesh::Model& model) {
    const codec::Decoded content = render::drawable(model, model.mesh);
    const Box bounds = render::world_bounds(content);
    std::vector<CloseView> views(close_views);
    for (std::size_t i = 0; i < views.size(); ++i) {
        CloseView& from = views[i];
        from.view.target = bounds.center();
        from.view.eye = from.view.target + spread_direction(i, close_views) * (close_distance * bounds.radius());
        from.full = covered_by(content, from.view);
        from.front = covered_by(render::drawable(model, facing(model, from.view.eye)), from.view);
    }
    return views;
}

class Bench {
  public:
    explicit Bench(Arguments arguments)
        : arguments_(std::move(arguments)),
          context_(value_of(render::create_headless_context())),
          full_(value_of(render::Renderer::create())),
          points_(value_of(render::Renderer::create())) {
        how_.executor = bake::all_cores();
    }

    void run() {
        std::cout << "On " << context_.renderer() << std::endl;
        study(arguments_.scores, &Bench::score);
        study(arguments_.parameters, &Bench::vary);
        study(arguments_.levels, &Bench::time_levels);
        study(arguments_.paths, &Bench::compare_paths);
        study(arguments_.share, &Bench::compare_with_levels);
        study(arguments_.codecs, &Bench::compare_codecs);
        study(!arguments_.crowds.empty(), &Bench::time_crowds);
        if (!arguments_.store.empty()) study_choices(arguments_.store, run_.choices, [this] { keep(); });
        if (arguments_.scores) print_scores();
        if (arguments_.parameters) print_settings();
        if (!arguments_.crowds.empty()) print_crowds();
        if (!arguments_.store.empty()) print_choices();
    }

  private:
    // Keeps what is done after each model.
    void study(bool is_wanted, void (Bench::*of_model)(const std::string& name)) {
        if (!is_wanted) return;
        for (const std::string& name : arguments_.models) {
            (this->*of_model)(name);
            keep();
        }
    }

    void keep() const {
        if (!arguments_.json_file.empty()) write_points_run(arguments_.json_file, arguments_.command_line, run_);
    }

    codec::Points make_cloud(const mesh::Model& model, std::uint64_t points) {
        const Stopwatch watch;
        const points::PointCloud cloud =
            points::resample(model.mesh, points::choose_parameters(model.mesh, points), how_);
        points::OrderedCloud ordered = points::order(cloud, points, how_.executor);
        const auto took = watch.elapsed();
        std::cout << model.mesh.triangles.size() << " triangles: " << points << " points, resampled and ordered in "
                  << fixed(1e-3 * took.wall_ms, 2) << " s, CPU " << fixed(1e-3 * took.cpu_ms, 2) << " s" << std::endl;
        return content_of(model, std::move(ordered), how_.executor);
    }
    // As many of those that the parameters give as a bake would keep of them.
    codec::Points choose(const mesh::Model& model, const points::Parameters& parameters, HoleFilter filter) {
        points::ResampleOptions how = how_;
        how.filter = filter;
        const points::PointCloud cloud = points::resample(model.mesh, parameters, how);
        const auto kept =
            static_cast<std::uint64_t>(static_cast<double>(cloud.positions.size()) / points::oversampling);
        return content_of(model, points::order(cloud, kept, how.executor), how.executor);
    }

    // From triangles to the ordered cloud of which every prefix is a level, as a bake makes it.
    void time_levels(const std::string& name) {
        const mesh::Model model = load(name);
        const auto make = [&] {
            const points::Parameters parameters = points::choose_parameters(model.mesh, most_points);
            return points::order(points::resample(model.mesh, parameters, how_), most_points, how_.executor);
        };
        std::vector<double> wall_ms, cpu_ms;
        for (int turn = 0; turn < turns; ++turn) {
            const Stopwatch watch;
            make();
            const auto took = watch.elapsed();
            wall_ms.push_back(took.wall_ms);
            cpu_ms.push_back(took.cpu_ms);
        }
        const std::uint64_t bytes = peak_growth_bytes([&] { make(); });
        std::cout << stem_of(name) << ", " << model.mesh.triangles.size() << " triangles: " << most_points
                  << " ordered points in " << fixed(1e-3 * median(wall_ms), 2) << " s, CPU "
                  << fixed(1e-3 * median(cpu_ms), 2) << " s (medians of " << turns << "), at most "
                  << fixed(1e-6 * static_cast<double>(bytes), 0) << " MB beside the model's" << std::endl;
    }

    // The views drawn by the CPU and, in slices, by the GPU.
    void compare_paths(const std::string& name) {
        const mesh::Model model = load(name);
        render::SliceRenderer slices = value_of(render::SliceRenderer::create());
        const points::DrawSlices draw = [&](const points::SlicedView& view) { return slices.draw(view); };
        for (const std::uint32_t side : {100u, 200u, 400u}) {
            const points::Parameters parameters{side, side};
            const Stopwatch cpu_watch;
            const points::PointCloud by_cpu = points::resample(model.mesh, parameters, how_);
            const double cpu_ms = cpu_watch.elapsed().wall_ms;
            const Stopwatch gpu_watch;
            const points::PointCloud by_gpu = value_of(points::resample(model.mesh, parameters, draw, how_));
            const double gpu_ms = gpu_watch.elapsed().wall_ms;
            const double share = testing::differing_share(model.mesh, parameters, by_cpu, by_gpu);
            std::cout << stem_of(name) << ", T1 and T3 " << side << ": CPU " << by_cpu.positions.size() << " points in "
                      << fixed(1e-3 * cpu_ms, 2) << " s, " << context_.renderer() << " " << by_gpu.positions.size()
                      << " in " << fixed(1e-3 * gpu_ms, 2) << " s; not in both " << fixed(100.0 * share, 3) << " %"
                      << std::endl;
        }
    }

    // Full model and points, each on its renderer.
    report::CrowdModel upload(const mesh::Model& model, const codec::Points& points, const PointLevels& levels) {
        const codec::Decoded content = render::drawable(model, model.mesh);
        value_of(full_.upload(content));
        value_of(points_.upload(points));
        silhouettes_.emplace(content);
        return {*silhouettes_, points_, render::world_bounds(content), levels};
    }

    // The paper's test, with its levels and, where the scan at hand is smaller, with levels as much smaller.
    void score(const std::string& name) {
        const mesh::Model model = load(name);
        const PointsPaper* paper = paper_of(name);
        const codec::Points cloud = make_cloud(model, levels_of(model.mesh, paper, 1.0)[0]);
        const double scale = scale_of(model.mesh, paper);
        for (const bool is_scaled : {false, true}) {
            if (is_scaled && !(scale < 1.0)) break;
            const PointLevels levels = levels_of(model.mesh, paper, is_scaled ? scale : 1.0);
            report::CrowdModel crowd = upload(model, cloud, levels);
            report::CrowdOptions options;
            options.side = arguments_.side;
            options.directions = arguments_.directions;
            const report::CrowdScore scored = value_of(report::score_crowd(crowd, options));
            proto::PointsScore row;
            row.model = stem_of(name);
            row.is_scaled = is_scaled;
            row.triangles = model.mesh.triangles.size();
            row.views = report::orbit_distances.size() * options.directions;
            for (std::size_t level = 0; level < crowd_levels; ++level) {
                row.level = "L" + std::to_string(level);
                row.points = levels[level];
                row.instances = scored.instances[level];
                row.match = match_of(scored.by_level[level]);
                if (row.instances > 0) run_.scores.push_back(row);
            }
            row.level = "all";
            row.points = levels[0];
            row.instances = std::uint64_t{options.side} * options.side * options.side;
            row.match = match_of(scored.all);
            if (paper) row.paper_f = paper->f;
            run_.scores.push_back(row);
            add_crowd_picture(name, is_scaled ? "crowd, levels scaled to the scan" : "crowd, the paper’s levels",
                              crowd);
        }
    }

    void add_crowd_picture(const std::string& name, const std::string& title, const report::CrowdModel& crowd) {
        const double radius = crowd.bounds.radius();
        shading::View view;
        view.target = crowd.bounds.center();
        view.eye = view.target + panel_direction * (36.0 * radius);
        render::DrawOptions options;
        options.width = options.height = 2 * panel_side;
        const std::array<std::uint32_t, 3> sides{arguments_.side, arguments_.side, arguments_.side};
        options.instances = report::crowd_of(crowd, sides, view.eye);
        std::vector<Panel> panels;
        const auto add_pair = [&](const std::string& of_what) {
            panels.push_back({of_what + ", full", value_of(full_.draw(view, options)).image});
            panels.push_back({of_what + ", points", value_of(points_.draw(view, options)).image});
        };
        add_pair("crowd at 36 radii");
        view.eye = view.target + panel_direction * (2.9 * radius);
        options.instances = {render::Instance{}};
        add_pair("one at 3 radii");
        add_picture(name, title, panels);
    }

    struct Panel {
        std::string label;
        render::Image image;
    };

    void add_picture(const std::string& name, const std::string& title, const std::vector<Panel>& panels) {
        std::vector<render::Image> images;
        std::vector<std::string> labels;
        for (const Panel& panel : panels) {
            images.push_back(panel.image);
            labels.push_back(panel.label);
        }
        const render::Image joined = render::side_by_side(images);
        const std::vector<std::byte> png = value_of(image::encode_small_png(joined));
        const std::string bytes(reinterpret_cast<const char*>(png.data()), png.size());
        run_.pictures.push_back({stem_of(name), title, report::base64(bytes), std::move(labels)});
        if (arguments_.picture_folder.empty()) return;
        fs::create_directories(arguments_.picture_folder);
        const fs::path file = fs::path(arguments_.picture_folder) / (stem_of(name) + ", " + title + ".png");
        if (const Status written = render::write_png(file, joined); !written)
            throw std::runtime_error(written.error().message);
    }

    // One parameter at a time, points chosen as a bake does, as in the paper's figures 5 to 8.
    void vary(const std::string& name) {
        const mesh::Model model = load(name);
        const Varied varied{name, model, views_around(model)};
        value_of(full_.upload(render::drawable(model, model.mesh)));
        const std::uint32_t finest = paper_steps.front();
        std::vector<Panel> panels;
        const auto begin = [&] { panels = {{"full model", panel(full_, model)}}; };
        const auto add = [&](const std::string& label, const Setting& setting) {
            panels.push_back({label, try_setting(varied, setting)});
        };
        for (const NamedFilter& filter : filters) {
            const bool is_shown = filter.filter == points::ResampleOptions{}.filter;
            begin();
            for (const std::uint32_t side : paper_steps)
                add(std::to_string(side) + " px", {"side", filter, finest, side, 1.0});
            if (is_shown) add_picture(name, "image size T3", panels);
            begin();
            for (const std::uint32_t slices : paper_steps)
                add(std::to_string(slices) + " slices", {"slices", filter, slices, finest, 1.0});
            if (is_shown) add_picture(name, "slices T1", panels);
        }
        begin();
        for (const double size : paper_point_sizes)
            add(fixed(size, 2) + " of what fits", {"point size", filters[0], finest, finest, size});
        add_picture(name, "point size T2", panels);
        begin();
        for (const NamedFilter& filter : filters)
            add(std::string("filter ") + filter.name, {"filter", filter, finest, finest, 2.0 / 3.0});
        add_picture(name, "filters, points at 0.67 of what fits", panels);
    }

    struct Varied {
        const std::string& name;
        const mesh::Model& model;
        std::vector<CloseView> views;
    };
    struct Setting {
        const char* varied;
        NamedFilter filter;
        std::uint32_t slices, side;
        double point_size;
    };

    // Adds a row and gives the picture.
    render::Image try_setting(const Varied& varied, const Setting& setting) {
        codec::Points cloud = choose(varied.model, {setting.slices, setting.side}, setting.filter.filter);
        for (points::Level& level : cloud.levels) level.radius *= setting.point_size;
        proto::PointsSetting row;
        row.model = stem_of(varied.name);
        row.varied = setting.varied;
        row.filter = setting.filter.name;
        row.slices = setting.slices;
        row.side = setting.side;
        row.point_size = setting.point_size;
        row.points = cloud.cloud.positions.size();
        look_from_around(varied.views, cloud, row);
        run_.settings.push_back(row);
        value_of(points_.upload(cloud));
        return panel(points_, varied.model);
    }

    // How the silhouettes of one instance match, and the holes of what faces the eye.
    void look_from_around(const std::vector<CloseView>& views, const codec::Points& cloud, proto::PointsSetting& row) {
        const auto drawn = [&](const codec::Points& content, const CloseView& from) {
            value_of(points_.upload(content));
            return report::silhouette(
                value_of(points_.draw(from.view, report::silhouette_options({close_side, close_side}))).image);
        };
        report::SilhouetteScore score;
        for (const CloseView& from : views) {
            score.add(report::match(drawn(cloud, from), from.full));
            const report::Holes holes = report::holes_in(drawn(facing(cloud, from.view.eye), from), from.front);
            row.holes += holes.count;
            row.hole_px += holes.pixels;
        }
        row.views = views.size();
        row.match = match_of(score);
    }

    static render::Image panel(render::Renderer& renderer, const mesh::Model& model) {
        const Box bounds = mesh::bounds(model.mesh);
        shading::View view;
        view.target = model.origin + bounds.center();
        view.eye = view.target + panel_direction * (2.4 * bounds.radius());
        render::DrawOptions options;
        options.width = options.height = panel_side;
        return value_of(renderer.draw(view, options)).image;
    }

    // What a plan weighs against each other (server/planner/point_level.h): the RMS distance of the level of triangles
    // whose picture errs as much as that of the points, over the radius of their discs.
    void compare_with_levels(const std::string& name) {
        const mesh::Model model = load(name);
        const simplify::History history = value_of(simplify::record_history(mesh::Mesh(model.mesh)));
        const metric::SurfaceIndex index(model.mesh);
        const codec::Points cloud = make_cloud(model, model.mesh.triangles.size() / 2);
        const report::CrowdModel crowd = upload(model, cloud, {});
        std::vector<TableRow> table{{"points", "radius px", "error", "triangles", "RMS px", "RMS / radius"}};
        shading::View view = shading::framing_view(crowd.bounds);
        render::DrawOptions options;
        options.width = options.height = 800;
        options.samples = 1;
        const render::Image full = value_of(full_.draw(view, options)).image;
        const double px = shading::pixels_per_unit(view, crowd.bounds, {options.width, options.height});
        const auto error_of = [&](render::Renderer& renderer) {
            return value_of(render::compare(full, value_of(renderer.draw(view, options)).image)).rms;
        };
        for (std::uint64_t points = 64; points <= cloud.cloud.positions.size(); points *= 4) {
            options.instances = {{{}, points}};
            const double error = error_of(points_);
            std::uint64_t low = 4, high = model.mesh.triangles.size();
            while (low + low / 16 + 1 < high) {
                const std::uint64_t middle = (low + high) / 2;
                value_of(full_.upload(render::drawable(model, simplify::cut(history, middle))));
                (error_of(full_) > error ? low : high) = middle;
            }
            const double rms = metric::measure(index, model.mesh, simplify::cut(history, high)).rms * px;
            const double radius = points::level_of(cloud.levels, points).radius * px;
            table.push_back({std::to_string(points), fixed(radius, 2), fixed(error, 2), std::to_string(high),
                             fixed(rms, 3), fixed(rms / radius, 4)});
        }
        std::cout << "\n" << name << ": points and triangles of the same picture error\n" << to_text(table);
    }

    void compare_codecs(const std::string& name) {
        const mesh::Model model = load(name);
        const codec::Points all = make_cloud(model, levels_of(model.mesh, paper_of(name), 1.0)[0]);
        std::vector<TableRow> table{
            {"points", "bits", "radius / step", "plain", "Draco", "in order", "meshopt", "in blocks", "in order"}};
        const double longest = longest_side(mesh::bounds(model.mesh));
        for (std::uint64_t points = 1000; points <= all.cloud.positions.size(); points *= 4)
            for (const int bits : {16, 14, 12, 10}) {
                const PointSizes sizes = point_sizes(points::prefix(all.cloud, points), bits);
                const auto each = [&](std::uint64_t bytes) {
                    return fixed(static_cast<double>(bytes) / static_cast<double>(points), 2);
                };
                table.push_back({std::to_string(points), std::to_string(bits),
                                 fixed(points::level_of(all.levels, points).radius / longest * std::exp2(bits), 1),
                                 each(sizes.plain), each(sizes.draco), each(sizes.draco_in_order), each(sizes.meshopt),
                                 each(sizes.meshopt_blocks), each(sizes.meshopt_in_order)});
            }
        std::cout << "\n" << name << ": bytes a point\n" << to_text(table);
    }

    // What frames of a square of instances take, full models against points by distance.
    void time_crowds(const std::string& name) {
        const mesh::Model model = load(name);
        const PointsPaper* paper = paper_of(name);
        const PointLevels levels = levels_of(model.mesh, paper, scale_of(model.mesh, paper));
        const codec::Points cloud = make_cloud(model, levels[0]);
        const report::CrowdModel crowd = upload(model, cloud, levels);
        for (const std::uint32_t side : arguments_.crowds) {
            proto::PointsCrowd row;
            row.model = stem_of(name);
            row.instances = std::uint64_t{side} * side;
            row.full_triangles = row.instances * model.mesh.triangles.size();
            if (row.full_triangles > most_crowd_triangles) {
                std::cout << row.model << ": " << row.instances << " full models are left out, "
                          << row.full_triangles / 1'000'000 << " million triangles" << std::endl;
                continue;
            }
            time_crowd(crowd, side, row);
            if (paper) row.paper_gain = paper->gain(row.instances);
            // A frame of full models takes as much longer as they have more triangles; one of points does not.
            if (row.paper_gain) row.scaled_gain = std::max(1.0, *row.paper_gain * scale_of(model.mesh, paper));
            run_.crowds.push_back(row);
        }
    }

    // CPU time of all the software renderer's threads, in turns, and the median of each.
    void time_crowd(const report::CrowdModel& crowd, std::uint32_t side, proto::PointsCrowd& row) {
        shading::View view;
        view.target = crowd.bounds.center();
        const double extent = side * report::crowd_spacing;
        view.eye =
            view.target + normalize(Vec3d(0.0, 0.6, 1.0)) * (crowd.bounds.radius() * std::max(extent, crowd_nearest));
        render::DrawOptions options;
        options.width = options.height = report::CrowdOptions{}.canvas.width;
        options.samples = 1;
        options.instances = report::crowd_of(crowd, {side, 1, side}, view.eye);
        std::vector<double> full_ms, points_ms;
        for (int turn = 0; turn < (row.full_triangles <= repeated_crowd_triangles ? turns : 1); ++turn) {
            const auto timed = [&](render::Renderer& renderer, std::vector<double>& cpu_ms) {
                const Stopwatch watch;
                const render::Frame frame = value_of(renderer.draw(view, options));
                cpu_ms.push_back(watch.elapsed().cpu_ms);
                return frame;
            };
            row.points = timed(points_, points_ms).points;
            row.full_triangles = timed(full_, full_ms).triangles;
        }
        row.full_ms = median(full_ms);
        row.points_ms = median(points_ms);
    }

    void print_scores() const {
        std::cout << "\nF of silhouettes, " << arguments_.side << "^3 instances, "
                  << report::orbit_distances.size() * arguments_.directions << " views of 1024x1024 px\n";
        std::vector<TableRow> table{
            {"model", "level", "triangles", "points", "instances", "recall", "precision", "F", "paper's F"}};
        for (const proto::PointsScore& row : run_.scores)
            table.push_back({row.model + (row.is_scaled ? ", scaled" : ""), row.level, std::to_string(row.triangles),
                             std::to_string(row.points), std::to_string(row.instances), fixed(row.match.recall, 4),
                             fixed(row.match.precision, 4), fixed(row.match.f_measure, 4),
                             row.paper_f ? fixed(*row.paper_f, 3) : ""});
        std::cout << to_text(table);
        for (const bool is_scaled : {false, true}) {
            std::vector<double> all;
            for (const proto::PointsScore& row : run_.scores)
                if (row.level == "all" && row.is_scaled == is_scaled) all.push_back(row.match.f_measure);
            if (!all.empty())
                std::cout << "mean F" << (is_scaled ? ", scaled" : "") << ": "
                          << fixed(std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size()), 4)
                          << "\n";
        }
    }

    void print_settings() const {
        std::cout << "\nOne model at " << close_distance << " radii, " << close_views << " views of " << close_side
                  << "x" << close_side << " px\n";
        std::vector<TableRow> table{
            {"model", "varied", "filter", "T1", "T2", "T3", "points", "holes", "hole px", "recall", "precision", "F"}};
        for (const proto::PointsSetting& row : run_.settings)
            table.push_back({row.model, row.varied, row.filter, std::to_string(row.slices), fixed(row.point_size, 2),
                             std::to_string(row.side), std::to_string(row.points), std::to_string(row.holes),
                             std::to_string(row.hole_px), fixed(row.match.recall, 4), fixed(row.match.precision, 4),
                             fixed(row.match.f_measure, 4)});
        std::cout << to_text(table);
    }

    void print_crowds() const {
        std::cout << "\nFrames of crowds, CPU time\n";
        std::vector<TableRow> table{
            {"model", "instances", "full ms", "points ms", "gain", "paper's", "scaled", "full triangles", "points"}};
        for (const proto::PointsCrowd& row : run_.crowds)
            table.push_back({row.model, std::to_string(row.instances), fixed(row.full_ms, 1), fixed(row.points_ms, 1),
                             fixed(row.full_ms / row.points_ms, 2), row.paper_gain ? fixed(*row.paper_gain, 2) : "",
                             row.scaled_gain ? fixed(*row.scaled_gain, 2) : "", std::to_string(row.full_triangles),
                             std::to_string(row.points)});
        std::cout << to_text(table);
    }

    void print_choices() const {
        std::cout
            << "\nPoints against triangles of the same frame time: cases, where points are nearer, where the plan "
               "takes them, and where it takes the nearer\n";
        std::vector<TableRow> table{{"device", "points a triangle", "of a frame", "cases", "points", "taken", "right"}};
        for (const report::ChoiceGroup& group : report::choice_groups(run_.choices))
            table.push_back({group.device, fixed(group.points_per_triangle, 1), fixed(group.frame_share, 4),
                             std::to_string(group.cases), std::to_string(group.points_nearer),
                             std::to_string(group.points_taken), std::to_string(group.right)});
        std::cout << to_text(table);
    }

    Arguments arguments_;
    render::GlContext context_;
    render::Renderer full_, points_;
    std::optional<report::SilhouetteTree> silhouettes_;
    points::ResampleOptions how_;
    proto::PointsRun run_;
};

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    arguments.command_line = lodestream::report::joined(argc, argv);
    CLI::App app("The point-cloud paper's tests of its levels: silhouettes, parameters and frame times of crowds.");
    app.add_option("models", arguments.models, "Files, or sample:NAME");
    app.add_flag("--scores", arguments.scores, "Recall, precision and F of crowds; the default");
    app.add_option("--side", arguments.side, "Instances along each axis of such a crowd")
        ->check(CLI::Range(1, 13))
        ->capture_default_str();
    app.add_option("--directions", arguments.directions, "Views on each of the five orbits")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_flag("--parameters", arguments.parameters, "Holes and F over filters, T1, T2 and T3");
    app.add_flag("--levels", arguments.levels, "Time and memory of making all levels of at most 300,000 points");
    app.add_flag("--paths", arguments.paths, "Points by the CPU's views and by the GPU's: time, and what only one has");
    app.add_flag("--share", arguments.share, "The level of triangles that errs as much as the points do");
    app.add_flag("--codecs", arguments.codecs, "Bytes of levels by other codecs");
    app.add_option(
        "--choices", arguments.store,
        "Points against triangles of the same frame time, and the plan's choice, of all assets of this store");
    app.add_option("--crowds", arguments.crowds, "Frame times of squares of that many instances a side");
    app.add_option("--pictures", arguments.picture_folder, "Write the pictures there");
    app.add_option("--json", arguments.json_file, "Write a file for `lodestream-client report --points`");
    app.footer("Example:\n  lodestream_bench_points bunny.ply --scores --crowds 5 11 17 --json points.json");
    CLI11_PARSE(app, argc, argv);
    if (!arguments.parameters && !arguments.levels && !arguments.paths && !arguments.share && !arguments.codecs &&
        arguments.store.empty() && arguments.crowds.empty())
        arguments.scores = true;
    try {
        lodestream::bench::Bench(std::move(arguments)).run();
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_points: " << error.what() << '\n';
        return 1;
    }
}
