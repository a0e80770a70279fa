#include "common/simplify/assemble.h"

#include <algorithm>
#include <cmath>

namespace lodestream::simplify {

namespace {

struct StepPlace {
    float key;
    std::uint32_t log, step;
};

// All steps in the order of their keys; those of one key in the order in which they were made.
std::vector<StepPlace> in_order(const std::vector<Log>& logs) {
    std::vector<StepPlace> order;
    for (std::uint32_t l = 0; l < logs.size(); ++l)
        for (std::uint32_t s = 0; s < logs[l].heads.size(); ++s) order.push_back({logs[l].heads[s].key, l, s});
    std::stable_sort(order.begin(), order.end(), [](const StepPlace& a, const StepPlace& b) { return a.key < b.key; });
    return order;
}

class Assembler {
  public:
    Assembler(const mesh::Mesh& mesh, const Surface& surface, const std::vector<Log>& logs)
        : mesh_(mesh),
          surface_(surface),
          logs_(logs),
          vertex_of_(surface.wedges().size(), none),
          triangle_of_(surface.geometry().triangle_of.size(), none) {
        reserve();
    }

    void add_base() {
        for (std::uint32_t face = 0; face < triangle_of_.size(); ++face)
            if (surface_.is_live(face)) add_triangle(face);
        end_step();
    }

    void undo(const StepPlace& place) {
        const Log& log = logs_[place.log];
        const Log::Head begin = log.before(place.step), &end = log.heads[place.step];
        std::uint32_t corner = begin.corners;
        for (std::uint32_t d = begin.deaths; d < end.deaths; ++d) add_vertex(log.deaths[d].wedge);
        for (std::uint32_t c = begin.changes; c < end.changes; ++c) add_change(log, c);
        for (std::uint32_t d = begin.deaths; d < end.deaths; ++d)
            for (std::uint32_t k = 0; k < log.deaths[d].corners; ++k, ++corner)
                h_.corner_moves.push_back({3 * triangle_of_[log.corners[corner] / 3] + log.corners[corner] % 3,
                                           vertex_of_[log.deaths[d].wedge]});
        for (std::uint32_t f = begin.faces; f < end.faces; ++f) add_triangle(log.faces[f]);
        end_step();
    }

    History take() { return std::move(h_); }

  private:
    void reserve() {
        std::size_t steps = 1, changes = 0, corners = 0;
        for (const Log& log : logs_) {
            steps += log.heads.size();
            changes += log.changed.size();
            corners += log.corners.size();
        }
        const std::size_t values = vertex_of_.size() + changes;
        h_.steps.reserve(steps);
        h_.positions.reserve(values);
        if (surface_.wedges().has_normals()) h_.normals.reserve(values);
        if (surface_.wedges().has_texture_coordinates()) h_.texture_coordinates.reserve(values);
        if (surface_.wedges().has_colors()) h_.colors.reserve(values);
        h_.changed_vertices.reserve(changes);
        h_.corner_moves.reserve(corners);
        h_.triangles.reserve(triangle_of_.size());
        if (!mesh_.triangle_materials.empty()) h_.triangle_materials.reserve(triangle_of_.size());
    }

    void add_position(const Vec3f& scaled) {
        const int exponent = surface_.geometry().exponent;
        const auto back = [&](float x) { return std::ldexp(x, exponent); };
        h_.positions.emplace_back(back(scaled.x), back(scaled.y), back(scaled.z));
    }

    void add_vertex(std::uint32_t wedge) {
        vertex_of_[wedge] = vertices_++;
        add_position(surface_.geometry().points[surface_.position_of_wedge(wedge)]);
        const Wedges& wedges = surface_.wedges();
        const Attributes a = wedges.attributes(wedge);
        if (wedges.has_normals()) h_.normals.push_back(a.normal);
        if (wedges.has_texture_coordinates()) h_.texture_coordinates.push_back(a.texture_coordinate);
        if (wedges.has_colors()) h_.colors.push_back(a.color);
    }

    void add_change(const Log& log, std::uint32_t change) {
        h_.changed_vertices.push_back(vertex_of_[log.changed[change]]);
        add_position(log.positions[change]);
        if (!log.normals.empty()) h_.normals.push_back(log.normals[change]);
        if (!log.texture_coordinates.empty()) h_.texture_coordinates.push_back(log.texture_coordinates[change]);
        if (!log.colors.empty()) h_.colors.push_back(log.colors[change]);
    }

    void add_triangle(std::uint32_t face) {
        mesh::Triangle t = surface_.face_wedges(face);
        for (std::uint32_t& corner : t) {
            if (vertex_of_[corner] == none) add_vertex(corner);
            corner = vertex_of_[corner];
        }
        triangle_of_[face] = static_cast<std::uint32_t>(h_.triangles.size());
        h_.triangles.push_back(t);
        if (!mesh_.triangle_materials.empty())
            h_.triangle_materials.push_back(mesh_.triangle_materials[surface_.geometry().triangle_of[face]]);
    }

    void end_step() {
        h_.steps.push_back({static_cast<std::uint32_t>(h_.triangles.size()), vertices_,
                            static_cast<std::uint32_t>(h_.changed_vertices.size()),
                            static_cast<std::uint32_t>(h_.corner_moves.size())});
    }

    const mesh::Mesh& mesh_;
    const Surface& surface_;
    const std::vector<Log>& logs_;
    std::vector<std::uint32_t> vertex_of_;    // of each wedge
    std::vector<std::uint32_t> triangle_of_;  // of each face
    std::uint32_t vertices_ = 0;
    History h_;
};

}  // namespace

History assemble(const mesh::Mesh& mesh, const Surface& surface, const std::vector<Log>& logs) {
    const std::vector<StepPlace> order = in_order(logs);
    Assembler assembler(mesh, surface, logs);
    assembler.add_base();
    for (auto step = order.rbegin(); step != order.rend(); ++step) assembler.undo(*step);
    return assembler.take();
}

}  // namespace lodestream::simplify
