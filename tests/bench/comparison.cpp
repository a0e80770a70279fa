#include "tests/bench/comparison.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/mesh/operations.h"
#include "tests/bench/engine.h"

namespace lodestream::bench {

namespace {

constexpr double smooth_degrees = 180.0;
const Vec4f surface_color{0.5f, 0.5f, 0.5f, 1.0f};

std::vector<std::uint64_t> counts_of(const mesh::Mesh& mesh) {
    std::vector<std::uint64_t> counts;
    for (const double percent : level_percents)
        counts.push_back(
            static_cast<std::uint64_t>(std::llround(percent / 100.0 * static_cast<double>(mesh.triangles.size()))));
    return counts;
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

template <class Pick>
Duration median_of(const std::vector<Run>& runs, Pick pick) {
    std::vector<double> wall, cpu;
    for (const Run& run : runs) {
        const Duration duration = pick(run);
        wall.push_back(duration.wall_ms);
        cpu.push_back(duration.cpu_ms);
    }
    return {median(wall), median(cpu)};
}

double seconds_spent(const std::vector<Run>& runs) {
    double ms = 0;
    for (const Run& run : runs) ms += run.levels.back().reached.wall_ms;
    return ms / 1e3;
}

// One run of each method a round, so that a busy moment of the machine hits all of them.
std::vector<std::vector<Run>> run_in_turns(const mesh::Mesh& mesh, const std::vector<std::uint64_t>& counts,
                                           const ComparisonOptions& options) {
    std::vector<std::vector<Run>> runs(options.methods.size());
    for (int round = 0; round < options.max_rounds; ++round)
        for (std::size_t m = 0; m < options.methods.size(); ++m)
            if (round == 0 || seconds_spent(runs[m]) < options.seconds_per_method)
                runs[m].push_back(options.methods[m].run(mesh, counts));
    return runs;
}

MethodResult timed(const std::string& method, const std::vector<Run>& runs, const std::vector<std::uint64_t>& counts) {
    MethodResult result;
    result.method = method;
    result.rounds = static_cast<int>(runs.size());
    result.prepared = median_of(runs, [](const Run& run) { return run.prepared; });
    result.cut = median_of(runs, [](const Run& run) { return run.cut; });
    for (std::size_t k = 0; k < counts.size(); ++k) {
        result.levels[k].asked = counts[k];
        result.levels[k].triangles = runs.front().levels[k].mesh.triangles.size();
        result.levels[k].reached = median_of(runs, [&](const Run& run) { return run.levels[k].reached; });
    }
    return result;
}

mesh::Model plain_model(const mesh::Mesh& mesh) {
    mesh::Model model;
    model.mesh = mesh;
    model.materials.emplace_back().base_color = surface_color;
    return model;
}

mesh::Mesh with_recomputed_normals(const mesh::Mesh& level) {
    mesh::Mesh bare;
    bare.positions = level.positions;
    bare.triangles = level.triangles;
    return mesh::with_normals(bare, smooth_degrees);
}

void measure_errors(const mesh::Mesh& full, const std::vector<std::vector<Run>>& runs, ModelResult& result) {
    const metric::SurfaceIndex index(full);
    for (std::size_t m = 0; m < runs.size(); ++m)
        for (std::size_t k = 0; k < level_percents.size(); ++k)
            result.methods[m].levels[k].error = metric::measure(index, full, runs[m].front().levels[k].mesh);
}

void measure_pictures(const mesh::Mesh& full, const std::vector<std::vector<Run>>& runs,
                      const ComparisonOptions& options, ModelResult& result) {
    const mesh::Model model = plain_model(full);
    Gallery gallery(*options.painter, model);
    for (std::size_t k = 0; k < level_percents.size(); ++k) {
        for (std::size_t m = 0; m < runs.size(); ++m) {
            const mesh::Mesh& level = runs[m].front().levels[k].mesh;
            LevelResult& row = result.methods[m].levels[k];
            row.image = gallery.show(with_recomputed_normals(level));
            if (!level.normals.empty()) row.own_normals_image = gallery.show(level);
        }
        if (options.picture_folder.empty()) continue;
        gallery.write(options.picture_folder /
                      (result.name + "_" + std::to_string(std::lround(level_percents[k])) + ".png"));
    }
}

}  // namespace

ModelResult compare_methods(Input input, const ComparisonOptions& options) {
    mesh::Mesh& mesh = input.mesh;
    ModelResult result{
        input.name, mesh.triangles.size(), mesh.positions.size(), mesh::bounds(mesh).diagonal(), input.repairs, {}};
    const std::vector<std::uint64_t> counts = counts_of(mesh);
    const std::vector<std::vector<Run>> runs = run_in_turns(mesh, counts, options);
    for (std::size_t m = 0; m < runs.size(); ++m)
        result.methods.push_back(timed(options.methods[m].name, runs[m], counts));
    if (options.errors) measure_errors(mesh, runs, result);
    if (options.painter != nullptr) measure_pictures(mesh, runs, options, result);
    return result;
}

}  // namespace lodestream::bench
