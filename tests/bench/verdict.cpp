#include "tests/bench/verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tests/bench/table.h"

namespace lodestream::bench {

namespace {

const MethodResult* find(const ModelResult& model, const std::string& method) {
    for (const MethodResult& result : model.methods)
        if (result.method == method) return &result;
    return nullptr;
}

double million_triangles_per_second(const ModelResult& model, double ms) {
    return static_cast<double>(model.triangles) / ms / 1e3;
}

std::string percent_of_diagonal(const ModelResult& model, double length) {
    return fixed(100 * length / model.diagonal, 4);
}

TableRow level_row(const ModelResult& model, const MethodResult& method, std::size_t k) {
    const LevelResult& level = method.levels[k];
    return {model.name,
            method.method,
            fixed(level_percents[k], 0),
            std::to_string(level.triangles),
            fixed(level.reached.wall_ms, 0),
            fixed(level.reached.cpu_ms, 0),
            fixed(million_triangles_per_second(model, level.reached.wall_ms), 3),
            level.error ? percent_of_diagonal(model, level.error->rms) : "",
            level.error ? percent_of_diagonal(model, level.error->max) : "",
            level.image ? fixed(level.image->rms, 2) : "",
            level.own_normals_image ? fixed(level.own_normals_image->rms, 2) : "",
            level.image ? fixed(level.image->silhouette_percent, 2) : "",
            fixed(method.prepared.wall_ms, 0),
            method.cut.wall_ms > 0 ? fixed(method.cut.wall_ms, 1) : "",
            method.peak_bytes_per_vertex ? fixed(*method.peak_bytes_per_vertex, 0) : "",
            std::to_string(method.rounds)};
}

std::optional<double> rms_over(const ModelResult& model, const MethodResult& ours, std::size_t level,
                               const char* peer_name) {
    const MethodResult* peer = find(model, peer_name);
    if (peer == nullptr || !ours.levels[level].error || !(peer->levels[level].error->rms > 0)) return {};
    return ours.levels[level].error->rms / peer->levels[level].error->rms;
}

std::optional<double> speed_over(const ModelResult& model, const MethodResult& ours, const char* peer_name,
                                 double Duration::*time) {
    const MethodResult* peer = find(model, peer_name);
    if (peer == nullptr) return {};
    return peer->levels[0].reached.*time / ours.levels[0].reached.*time;
}

// Against the best picture of the others.
std::optional<double> image_over_best(const ModelResult& model, const MethodResult& ours, std::size_t level,
                                      bool own_normals) {
    const std::optional<ImageError>& mine =
        own_normals ? ours.levels[level].own_normals_image : ours.levels[level].image;
    double best = std::numeric_limits<double>::infinity();
    for (const MethodResult& peer : model.methods)
        if (&peer != &ours && peer.levels[level].image) best = std::min(best, peer.levels[level].image->rms);
    if (!mine || !std::isfinite(best) || !(best > 0)) return {};
    return mine->rms / best;
}

struct Rule {
    Target target;
    std::optional<double> (*value)(const ModelResult&, const MethodResult& ours);
};

const std::vector<Rule>& rules() {
    using M = ModelResult;
    using R = MethodResult;
    static const std::vector<Rule> all{
        {{"speed: whole history / OpenMesh to 10 %", 8.0, true},
         [](const M& m, const R& o) { return speed_over(m, o, "openmesh", &Duration::wall_ms); }},
        {{"... in CPU time of all threads", {}, true},
         [](const M& m, const R& o) { return speed_over(m, o, "openmesh", &Duration::cpu_ms); }},
        {{"speed: whole history / meshopt to 10 %", 1.0 / 3.0, true},
         [](const M& m, const R& o) { return speed_over(m, o, "meshopt", &Duration::wall_ms); }},
        {{"... in CPU time of all threads", {}, true},
         [](const M& m, const R& o) { return speed_over(m, o, "meshopt", &Duration::cpu_ms); }},
        {{"RMS at 10 % / CGAL", 1.1, false}, [](const M& m, const R& o) { return rms_over(m, o, 0, "cgal"); }},
        {{"RMS at 1 % / CGAL", 1.1, false}, [](const M& m, const R& o) { return rms_over(m, o, 1, "cgal"); }},
        {{"RMS at 10 % / meshopt", 0.6, false}, [](const M& m, const R& o) { return rms_over(m, o, 0, "meshopt"); }},
        {{"RMS at 1 % / meshopt", 0.6, false}, [](const M& m, const R& o) { return rms_over(m, o, 1, "meshopt"); }},
        {{"image at 10 %, own normals / best peer", 1.0, false},
         [](const M& m, const R& o) { return image_over_best(m, o, 0, true); }},
        {{"image at 1 %, own normals / best peer", 1.0, false},
         [](const M& m, const R& o) { return image_over_best(m, o, 1, true); }},
        {{"image at 10 %, made normals / best peer", 1.0, false},
         [](const M& m, const R& o) { return image_over_best(m, o, 0, false); }},
        {{"image at 1 %, made normals / best peer", 1.0, false},
         [](const M& m, const R& o) { return image_over_best(m, o, 1, false); }},
        {{"peak bytes per input vertex", 250.0, false}, [](const M&, const R& o) { return o.peak_bytes_per_vertex; }},
    };
    return all;
}

double geometric_mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += std::log(value);
    return std::exp(sum / static_cast<double>(values.size()));
}

std::size_t worst(const Verdict& verdict) {
    const auto [least, most] = std::minmax_element(verdict.values.begin(), verdict.values.end());
    return static_cast<std::size_t>((verdict.target.at_least ? least : most) - verdict.values.begin());
}

}  // namespace

bool Verdict::holds(std::size_t model) const {
    return target.at_least ? values[model] >= *target.bound : values[model] <= *target.bound;
}

bool Verdict::holds() const {
    return holds(worst(*this));
}

std::string comparison_table(const ModelResult& model) {
    std::vector<TableRow> rows{{"model", "method", "%", "count", "wall ms", "CPU ms", "Mtri/s", "RMS %", "max %",
                                "image", "own n.", "outline %", "prepare ms", "cut ms", "bytes/vertex", "runs"}};
    for (std::size_t k = 0; k < level_percents.size(); ++k)
        for (const MethodResult& method : model.methods) rows.push_back(level_row(model, method, k));
    return to_text(rows);
}

double busyness(const std::vector<ModelResult>& models) {
    double wall = 0, cpu = 0;
    for (const ModelResult& model : models)
        for (const MethodResult& method : model.methods) {
            if (method.method == "ours") continue;
            wall += method.levels.back().reached.wall_ms;
            cpu += method.levels.back().reached.cpu_ms;
        }
    return wall / cpu;
}

std::vector<Verdict> verdicts(const std::vector<ModelResult>& models) {
    std::vector<Verdict> all;
    for (const Rule& rule : rules()) {
        Verdict verdict{rule.target, {}, {}};
        for (const ModelResult& model : models) {
            const MethodResult* ours = find(model, "ours");
            const std::optional<double> value = ours != nullptr ? rule.value(model, *ours) : std::nullopt;
            if (!value) continue;
            verdict.models.push_back(model.name);
            verdict.values.push_back(*value);
        }
        if (!verdict.values.empty()) all.push_back(verdict);
    }
    return all;
}

std::string verdict_table(const std::vector<Verdict>& verdicts) {
    std::vector<TableRow> rows{{"ratio", "target", "mean", "worst", "on", "holds on", "verdict"}};
    for (const Verdict& verdict : verdicts) {
        const std::size_t w = worst(verdict);
        rows.push_back({verdict.target.what, "", brief(geometric_mean(verdict.values)), brief(verdict.values[w]),
                        verdict.models[w], "", ""});
        if (!verdict.target.bound) continue;
        std::size_t held = 0;
        for (std::size_t k = 0; k < verdict.values.size(); ++k) held += verdict.holds(k) ? 1 : 0;
        rows.back()[1] = (verdict.target.at_least ? ">= " : "<= ") + brief(*verdict.target.bound);
        rows.back()[5] = std::to_string(held) + "/" + std::to_string(verdict.values.size());
        rows.back()[6] = verdict.holds() ? "pass" : "FAIL";
    }
    return to_text(rows);
}

}  // namespace lodestream::bench
