#include "common/simplify/history.h"

#include <algorithm>
#include <functional>
#include <string>

#include "common/base/packed_normal.h"

namespace lodestream::simplify {

namespace {

// The steps of the level of the most triangles that is not above `triangles`.
std::size_t step_count(const HistoryView& history, std::uint64_t triangles) {
    const auto end = std::upper_bound(history.steps.begin(), history.steps.end(), triangles,
                                      [](std::uint64_t n, const Step& step) { return n < step.triangles; });
    return static_cast<std::size_t>(end - history.steps.begin());
}

// Of every vertex the entry of the value arrays that is its latest.
std::vector<std::uint32_t> latest_values(const HistoryView& history, std::size_t steps) {
    std::vector<std::uint32_t> value_of;
    value_of.reserve(history.steps[steps - 1].vertices);
    std::uint32_t value = 0, change = 0;
    for (const Step& step : history.steps.first(steps)) {
        while (value_of.size() < step.vertices) value_of.push_back(value++);
        while (change < step.changes) value_of[history.changed_vertices[change++]] = value++;
    }
    return value_of;
}

template <class Value, class Attribute, class Convert>
void gather(std::span<const Value> values, const std::vector<std::uint32_t>& value_of, std::vector<Attribute>& result,
            Convert convert) {
    if (values.empty()) return;
    result.reserve(value_of.size());
    for (const std::uint32_t value : value_of) result.push_back(convert(values[value]));
}

bool spans_a_triangle(const std::vector<Vec3f>& positions, const mesh::Triangle& t) {
    return positions[t[0]] != positions[t[1]] && positions[t[1]] != positions[t[2]] &&
           positions[t[2]] != positions[t[0]];
}

// Merges over long distances can lay two corners of a triangle on one spot.
void drop_folded(mesh::Mesh& level) {
    const auto spans = [&](const mesh::Triangle& t) { return spans_a_triangle(level.positions, t); };
    if (std::all_of(level.triangles.begin(), level.triangles.end(), spans)) return;
    std::size_t kept = 0;
    for (std::size_t t = 0; t < level.triangles.size(); ++t) {
        if (!spans(level.triangles[t])) continue;
        level.triangles[kept] = level.triangles[t];
        if (!level.triangle_materials.empty()) level.triangle_materials[kept] = level.triangle_materials[t];
        ++kept;
    }
    level.triangles.resize(kept);
    if (!level.triangle_materials.empty()) level.triangle_materials.resize(kept);
}

Error damaged(const std::string& what) {
    return invalid_input("collapse history: " + what);
}

bool fits(std::size_t attribute, std::size_t elements) {
    return attribute == 0 || attribute == elements;
}

bool grows(const Step& before, const Step& after) {
    return before.triangles <= after.triangles && before.vertices <= after.vertices && before.changes <= after.changes;
}

Status validate_sizes(const HistoryView& h) {
    const Step end = h.steps.empty() ? Step{} : h.steps.back();
    if (h.triangles.size() != end.triangles || !fits(h.triangle_materials.size(), end.triangles))
        return damaged("its triangles are not as many as its steps make");
    if (h.changed_vertices.size() != end.changes) return damaged("its changes are not as many as its steps make");
    if (h.moved_corner_ends.size() != end.vertices)
        return damaged("its corner moves are not for as many vertices as its steps make");
    if (h.moved_corners.size() != (end.vertices == 0 ? 0 : h.moved_corner_ends.back()))
        return damaged("its corner moves are not as many as its vertices take");
    const std::size_t values = std::size_t{end.vertices} + end.changes;
    if (h.positions.size() != values || !fits(h.normals.size(), values) ||
        !fits(h.texture_coordinates.size(), values) || !fits(h.colors.size(), values))
        return damaged("its values are not as many as its steps make");
    return Nothing{};
}

Status validate_step(const HistoryView& h, const Step& before, const Step& after) {
    if (!grows(before, after)) return damaged("a step takes back what an earlier one made");
    for (std::uint32_t i = before.changes; i < after.changes; ++i)
        if (h.changed_vertices[i] >= after.vertices) return damaged("a step changes a vertex that is not there yet");
    for (std::uint32_t v = before.vertices; v < after.vertices; ++v) {
        const std::uint32_t begin = v == 0 ? 0 : h.moved_corner_ends[v - 1], end = h.moved_corner_ends[v];
        if (end < begin || end > h.moved_corners.size()) return damaged("a vertex takes corners that are not there");
        for (std::uint32_t i = begin; i < end; ++i)
            if (h.moved_corners[i] / 3 >= before.triangles)
                return damaged("a step moves a corner that is not there yet");
    }
    for (std::uint32_t t = before.triangles; t < after.triangles; ++t)
        for (const std::uint32_t vertex : h.triangles[t])
            if (vertex >= after.vertices) return damaged("a triangle uses a vertex that is not there yet");
    return Nothing{};
}

}  // namespace

HistoryView view(const History& h) {
    return {h.steps,         h.positions,         h.normals,   h.texture_coordinates, h.colors, h.changed_vertices,
            h.moved_corners, h.moved_corner_ends, h.triangles, h.triangle_materials};
}

std::uint64_t triangle_count(const HistoryView& history) {
    return history.triangles.size();
}

std::uint64_t triangles_within(const HistoryView& history, std::uint64_t triangles) {
    const std::size_t steps = step_count(history, triangles);
    return steps == 0 ? 0 : history.steps[steps - 1].triangles;
}

mesh::Mesh cut(const HistoryView& history, std::uint64_t triangles) {
    mesh::Mesh level;
    const std::size_t steps = step_count(history, triangles);
    if (steps == 0) return level;
    const Step& end = history.steps[steps - 1];

    const auto prefix = history.triangles.first(end.triangles);
    level.triangles.assign(prefix.begin(), prefix.end());
    std::uint32_t moved = 0;
    for (std::uint32_t vertex = 0; vertex < end.vertices; ++vertex)
        for (const std::uint32_t moved_end = history.moved_corner_ends[vertex]; moved < moved_end; ++moved)
            level.triangles[history.moved_corners[moved] / 3][history.moved_corners[moved] % 3] = vertex;
    if (!history.triangle_materials.empty()) {
        const auto materials = history.triangle_materials.first(end.triangles);
        level.triangle_materials.assign(materials.begin(), materials.end());
    }

    const std::vector<std::uint32_t> value_of = latest_values(history, steps);
    gather(history.positions, value_of, level.positions, std::identity());
    gather(history.normals, value_of, level.normals, unpack_normal);
    gather(history.texture_coordinates, value_of, level.texture_coordinates, std::identity());
    gather(history.colors, value_of, level.colors, std::identity());
    drop_folded(level);
    return level;
}

Status validate(const HistoryView& history) {
    if (Status sizes = validate_sizes(history); !sizes) return sizes.error();
    Step before;
    for (const Step& step : history.steps) {
        if (Status valid = validate_step(history, before, step); !valid) return valid.error();
        before = step;
    }
    for (const Vec3f& position : history.positions)
        if (!all_finite(position)) return damaged("a position is not finite");
    for (const Vec2f& uv : history.texture_coordinates)
        if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) return damaged("a texture coordinate is not finite");
    return Nothing{};
}

}  // namespace lodestream::simplify
