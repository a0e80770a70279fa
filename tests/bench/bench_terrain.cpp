// lodestream_bench_terrain: levels of a large terrain, looked at for cracks; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <random>
#include <stdexcept>

#include "client/render/gl_context.h"
#include "common/mesh/operations.h"
#include "common/simplify/history.h"
#include "tests/bench/levels.h"
#include "tests/bench/table.h"
#include "tests/bench/value_of.h"
#include "tests/client/render/terrain_views.h"

namespace lodestream::bench {
namespace {

struct Arguments {
    std::string model = "sample:terrain";
    std::size_t views = 1'000;
    std::filesystem::path pictures;
};

struct Step {
    double triangles;  // share of the whole model's
    double views;      // share of all views: the whole model is dear to draw
};
constexpr Step steps[] = {{1.0, 0.02}, {0.25, 0.18}, {0.05, 0.2}, {0.01, 0.2}, {0.002, 0.2}, {0.0004, 0.2}};
constexpr std::uint64_t most_coded = 3'000'000;  // triangles; larger levels are drawn uncoded, which takes less memory
constexpr double rim = 0.02;                     // of the extent: an open edge farther in is a crack or a T-junction

// As a client gets it, its shading in stripes, so that there are many borders between Gouraud and flat.
codec::Decoded sent(const mesh::Model& model, const mesh::Mesh& level) {
    std::vector<std::uint8_t> gouraud(level.triangles.size());
    for (std::size_t t = 0; t < gouraud.size(); ++t) gouraud[t] = t / 30 % 2;
    if (level.triangles.size() > most_coded) return render::drawable(model, level, gouraud);
    codec::EncodeOptions options;
    options.grid = codec::fit_grid(mesh::bounds(level), level, 0.0, 0.0);
    return value_of(codec::decode_level(value_of(codec::encode_level(model, level, gouraud, options)).glb));
}

// Edges that only one triangle has, inside the terrain: none where neither a crack nor a T-junction is.
std::size_t open_edges(const mesh::Mesh& level) {
    const std::vector<std::uint32_t> first = mesh::weld_positions(level.positions);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    edges.reserve(3 * level.triangles.size());
    for (const auto& triangle : level.triangles)
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t a = first[triangle[i]], b = first[triangle[(i + 1) % 3]];
            edges.emplace_back(std::min(a, b), std::max(a, b));
        }
    std::sort(edges.begin(), edges.end());
    const Box box = mesh::bounds(level);
    const Vec3d margin = rim * box.extent();
    const auto is_inside = [&](std::uint32_t v) {
        const Vec3d p(level.positions[v]);
        return p.x > box.min.x + margin.x && p.x < box.max.x - margin.x && p.z > box.min.z + margin.z &&
               p.z < box.max.z - margin.z;
    };
    std::size_t open = 0;
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i + 1;
        while (end < edges.size() && edges[end] == edges[i]) ++end;
        open += end == i + 1 && is_inside(edges[i].first) && is_inside(edges[i].second) ? 1 : 0;
        i = end;
    }
    return open;
}

// Whether the eye is over the ground and not under a cliff that leans out, as coarse levels have them.
bool is_above(const mesh::Mesh& level, const Vec3d& eye) {
    return std::none_of(level.triangles.begin(), level.triangles.end(), [&](const auto& triangle) {
        const Vec3d a(level.positions[triangle[0]]), b(level.positions[triangle[1]]), c(level.positions[triangle[2]]);
        if (std::max({a.y, b.y, c.y}) <= eye.y) return false;
        const auto side = [&](const Vec3d& p, const Vec3d& q) {
            return (q.x - p.x) * (eye.z - p.z) - (q.z - p.z) * (eye.x - p.x);
        };
        const double u = side(b, c), v = side(c, a), w = side(a, b), sum = u + v + w;
        const bool is_over_it = sum != 0.0 && u / sum >= 0.0 && v / sum >= 0.0 && w / sum >= 0.0;
        return is_over_it && (u * a.y + v * b.y + w * c.y) / sum > eye.y;
    });
}

struct Looked {
    std::size_t views = 0, at_ground = 0, cracks = 0;
};

// Where there is a folder for them.
void keep(const render::Image& image, const std::filesystem::path& pictures, const mesh::Mesh& level,
          const std::string& what) {
    if (pictures.empty()) return;
    value_of(render::write_png(pictures / (what + "-" + std::to_string(level.triangles.size()) + ".png"), image));
}

Looked look(render::Renderer& renderer, const mesh::Model& model, const mesh::Mesh& level, std::size_t views,
            const std::filesystem::path& pictures) {
    std::mt19937 random(1);
    const Box bounds = mesh::bounds(level);
    Looked looked{views};
    for (std::size_t i = 0; i < views;) {
        const Vec3d ground(level.positions[random() % level.positions.size()]);
        const shading::View view = render::any_terrain_view(ground, random);
        if (!is_above(level, view.eye)) continue;
        ++i;
        shading::View world = view;
        world.eye += model.origin;
        world.target += model.origin;
        const render::Frame frame = value_of(renderer.draw(world, render::terrain_picture()));
        const std::size_t cracks = render::cracks(frame.image, view, bounds);
        if (cracks > 0 && looked.cracks == 0) keep(frame.image, pictures, level, "crack");
        looked.cracks += cracks;
        if (!render::looks_at_ground(frame.image)) continue;
        if (++looked.at_ground == views / 4) keep(frame.image, pictures, level, "level");
    }
    return looked;
}

void run(const Arguments& arguments) {
    const mesh::Model model = load_model(arguments.model);
    std::cout << arguments.model << ": " << model.mesh.positions.size() << " vertices, " << model.mesh.triangles.size()
              << " triangles\n";
    const simplify::History history = record_history(model.mesh);
    const render::GlContext context = value_of(render::create_headless_context());
    render::Renderer renderer = value_of(render::Renderer::create());
    std::vector<TableRow> table{{"triangles", "open edges inside", "views", "of ground", "pixels of cracks"}};
    Looked all;
    for (const Step& step : steps) {
        const auto count =
            static_cast<std::uint64_t>(step.triangles * static_cast<double>(model.mesh.triangles.size()));
        const mesh::Mesh level = simplify::cut(history, count);
        value_of(renderer.upload(sent(model, level)));
        const auto views = static_cast<std::size_t>(step.views * static_cast<double>(arguments.views) + 0.5);
        const Looked looked = look(renderer, model, level, views, arguments.pictures);
        table.push_back({std::to_string(level.triangles.size()), std::to_string(open_edges(level)),
                         std::to_string(looked.views), std::to_string(looked.at_ground),
                         std::to_string(looked.cracks)});
        all.views += looked.views;
        all.at_ground += looked.at_ground;
        all.cracks += looked.cracks;
    }
    table.push_back({"all", "", std::to_string(all.views), std::to_string(all.at_ground), std::to_string(all.cracks)});
    std::cout << to_text(table) << "target: no open edge inside, no crack in " << all.views << " views\n";
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    CLI::App app{"Looks for cracks in levels of a terrain, in random views."};
    app.add_option("--model", arguments.model, "a terrain: a file, or sample:terrain[:VERTICES]")
        ->capture_default_str();
    app.add_option("--views", arguments.views, "over all levels")
        ->capture_default_str()
        ->check(CLI::Range(50, 100'000));
    app.add_option("--pictures", arguments.pictures,
                   "an existing folder for a picture of each level, and of its first crack");
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_terrain: " << error.what() << '\n';
        return 1;
    }
}
