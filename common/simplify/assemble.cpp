#include "common/simplify/assemble.h"

#include <algorithm>
#include <cmath>

#include "common/base/packed_normal.h"

namespace lodestream::simplify {

namespace {

// A log read from its end.
struct Cursor {
    const Log* log;
    std::uint32_t number;                                // of the log
    std::size_t heads, deaths, changes, corners, faces;  // entries that are left

    Cursor(const Log& l, std::uint32_t n)
        : log(&l),
          number(n),
          heads(l.heads.size()),
          deaths(l.deaths.size()),
          changes(l.changed.size()),
          corners(l.corners.size()),
          faces(l.faces.size()) {}
    float key() const { return log->heads[heads - 1].key; }
};

// Whether the step of `a` was made before that of `b`: of one key, those of earlier logs.
bool is_before(const Cursor& a, const Cursor& b) {
    return a.key() != b.key() ? a.key() < b.key() : a.number < b.number;
}

class Assembler {
  public:
    Assembler(const Surface& surface, const std::vector<Log>& logs)
        : surface_(surface),
          vertex_of_(surface.wedges().size(), none),
          triangle_of_(surface.faces(), none),
          to_source_(std::ldexp(1.0, surface.exponent())) {
        reserve(logs);
    }

    void add_base() {
        for (std::uint32_t face = 0; face < triangle_of_.size(); ++face)
            if (surface_.is_live(face)) add_triangle(face);
        end_step();
    }

    // Undoes the last step of a log.
    void undo(Cursor& c) {
        const Log& log = *c.log;
        const Log::Head head = log.heads[--c.heads];
        c.deaths -= head.deaths;
        c.changes -= head.changes;
        c.faces -= head.faces;
        std::size_t corners = 0;
        for (std::size_t d = c.deaths; d < c.deaths + head.deaths; ++d) corners += log.deaths[d].corners;
        c.corners -= corners;

        std::size_t corner = c.corners;
        for (std::size_t d = c.deaths; d < c.deaths + head.deaths; ++d) {
            for (std::uint32_t k = 0; k < log.deaths[d].corners; ++k, ++corner)
                h_.moved_corners.push_back(3 * triangle_of_[log.corners[corner] / 3] + log.corners[corner] % 3);
            add_vertex(log.deaths[d].wedge);
        }
        for (std::size_t i = c.changes; i < c.changes + head.changes; ++i) add_change(log, i);
        for (std::size_t f = c.faces; f < c.faces + head.faces; ++f) add_triangle(log.faces[f]);
        end_step();
    }

    History take() { return std::move(h_); }

  private:
    void reserve(const std::vector<Log>& logs) {
        std::size_t steps = 1, changes = 0, corners = 0;
        for (const Log& log : logs) {
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
        h_.moved_corners.reserve(corners);
        h_.moved_corner_ends.reserve(vertex_of_.size());
        h_.triangles.reserve(triangle_of_.size());
        if (surface_.has_materials()) h_.triangle_materials.reserve(triangle_of_.size());
    }

    void add_position(const Vec3f& scaled) { h_.positions.emplace_back(Vec3d(scaled) * to_source_); }

    void add_vertex(std::uint32_t wedge) {
        vertex_of_[wedge] = static_cast<std::uint32_t>(h_.moved_corner_ends.size());
        h_.moved_corner_ends.push_back(static_cast<std::uint32_t>(h_.moved_corners.size()));
        add_position(surface_.place_of_wedge(wedge));
        const Wedges& wedges = surface_.wedges();
        const Attributes a = wedges.attributes(wedge);
        if (wedges.has_normals()) h_.normals.push_back(pack_normal(a.normal));
        if (wedges.has_texture_coordinates()) h_.texture_coordinates.push_back(a.texture_coordinate);
        if (wedges.has_colors()) h_.colors.push_back(a.color);
    }

    void add_change(const Log& log, std::size_t change) {
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
        if (surface_.has_materials()) h_.triangle_materials.push_back(surface_.material(face));
    }

    void end_step() {
        h_.steps.push_back({static_cast<std::uint32_t>(h_.triangles.size()),
                            static_cast<std::uint32_t>(h_.moved_corner_ends.size()),
                            static_cast<std::uint32_t>(h_.changed_vertices.size())});
    }

    const Surface& surface_;
    std::vector<std::uint32_t> vertex_of_;    // of each wedge
    std::vector<std::uint32_t> triangle_of_;  // of each face
    const double to_source_;                  // from scaled lengths
    History h_;
};

}  // namespace

History assemble(const Surface& surface, const std::vector<Log>& logs) {
    std::vector<Cursor> latest;  // a heap of the logs that have steps left, the step made last on top
    for (std::uint32_t l = 0; l < logs.size(); ++l)
        if (!logs[l].heads.empty()) latest.emplace_back(logs[l], l);
    std::make_heap(latest.begin(), latest.end(), is_before);

    Assembler assembler(surface, logs);
    assembler.add_base();
    while (!latest.empty()) {
        std::pop_heap(latest.begin(), latest.end(), is_before);
        Cursor& cursor = latest.back();
        // As long as no other log's step comes first.
        do assembler.undo(cursor);
        while (cursor.heads > 0 && (latest.size() == 1 || is_before(latest.front(), cursor)));
        if (cursor.heads == 0)
            latest.pop_back();
        else
            std::push_heap(latest.begin(), latest.end(), is_before);
    }
    return assembler.take();
}

}  // namespace lodestream::simplify
