#include "server/bake/shapes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "common/mesh/instances.h"
#include "common/mesh/operations.h"
#include "common/scene/placement.h"
#include "common/simplify/history.h"
#include "server/bake/executor.h"
#include "server/bake/seen_surface.h"

namespace lodestream::bake {

namespace {

Result<ShapeLevels> levels_of(const mesh::Mesh& shape, const std::function<bool()>& progress) {
    simplify::RecordOptions options;
    options.progress = [&](double) { return progress(); };
    const Result<simplify::History> history = simplify::record_history(shape, options);
    if (!history) return history.error();
    const metric::SurfaceIndex original(shape, samples_of(shape));
    ShapeLevels levels{{shape, {}}};
    for (std::uint64_t count = shape.triangles.size() / 2; count >= least_shape_triangles; count /= 2) {
        mesh::Mesh level = with_plausible_normals(simplify::cut(*history, count));
        if (level.triangles.size() >= levels.back().mesh.triangles.size()) continue;
        const metric::SurfaceError error = metric::measure(original, shape, level);
        levels.push_back({std::move(level), error});
    }
    return levels;
}

metric::SurfaceError scaled(metric::SurfaceError error, double scale) {
    error.rms *= scale;
    error.max *= scale;
    return error;
}

metric::SurfaceError worse(const metric::SurfaceError& a, const metric::SurfaceError& b) {
    return {std::max(a.rms, b.rms), std::max(a.max, b.max), std::max(a.normal_degrees, b.normal_degrees)};
}

// How a shape is shown.
struct Use {
    std::uint64_t instances = 0;
    double scale = 0.0;  // the largest
};

std::vector<Use> uses_of(const mesh::Model& model) {
    std::vector<Use> uses(model.shapes.size());
    for (const mesh::Instance& instance : model.instances) {
        Use& use = uses[instance.shape];
        ++use.instances;
        use.scale = std::max(use.scale, scene::largest_scale(instance.matrix));
    }
    return uses;
}

// Which level of each shape keeps the model to `most` triangles.
std::vector<std::size_t> choose_levels(const mesh::Model& model, const std::vector<ShapeLevels>& levels,
                                       const std::vector<Use>& uses, std::uint64_t most) {
    std::vector<std::size_t> chosen(levels.size(), 0);
    std::multimap<double, std::size_t> next;  // shapes by what their next level is off
    const auto offer = [&](std::size_t shape) {
        if (chosen[shape] + 1 < levels[shape].size() && uses[shape].instances > 0)
            next.emplace(uses[shape].scale * levels[shape][chosen[shape] + 1].error.max, shape);
    };
    for (std::size_t shape = 0; shape < levels.size(); ++shape) offer(shape);
    std::uint64_t triangles = mesh::triangle_count(model);
    while (triangles > most && !next.empty()) {
        const std::size_t shape = next.extract(next.begin()).mapped();
        const ShapeLevels& own = levels[shape];
        const std::size_t before = own[chosen[shape]].mesh.triangles.size();
        triangles -= uses[shape].instances * (before - own[++chosen[shape]].mesh.triangles.size());
        offer(shape);
    }
    return chosen;
}

}  // namespace

Result<std::vector<ShapeLevels>> make_shape_levels(const mesh::Model& model, const std::function<bool()>& progress) {
    std::vector<std::optional<Result<ShapeLevels>>> made(model.shapes.size());
    all_cores()(made.size(), [&](std::size_t i) { made[i] = levels_of(model.shapes[i], progress); });
    std::vector<ShapeLevels> levels;
    for (std::optional<Result<ShapeLevels>>& one : made) {
        if (!*one) return one->error();
        levels.push_back(**std::move(one));
    }
    return levels;
}

metric::SurfaceError sum(const metric::SurfaceError& a, const metric::SurfaceError& b) {
    return {a.rms + b.rms, a.max + b.max, a.normal_degrees + b.normal_degrees};
}

const ShapeLevel& stand_in(const ShapeLevels& levels) {
    const double slack = stand_in_error * mesh::bounds(levels.front().mesh).diagonal();
    const double most = stand_in_ratio * static_cast<double>(levels.front().mesh.triangles.size());
    std::size_t chosen = 0;
    for (std::size_t i = 1; i < levels.size(); ++i) {
        const bool is_few = static_cast<double>(levels[i - 1].mesh.triangles.size()) <= most;
        if (!is_few || levels[i].error.max <= slack) chosen = i;
    }
    return levels[chosen];
}

WholeModel whole_model(const mesh::Model& model, const std::vector<ShapeLevels>& levels, std::uint64_t most) {
    const std::vector<Use> uses = uses_of(model);
    const std::vector<std::size_t> chosen = choose_levels(model, levels, uses, most);
    WholeModel whole;
    std::vector<mesh::Mesh> shown;
    for (std::size_t shape = 0; shape < levels.size(); ++shape) {
        const ShapeLevel& level = levels[shape][chosen[shape]];
        shown.push_back(level.mesh);
        whole.error = worse(whole.error, scaled(level.error, uses[shape].scale));
    }
    whole.model.mesh = mesh::flattened(model, shown);
    whole.model.materials = model.materials;
    whole.model.images = model.images;
    whole.model.origin = model.origin;
    whole.model.kind = model.kind;
    whole.model.graph = model.graph;
    whole.model.objects = model.objects;
    return whole;
}

}  // namespace lodestream::bake
