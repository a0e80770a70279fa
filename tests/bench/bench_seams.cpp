// lodestream_bench_seams: textured models with seams, beside meshoptimizer's seam handling; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>

#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "server/importer/importer.h"
#include "tests/bench/connectivity.h"
#include "tests/bench/engine.h"
#include "tests/bench/judge.h"
#include "tests/bench/methods.h"
#include "tests/bench/table.h"

namespace lodestream::bench {
namespace {

namespace fs = std::filesystem;

struct Arguments {
    std::vector<std::string> models;
    std::string data = "../shared/data";
    std::string csv_file, picture_folder;
};

constexpr std::array<double, 4> shares_percent{50.0, 25.0, 10.0, 5.0};
// An open edge is a hole where it is farther from the full model's open boundary than a simplified boundary is.
constexpr double hole_distance_percent = 2.0;  // of the diagonal
constexpr double hole_distance_rms = 3.0;      // of the level's RMS error, if that is more
// Where the peer stops so far above the count asked for, it went no further: one such row says it, and does not count.
constexpr double stuck_share = 1.05;

struct SeamLevel {
    std::uint64_t triangles = 0;
    std::uint64_t holes = 0;  // edges
    double rms_percent = 0.0;
    ImageError image;
};

struct SeamResult {
    std::string model;
    double percent = 0.0;
    std::uint64_t asked = 0;  // of meshoptimizer; ours is asked for what that reached
    SeamLevel peer, ours;
};

bool is_stuck(const SeamResult& result) {
    return static_cast<double>(result.peer.triangles) > stuck_share * static_cast<double>(result.asked);
}

std::vector<std::string> default_models(const std::string& data) {
    std::vector<std::string> files;
    for (const char* name : {"gltf/Duck.glb", "gltf/CesiumMan.glb", "gltf/Fox/Fox.gltf", "gltf/dragon_attenuation.glb",
                             "scene/CesiumMilkTruck.glb", "scene/spider_groups.obj", "classic/spot_uv.obj",
                             "hard/capsule_uv/capsule.obj", "hard/fuze/fuze.obj"})
        if (const fs::path file = fs::path(data) / name; fs::exists(file)) files.push_back(file.string());
    return files;
}

// Squares in four shades that fade across the picture: any stretching and any jump shows.
mesh::Image checkers() {
    constexpr std::uint32_t side = 512, square = 32;  // texels
    render::Image image = render::solid(side, side, 255, 255, 255);
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) {
            const bool dark = (x / square + y / square) % 2 == 0;
            std::uint8_t* texel = &image.rgba[4 * (static_cast<std::size_t>(y) * side + x)];
            texel[0] = static_cast<std::uint8_t>(dark ? 40 : 220);
            texel[1] = static_cast<std::uint8_t>(x / 2);
            texel[2] = static_cast<std::uint8_t>(y / 2);
        }
    Result<std::vector<std::byte>> png = render::encode_png(image);
    if (!png) throw std::runtime_error(png.error().message);
    return {"image/png", std::move(*png), side, side};
}

mesh::Model load_textured(const std::string& file) {
    Result<mesh::Model> model = importer::import_file(file);
    if (!model) throw std::runtime_error(model.error().message);
    if (model->mesh.texture_coordinates.empty()) throw std::runtime_error(file + ": has no texture coordinates");
    if (model->images.empty()) {
        model->images.push_back(checkers());
        for (mesh::Material& material : model->materials) material.base_color_texture.image = 0;
    }
    return std::move(*model);
}

// The full model's open edges, as triangles without area, to measure distances to.
std::optional<metric::SurfaceIndex> open_boundary(const mesh::Mesh& full) {
    mesh::Mesh boundary;
    boundary.positions = full.positions;
    for (const auto& [a, b] : open_edges(full)) boundary.triangles.push_back({a, b, b});
    if (boundary.triangles.empty()) return {};
    return metric::SurfaceIndex(boundary);
}

// Counts holes, distances and pixels of levels against one full model.
class SeamJudge {
  public:
    SeamJudge(const mesh::Model& full, Painter& painter)
        : full_(full),
          surface_(full.mesh),
          boundary_(open_boundary(full.mesh)),
          gallery_(painter, full),
          diagonal_(mesh::bounds(full.mesh).diagonal()) {}

    SeamLevel judge(const mesh::Mesh& level) {
        const double rms = metric::measure(surface_, full_.mesh, level).rms;
        return {level.triangles.size(), holes(level, rms), 100 * rms / diagonal_, gallery_.show(level)};
    }
    Gallery& gallery() { return gallery_; }

  private:
    std::uint64_t holes(const mesh::Mesh& level, double rms) const {
        const double near = std::max(hole_distance_percent / 100 * diagonal_, hole_distance_rms * rms);
        std::uint64_t count = 0;
        for (const auto& [a, b] : open_edges(level)) {
            const Vec3d middle = 0.5 * (Vec3d(level.positions[a]) + Vec3d(level.positions[b]));
            if (!boundary_ || boundary_->distance(middle) > near) ++count;
        }
        return count;
    }

    const mesh::Model& full_;
    metric::SurfaceIndex surface_;
    std::optional<metric::SurfaceIndex> boundary_;
    Gallery gallery_;
    double diagonal_;
};

std::vector<SeamResult> compare_seams(const std::string& file, const Arguments& arguments, Painter& painter) {
    const mesh::Model model = load_textured(file);
    const std::string name = fs::path(file).stem().string();
    SeamJudge judge(model, painter);
    const Recording recording = record(model.mesh);
    std::vector<SeamResult> results;
    for (const double percent : shares_percent) {
        SeamResult result{name, percent, 0, {}, {}};
        result.asked =
            static_cast<std::uint64_t>(std::llround(percent / 100 * static_cast<double>(model.mesh.triangles.size())));
        result.peer = judge.judge(simplify_with_seams(model.mesh, result.asked));
        result.ours = judge.judge(cut(recording, result.peer.triangles));
        if (!arguments.picture_folder.empty())
            judge.gallery().write(fs::path(arguments.picture_folder) /
                                  (name + "_" + std::to_string(std::lround(percent)) + ".png"));
        results.push_back(result);
        if (is_stuck(result)) break;
    }
    return results;
}

double image_ratio(const SeamResult& result) {
    return result.ours.image.rms / result.peer.image.rms;
}

std::string seam_table(const std::vector<SeamResult>& results) {
    std::vector<TableRow> rows{{"model", "%", "asked", "meshopt: count", "holes", "RMS %", "image", "outline %",
                                "ours: count", "holes", "RMS %", "image", "outline %", "image ratio", ""}};
    for (const SeamResult& r : results) {
        TableRow row{r.model, fixed(r.percent, 0), std::to_string(r.asked)};
        for (const SeamLevel* level : {&r.peer, &r.ours})
            row.insert(row.end(),
                       {std::to_string(level->triangles), std::to_string(level->holes), fixed(level->rms_percent, 3),
                        fixed(level->image.rms, 2), fixed(level->image.silhouette_percent, 2)});
        row.push_back(fixed(image_ratio(r), 3));
        row.emplace_back(is_stuck(r) ? "meshopt stuck" : "");
        rows.push_back(row);
    }
    return to_text(rows);
}

void print_verdict(const std::vector<SeamResult>& results) {
    std::uint64_t peer_holes = 0, our_holes = 0, compared = 0, better = 0;
    double logarithms = 0;
    for (const SeamResult& r : results) {
        our_holes += r.ours.holes;
        if (is_stuck(r)) continue;
        peer_holes += r.peer.holes;
        ++compared;
        better += image_ratio(r) < 1 ? 1 : 0;
        logarithms += std::log(image_ratio(r));
    }
    const double mean = std::exp(logarithms / static_cast<double>(compared));
    std::cout << to_text(
        {{"what", "value", "target", "verdict"},
         {"open edges that are holes, ours", std::to_string(our_holes), "0", our_holes == 0 ? "pass" : "FAIL"},
         {"the same, meshopt where not stuck", std::to_string(peer_holes), "", ""},
         {"image error below meshopt's", std::to_string(better) + "/" + std::to_string(compared), "all",
          better == compared ? "pass" : "FAIL"},
         {"ratio of image errors, mean", fixed(mean, 3), "", ""}});
}

void write_csv(const std::string& file, const std::vector<SeamResult>& results) {
    std::ofstream out(file);
    out << "model,method,triangles,hole_edges,rms_error_percent,image_rms,silhouette_percent\n";
    for (const SeamResult& r : results)
        for (const bool mine : {false, true}) {
            const SeamLevel& level = mine ? r.ours : r.peer;
            out << r.model << ',' << (mine ? "ours" : "meshopt") << ',' << level.triangles << ',' << level.holes << ','
                << level.rms_percent << ',' << level.image.rms << ',' << level.image.silhouette_percent << '\n';
        }
    if (!out) throw std::runtime_error("cannot write " + file);
}

void run(const Arguments& arguments) {
    Result<Painter> painter = Painter::create();
    if (!painter) throw std::runtime_error(painter.error().message);
    if (!arguments.picture_folder.empty()) fs::create_directories(arguments.picture_folder);
    std::vector<SeamResult> results;
    for (const std::string& file : arguments.models.empty() ? default_models(arguments.data) : arguments.models) {
        std::cerr << file << std::endl;
        for (const SeamResult& result : compare_seams(file, arguments, *painter)) results.push_back(result);
    }
    if (results.empty()) throw std::runtime_error(arguments.data + ": none of the models is there");
    std::cout << seam_table(results) << '\n';
    print_verdict(results);
    if (!arguments.csv_file.empty()) write_csv(arguments.csv_file, results);
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    CLI::App app{
        "Cuts textured models with seams to equal counts: holes, surface error and pictures, ours and meshopt's."};
    app.add_option("--models", arguments.models, "files with texture coordinates; default: those of --data");
    app.add_option("--data", arguments.data, "the folder of test models")->capture_default_str();
    app.add_option("--csv", arguments.csv_file, "where to write the numbers");
    app.add_option("--pictures", arguments.picture_folder, "where to write full model, meshopt's and our level");
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_seams: " << error.what() << std::endl;
        return 1;
    }
}
