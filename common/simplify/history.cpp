#include "common/simplify/history.h"

#include <algorithm>
#include <string>

namespace lodestream::simplify {

namespace {

// Where every source vertex is once the steps below `end_step` have been made; walks and shortens only what is asked
// for.
class VertexResolver {
  public:
    VertexResolver(const History& history, std::uint32_t end_step)
        : history_(history), end_step_(end_step), known_(history.vertex_parent.size(), never) {}

    std::uint32_t operator()(std::uint32_t vertex) {
        std::uint32_t end = vertex;
        while (known_[end] == never && history_.vertex_step[end] < end_step_) end = history_.vertex_parent[end];
        if (known_[end] != never) end = known_[end];
        while (known_[vertex] == never) {
            known_[vertex] = end;
            if (history_.vertex_step[vertex] < end_step_) vertex = history_.vertex_parent[vertex];
        }
        return end;
    }

  private:
    const History& history_;
    std::uint32_t end_step_;
    std::vector<std::uint32_t> known_;
};

// The source's vertices in the order of their first use by the level.
class VertexNumbers {
  public:
    explicit VertexNumbers(std::size_t vertices) : number_(vertices, never) {}

    std::uint32_t operator()(std::uint32_t vertex) {
        if (number_[vertex] == never) {
            number_[vertex] = static_cast<std::uint32_t>(used_.size());
            used_.push_back(vertex);
        }
        return number_[vertex];
    }
    const std::vector<std::uint32_t>& used() const { return used_; }

  private:
    std::vector<std::uint32_t> number_;
    std::vector<std::uint32_t> used_;
};

template <class Attribute>
std::vector<Attribute> gather(const std::vector<Attribute>& source, const std::vector<std::uint32_t>& indices) {
    std::vector<Attribute> result;
    if (source.empty()) return result;
    result.reserve(indices.size());
    for (const std::uint32_t index : indices) result.push_back(source[index]);
    return result;
}

bool spans_a_triangle(const std::vector<Vec3f>& positions, const mesh::Triangle& t) {
    return positions[t[0]] != positions[t[1]] && positions[t[1]] != positions[t[2]] &&
           positions[t[2]] != positions[t[0]];
}

Error damaged(const std::string& what) {
    return invalid_input("collapse history: " + what);
}

}  // namespace

mesh::Mesh cut(const mesh::Mesh& source, const History& history, std::uint64_t triangles) {
    const auto& steps = history.triangle_step;
    std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(triangles, steps.size()));
    while (count > 0 && count < steps.size() && steps[count - 1] == steps[count]) --count;
    const std::uint32_t end_step = count < steps.size() ? steps[count] + 1 : 0;

    mesh::Mesh level;
    level.triangles.reserve(count);
    if (!source.triangle_materials.empty()) level.triangle_materials.reserve(count);
    VertexResolver resolve(history, end_step);
    VertexNumbers number(source.positions.size());
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t index = history.triangle_order[i];
        mesh::Triangle t = source.triangles[index];
        for (std::uint32_t& vertex : t) vertex = resolve(vertex);
        if (!spans_a_triangle(source.positions, t)) continue;
        for (std::uint32_t& vertex : t) vertex = number(vertex);
        level.triangles.push_back(t);
        if (!source.triangle_materials.empty()) level.triangle_materials.push_back(source.triangle_materials[index]);
    }
    level.positions = gather(source.positions, number.used());
    level.normals = gather(source.normals, number.used());
    level.texture_coordinates = gather(source.texture_coordinates, number.used());
    level.colors = gather(source.colors, number.used());
    return level;
}

Status validate(const History& history, std::size_t vertices, std::size_t triangles) {
    if (history.vertex_parent.size() != vertices || history.vertex_step.size() != vertices)
        return damaged("it is for another number of vertices");
    if (history.triangle_order.size() != triangles || history.triangle_step.size() != triangles)
        return damaged("it is for another number of triangles");

    const std::uint64_t step_limit = static_cast<std::uint64_t>(vertices) + triangles;
    for (std::size_t v = 0; v < vertices; ++v) {
        const std::uint32_t parent = history.vertex_parent[v], step = history.vertex_step[v];
        if (parent >= vertices) return damaged("vertex " + std::to_string(v) + " merges into none of the mesh");
        if ((parent == v) != (step == never)) return damaged("vertex " + std::to_string(v) + " merges into itself");
        if (step == never) continue;
        if (step >= step_limit) return damaged("vertex " + std::to_string(v) + " has a step that cannot be");
        if (history.vertex_step[parent] <= step)
            return damaged("vertex " + std::to_string(v) + " merges into one that is gone");
    }

    std::vector<bool> seen(triangles, false);
    for (std::size_t i = 0; i < triangles; ++i) {
        const std::uint32_t triangle = history.triangle_order[i], step = history.triangle_step[i];
        if (triangle >= triangles || seen[triangle])
            return damaged("its triangles are no permutation at place " + std::to_string(i));
        seen[triangle] = true;
        if (step != never && step >= step_limit)
            return damaged("triangle " + std::to_string(triangle) + " has a step that cannot be");
        if (i > 0 && step > history.triangle_step[i - 1])
            return damaged("its steps are out of order at place " + std::to_string(i));
    }
    return Nothing{};
}

}  // namespace lodestream::simplify
