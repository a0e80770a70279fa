// lodestream_bench_hlod: a scene's hierarchical levels beside levels of its objects; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <optional>

#include "client/report/machine.h"
#include "common/base/random.h"
#include "common/mesh/instances.h"
#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "common/scene/select.h"
#include "common/simplify/history.h"
#include "server/bake/bake.h"
#include "server/bake/hlod.h"
#include "server/bake/scene_colors.h"
#include "server/bake/shells.h"
#include "server/importer/importer.h"
#include "server/samples/samples.h"
#include "tests/bench/fit.h"
#include "tests/bench/judge.h"
#include "tests/bench/methods.h"
#include "tests/bench/scenes_json.h"
#include "tests/bench/stopwatch.h"
#include "tests/bench/table.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::bench {
namespace {

namespace fs = std::filesystem;

struct Arguments {
    std::string scene = "sample:ship";
    std::vector<std::uint64_t> budgets{1'920, 7'680, 30'000};
    std::string picture_folder;
    std::vector<std::uint64_t> growth;
    std::string json_file;
    std::vector<double> tolerances_px;
    std::size_t views = 500;
};

constexpr std::string_view sample_prefix = "sample:";
constexpr double target_ratio = 0.5;            // of the image error to a peer's
constexpr double target_within_percent = 99.0;  // of the pixels, in image-quality mode
constexpr double target_power = 1.1;            // of bake time by objects: near linear
constexpr const char* grown_scene = "fine-ship";
constexpr int alike_steps = 26;  // a tenth of white, in each channel

mesh::Model load(const std::string& scene) {
    Result<mesh::Model> model = scene.starts_with(sample_prefix)
                                    ? samples::make_sample(scene.substr(sample_prefix.size()))
                                    : importer::import_file(scene);
    if (!model) throw std::runtime_error(model.error().message);
    if (model->objects < 2) throw std::runtime_error(scene + " is one object");
    return mesh::without_instances(*std::move(model));
}

std::vector<mesh::Mesh> objects_of(const mesh::Model& model) {
    std::vector<std::vector<std::uint32_t>> triangles(model.graph.object_nodes.size());
    for (std::uint32_t t = 0; t < model.mesh.triangles.size(); ++t)
        triangles[model.mesh.triangle_objects[t]].push_back(t);
    std::vector<mesh::Mesh> objects;
    for (const std::vector<std::uint32_t>& of_object : triangles)
        if (!of_object.empty()) objects.push_back(mesh::part(model.mesh, of_object));
    return objects;
}

mesh::Mesh joined(const std::vector<mesh::Mesh>& parts) {
    mesh::Mesh all;
    for (const mesh::Mesh& part : parts) mesh::append(all, part);
    return all;
}

mesh::Model with_materials_of(const mesh::Model& model, mesh::Mesh level) {
    mesh::Model out;
    out.mesh = std::move(level);
    out.materials = model.materials;
    out.images = model.images;
    out.origin = model.origin;
    return out;
}

// Puts a tile behind others, whatever attributes each has.
void append(mesh::Model& to, const codec::Decoded& tile) {
    to.origin = tile.origin;
    const auto first_material = static_cast<std::uint32_t>(to.materials.size());
    const auto first_image = static_cast<int>(to.images.size());
    for (mesh::Material material : tile.materials) {
        if (material.base_color_texture.image >= 0) material.base_color_texture.image += first_image;
        to.materials.push_back(std::move(material));
    }
    to.images.insert(to.images.end(), tile.images.begin(), tile.images.end());
    for (const codec::Primitive& primitive : tile.primitives) {
        mesh::Mesh part = primitive.mesh;
        part.colors.resize(part.positions.size(), Rgba8(255));
        part.texture_coordinates.resize(part.positions.size());
        part.triangle_materials.assign(part.triangles.size(), first_material + primitive.material);
        mesh::append(to.mesh, part);
    }
}

// The tree as the server bakes it, and what its tiles decode to.
class Hierarchy {
  public:
    explicit Hierarchy(const mesh::Model& model) {
        proto::Asset asset;
        asset.id = asset.name = "scene";
        const Stopwatch watch;
        const auto goes_on = [](double) { return true; };
        Result<bake::TileTree> tree = store_.put_asset(asset).ok()
                                          ? bake::make_tiles(store_, asset.id, {model, {}, model.mesh}, {}, goes_on)
                                          : fail(ErrorCode::io, "the store takes no asset");
        if (!tree) throw std::runtime_error(tree.error().message);
        tree_ = *std::move(tree);
        baked_ = watch.elapsed();
    }

    const bake::TileTree& tree() const { return tree_; }
    Duration baked() const { return baked_; }

    // What the modes draw of it in this view, and its bytes.
    mesh::Model cut(const scene::View& view, const scene::SelectOptions& options, std::uint64_t& bytes) const {
        mesh::Model drawn;
        bytes = 0;
        for (const std::uint32_t tile : scene::select(tree_.nodes, view, options).nodes) {
            const store::StoredFile file = *store_.file(tree_.hashes[tile], "glb");
            append(drawn, *codec::decode_level(*store::read_file(file.path, file.bytes)));
            bytes += file.bytes;
        }
        return drawn;
    }

  private:
    testing::TemporaryFolder folder_;
    store::Store store_ = *store::Store::open(folder_.path());
    bake::TileTree tree_;
    Duration baked_;
};

// The scene as one mesh: what a plan's levels are cut from, with its shells and without.
class WholeScene {
  public:
    explicit WholeScene(const mesh::Model& model) {
        const Stopwatch watch;
        scene_ = bake::describe_model(model);
        bake::set_history(scene_, *simplify::record_history(mesh::compact(model.mesh)));
        const mesh::Mesh finest = cut_whole(model.mesh.triangles.size());
        shells_ = *bake::make_shells(scene_, finest, [](double) { return true; });
        baked_ = watch.elapsed();
    }

    mesh::Mesh cut_whole(std::uint64_t triangles) const { return simplify::cut(scene_.history, triangles); }
    mesh::Model cut(std::uint64_t triangles) const {
        const bake::Shell* shell = bake::shell_for(shells_, triangles);
        const bake::BakedModel& baked = shell ? shell->baked : scene_;
        mesh::Mesh level = shell ? bake::cut_shell(*shell, triangles) : cut_whole(triangles);
        if (shell && !shell->colored_by.empty()) {
            const mesh::Mesh finest = cut_whole(simplify::triangle_count(simplify::view(scene_.history)));
            const bake::SceneColors colors(scene_.model, mesh::part(finest, shell->colored_by));
            mesh::Model painted = *colors.paint(level);
            painted.origin = scene_.model.origin;
            return painted;
        }
        return with_materials_of(baked.model, std::move(level));
    }
    Duration baked() const { return baked_; }

  private:
    bake::BakedModel scene_;
    std::vector<bake::Shell> shells_;
    Duration baked_;
};

mesh::Model flat(mesh::Model model) {
    model.mesh.normals.clear();
    model.mesh = mesh::with_normals(model.mesh, 0.0);
    return model;
}

// Every object on its own, by this engine: of all levels of all objects those within one error, the largest at which
// the budget holds; an object smaller than that error is left out. The strongest that levels of single objects can be.
class ObjectWise {
  public:
    explicit ObjectWise(const std::vector<mesh::Mesh>& objects) {
        for (const mesh::Mesh& object : objects) levels_.push_back(levels_of(object));
    }

    mesh::Mesh cut(std::uint64_t budget) const {
        double low = 0.0, high = 0.0;
        for (const Levels& levels : levels_) high = std::max(high, levels.back().error);
        for (int step = 0; step < 60; ++step) {
            const double error = 0.5 * (low + high);
            (triangles_within(error) <= budget ? high : low) = error;
        }
        std::vector<mesh::Mesh> parts;
        for (const Levels& levels : levels_) parts.push_back(level_within(levels, high).mesh);
        return joined(parts);
    }

  private:
    struct ObjectLevel {
        mesh::Mesh mesh;
        double error = 0.0;
    };
    using Levels = std::vector<ObjectLevel>;  // finest first

    static Levels levels_of(const mesh::Mesh& object) {
        Levels levels{{object, 0.0}};
        const metric::SurfaceIndex original(object, 4 * object.triangles.size());
        const simplify::History history = *simplify::record_history(mesh::compact(object));
        for (std::uint64_t count = object.triangles.size(); count > 1;) {
            count = count * 3 / 4;
            mesh::Mesh level = simplify::cut(history, count);
            const double error = metric::measure(original, object, level).max;
            levels.push_back({std::move(level), std::max(error, levels.back().error)});
        }
        levels.push_back({{}, std::max(levels.back().error, mesh::bounds(object).radius())});
        return levels;
    }

    static const ObjectLevel& level_within(const Levels& levels, double error) {
        const ObjectLevel* level = &levels.front();
        for (const ObjectLevel& coarser : levels)
            if (coarser.error <= error) level = &coarser;
        return *level;
    }

    std::uint64_t triangles_within(double error) const {
        std::uint64_t triangles = 0;
        for (const Levels& levels : levels_) triangles += level_within(levels, error).mesh.triangles.size();
        return triangles;
    }

    std::vector<Levels> levels_;
};

// Every object to the same share of its triangles by meshopt_simplify, as gltfpack -si does. It leaves every object
// something, so the share falls until the budget holds or it helps no more.
mesh::Mesh equal_ratio(const std::vector<mesh::Mesh>& objects, std::uint64_t triangles, std::uint64_t budget) {
    mesh::Mesh best;
    double share = static_cast<double>(budget) / static_cast<double>(triangles);
    for (int turn = 0; turn < 8; ++turn, share *= 0.7) {
        std::vector<mesh::Mesh> parts;
        for (const mesh::Mesh& object : objects) {
            const auto count = static_cast<std::uint64_t>(share * static_cast<double>(object.triangles.size()));
            parts.push_back(simplify_with_seams(object, std::max<std::uint64_t>(1, count)));
        }
        best = joined(parts);
        if (best.triangles.size() <= budget) break;
    }
    return best;
}

// All objects of one material together to the same share, as gltfpack merges them, by meshopt_simplify and, where that
// stops above it, by meshopt_simplifySloppy, as gltfpack -si -sa does: it keeps no topology and meets the budget.
mesh::Mesh equal_ratio_merged(const mesh::Mesh& mesh, std::uint64_t budget) {
    const double share = static_cast<double>(budget) / static_cast<double>(mesh.triangles.size());
    std::map<std::uint32_t, std::vector<std::uint32_t>> of_material;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) of_material[mesh::material_of(mesh, t)].push_back(t);
    std::vector<mesh::Mesh> parts;
    for (const auto& [material, triangles] : of_material) {
        mesh::Mesh merged = mesh::part(mesh, triangles);
        merged.triangle_objects.clear();
        const auto count = static_cast<std::uint64_t>(share * static_cast<double>(triangles.size()));
        mesh::Mesh part = simplify_with_seams(merged, std::max<std::uint64_t>(1, count));
        parts.push_back(part.triangles.size() > count ? simplify_sloppily(merged, count) : std::move(part));
    }
    return joined(parts);
}

scene::View view_of(const shading::View& from) {
    scene::View view;
    view.eye = from.eye;
    view.target = from.target;
    if (std::abs(normalize(from.target - from.eye).y) > 0.99) view.up = {1, 0, 0};
    view.fov_y_deg = from.fov_y_deg;
    view.width = view.height = picture_side;
    view.near = 1e-3 * distance(from.eye, from.target);
    return view;
}

scene::SelectOptions within_budget(std::uint64_t triangles) {
    scene::SelectOptions options;
    options.budget = triangles;
    return options;
}

void compare(const Arguments& arguments) {
    const mesh::Model model = load(arguments.scene);
    const std::uint64_t triangles = model.mesh.triangles.size();
    const Hierarchy hierarchy(model);
    const WholeScene whole(model);
    std::printf("%s: %u objects, %llu triangles; %zu tiles baked in %.1f s (%.1f s CPU)\n", arguments.scene.c_str(),
                model.objects, static_cast<unsigned long long>(triangles), hierarchy.tree().nodes.size(),
                1e-3 * hierarchy.baked().wall_ms, 1e-3 * hierarchy.baked().cpu_ms);
    const std::vector<mesh::Mesh> objects = objects_of(model);
    const ObjectWise object_wise(objects);
    std::printf("the scene as one mesh: recorded with its shells in %.1f s (%.1f s CPU)\n",
                1e-3 * whole.baked().wall_ms, 1e-3 * whole.baked().cpu_ms);
    Result<Painter> painter = Painter::create();
    if (!painter) throw std::runtime_error(painter.error().message);
    Gallery gallery(*painter, model, views_from_26(model));
    if (!arguments.picture_folder.empty()) fs::create_directories(arguments.picture_folder);

    std::vector<TableRow> rows{{"budget", "method", "triangles", "image error", "outline %", "ours / it"}};
    for (const std::uint64_t budget : arguments.budgets) {
        const auto view = view_of(views_from_26(model).front());
        std::uint64_t bytes = 0;
        const std::vector<std::pair<std::string, mesh::Model>> levels{
            {"hierarchical", hierarchy.cut(view, within_budget(budget), bytes)},
            {"plan's level", whole.cut(budget)},
            {"plan's level, flat", flat(whole.cut(budget))},
            {"one mesh", with_materials_of(model, whole.cut_whole(budget))},
            {"object-wise", with_materials_of(model, object_wise.cut(budget))},
            {"equal ratio", with_materials_of(model, equal_ratio(objects, triangles, budget))},
            {"equal ratio, merged", with_materials_of(model, equal_ratio_merged(model.mesh, budget))}};
        std::printf("%llu: the tiles are %.1f kB\n", static_cast<unsigned long long>(budget),
                    1e-3 * static_cast<double>(bytes));
        std::optional<ImageError> ours;
        for (const auto& [name, level] : levels) {
            const ImageError error = gallery.show(level);
            if (!ours) ours = error;
            rows.push_back({std::to_string(budget), name, std::to_string(level.mesh.triangles.size()), brief(error.rms),
                            brief(error.silhouette_percent), fixed(ours->rms / error.rms, 2)});
        }
        if (!arguments.picture_folder.empty())
            gallery.write(fs::path(arguments.picture_folder) / ("hlod-" + std::to_string(budget) + ".png"));
    }
    std::printf("%s(target: at most %.1f of either)\n", to_text(rows).c_str(), target_ratio);
}

// From anywhere outside of the sphere around the model, near and far, at any place of it.
std::vector<shading::View> random_views(const mesh::Model& model, std::size_t count) {
    Random random(5);
    const Box box = mesh::bounds(model.mesh);
    const auto any = [&] { return Vec3d{random.uniform(), random.uniform(), random.uniform()}; };
    std::vector<shading::View> views;
    while (views.size() < count) {
        const Vec3d direction = any() - 0.5;
        if (length(direction) > 0.5 || length(direction) < 0.01) continue;
        shading::View view;
        view.target = model.origin + box.min + box.extent() * any();
        view.eye = model.origin + box.center() + normalize(direction) * box.radius() * random.log_uniform(1.0, 8.0);
        view.light = normalize(direction) + Vec3d{0, 0.4, 0};
        views.push_back(view);
    }
    return views;
}

// Pixels of `a` of which some one of `b` within so many pixels is alike, of those that either covers.
struct Within {
    std::uint64_t covered = 0, silhouette = 0, color = 0;

    void add(const render::Image& a, const render::Image& b, int radius_px) {
        const int width = static_cast<int>(a.width), height = static_cast<int>(a.height);
        const auto pixel = [&](const render::Image& image, int x, int y) {
            return &image.rgba[4 * (static_cast<std::size_t>(y) * image.width + static_cast<std::size_t>(x))];
        };
        const auto is_background = [](const std::uint8_t* p) { return p[0] == 255 && p[1] == 255 && p[2] == 255; };
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint8_t* here = pixel(a, x, y);
                if (is_background(here) && is_background(pixel(b, x, y))) continue;
                ++covered;
                bool same_side = false, alike = false;
                for (int r = 0; r <= radius_px && !alike; ++r)
                    for (int dy = -r; dy <= r && !alike; ++dy)
                        for (int dx = -r; dx <= r && !alike; dx += std::abs(dy) == r || r == 0 ? 1 : 2 * r) {
                            if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height) continue;
                            const std::uint8_t* there = pixel(b, x + dx, y + dy);
                            same_side = same_side || is_background(here) == is_background(there);
                            alike = std::abs(here[0] - there[0]) <= alike_steps &&
                                    std::abs(here[1] - there[1]) <= alike_steps &&
                                    std::abs(here[2] - there[2]) <= alike_steps;
                        }
                silhouette += same_side || alike ? 1 : 0;
                color += alike ? 1 : 0;
            }
    }
};

// Image-quality mode: how many pixels are right within the tolerance.
void judge_quality(const Arguments& arguments) {
    const mesh::Model model = load(arguments.scene);
    const Hierarchy hierarchy(model);
    Result<Painter> painter = Painter::create();
    if (!painter) throw std::runtime_error(painter.error().message);
    const std::vector<shading::View> views = random_views(model, arguments.views);
    const std::vector<render::Image> full = painter->draw(model, model.mesh, views);
    std::vector<TableRow> rows{{"tolerance px", "triangles", "outline within %", "colour within %", "worst view"}};
    for (const double tolerance : arguments.tolerances_px) {
        Within all;
        double triangles = 0.0, worst = 100.0;
        for (std::size_t i = 0; i < views.size(); ++i) {
            scene::SelectOptions options;
            options.tolerance_px = tolerance;
            std::uint64_t bytes = 0;
            const mesh::Model cut = hierarchy.cut(view_of(views[i]), options, bytes);
            const render::Image shown = painter->draw(cut, cut.mesh, {views[i]}).front();
            Within one;
            const int radius_px = static_cast<int>(std::ceil(tolerance));
            one.add(full[i], shown, radius_px);
            one.add(shown, full[i], radius_px);
            if (one.covered > 0)
                worst = std::min(worst, 100.0 * static_cast<double>(one.color) / static_cast<double>(one.covered));
            triangles += static_cast<double>(cut.mesh.triangles.size()) / static_cast<double>(views.size());
            all.covered += one.covered;
            all.silhouette += one.silhouette;
            all.color += one.color;
        }
        const auto covered = static_cast<double>(std::max<std::uint64_t>(1, all.covered));
        rows.push_back({brief(tolerance), brief(triangles),
                        fixed(100.0 * static_cast<double>(all.silhouette) / covered, 2),
                        fixed(100.0 * static_cast<double>(all.color) / covered, 2), fixed(worst, 2)});
    }
    std::printf(
        "%s: %zu views, pixels of either picture that the other has within the tolerance\n%s(target: %.0f %%)\n",
        arguments.scene.c_str(), views.size(), to_text(rows).c_str(), target_within_percent);
}

proto::SceneBake bake_ship(std::uint64_t objects) {
    Result<mesh::Model> model = samples::fine_ship(objects);
    if (!model) throw std::runtime_error(model.error().message);
    const testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());
    proto::Asset asset;
    asset.id = asset.name = grown_scene;
    const Stopwatch watch;
    const Result<proto::Asset> baked = bake::bake(store, asset, *std::move(model));
    const Duration took = watch.elapsed();
    if (!baked) throw std::runtime_error(baked.error().message);
    const proto::Hierarchy tree = baked->hierarchy.value_or(proto::Hierarchy{});
    return {grown_scene, objects,      baked->triangles,        tree.tiles, tree.bytes, took.wall_ms,
            took.cpu_ms, tree.bake_ms, baked->peak_memory_bytes};
}

// Ships of more and more objects, the fewest first: the most memory that the process had is the last one's.
proto::SceneRun grow(std::vector<std::uint64_t> counts) {
    std::sort(counts.begin(), counts.end());
    proto::SceneRun run;
    std::vector<TableRow> rows{{"objects", "triangles", "tiles", "MB of tiles", "wall s", "of that tiles", "CPU s",
                                "CPU us/triangle", "peak MB"}};
    std::vector<Sample> by_logarithm;
    for (const std::uint64_t count : counts) {
        const proto::SceneBake bake = bake_ship(count);
        rows.push_back({std::to_string(count), std::to_string(bake.triangles), std::to_string(bake.tiles),
                        fixed(1e-6 * static_cast<double>(bake.bytes), 1), fixed(1e-3 * bake.wall_ms, 2),
                        fixed(1e-3 * bake.tiles_ms, 2), fixed(1e-3 * bake.cpu_ms, 2),
                        fixed(1e3 * bake.cpu_ms / static_cast<double>(bake.triangles), 2),
                        fixed(1e-6 * static_cast<double>(bake.peak_memory_bytes), 0)});
        std::printf("%s\n", rows.back().front().c_str());
        std::fflush(stdout);
        by_logarithm.push_back({std::log(static_cast<double>(count)), std::log(bake.cpu_ms)});
        run.bakes.push_back(bake);
    }
    std::printf("%s", to_text(rows).c_str());
    if (counts.front() < counts.back())
        std::printf("CPU time grows with the %.2f-th power of the objects (target: at most %.1f)\n",
                    fit_line(by_logarithm).slope, target_power);
    return run;
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    CLI::App app{
        "Draws a scene at equal triangles from its hierarchy, from levels of its objects and at an equal ratio."};
    app.add_option("--scene", arguments.scene, "a file of several objects, or sample:ship:COUNT")
        ->capture_default_str();
    app.add_option("--budgets", arguments.budgets, "triangles")->capture_default_str();
    app.add_option("--pictures", arguments.picture_folder, "where to write full scene, ours, object-wise, equal ratio");
    app.add_option("--quality", arguments.tolerances_px,
                   "instead: pixels within these tolerances of image-quality mode, px");
    app.add_option("--views", arguments.views, "of --quality")->capture_default_str();
    app.add_option("--growth", arguments.growth, "instead: bake fine ships of so many objects");
    app.add_option("--json", arguments.json_file, "of --growth: a file for `lodestream-client report --scenes`");
    CLI11_PARSE(app, argc, argv);
    try {
        if (!arguments.growth.empty()) {
            const lodestream::proto::SceneRun run = lodestream::bench::grow(arguments.growth);
            if (!arguments.json_file.empty())
                lodestream::bench::write_scene_run(arguments.json_file, lodestream::report::joined(argc, argv), run);
        } else if (!arguments.tolerances_px.empty())
            lodestream::bench::judge_quality(arguments);
        else {
            lodestream::bench::compare(arguments);
        }
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_hlod: " << error.what() << std::endl;
        return 1;
    }
}
