#include "common/simplify/assemble.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "common/base/packed_normal.h"

namespace lodestream::simplify {

namespace {

// A log read from its end.
struct Cursor {
    const Log* log;
    std::uint32_t number;       // of the log
    std::size_t heads, deaths;  // entries that are left

    Cursor(const Log& l, std::uint32_t n) : log(&l), number(n), heads(l.heads.size()), deaths(l.deaths.size()) {}
    float key() const { return log->heads[heads - 1].key; }
};

// Whether the step of `a` was made before that of `b`: of one key, those of earlier logs.
bool is_before(const Cursor& a, const Cursor& b) {
    return a.key() != b.key() ? a.key() < b.key() : a.number < b.number;
}

// First the steps are numbered, then every log's are written where they belong, side by side.
class Assembler {
  public:
    Assembler(const Surface& surface, std::vector<Log> logs)
        : surface_(surface),
          logs_(std::move(logs)),
          step_of_(logs_.size()),
          vertex_of_(surface.wedges().size(), none),
          triangle_of_(surface.faces(), none),
          to_source_(std::ldexp(1.0, surface.exponent())) {}

    History run(const Executor& executor) {
        number_base();
        number_steps();
        make_room(executor);
        write_base();
        simplify::run(executor, logs_.size(), [&](std::size_t l) { number_triangles(l); });
        simplify::run(executor, logs_.size(), [&](std::size_t l) { write(l); });
        return std::move(h_);
    }

  private:
    void number_vertex(std::uint32_t wedge) {
        vertex_of_[wedge] = static_cast<std::uint32_t>(h_.moved_corner_ends.size());
        h_.moved_corner_ends.push_back(corners_);
    }

    void number_base() {
        h_.moved_corner_ends.reserve(vertex_of_.size());
        for (std::uint32_t face = 0; face < triangle_of_.size(); ++face) {
            if (!surface_.is_live(face)) continue;
            base_.push_back(face);
            for (const std::uint32_t wedge : surface_.face_wedges(face))
                if (vertex_of_[wedge] == none) {
                    base_wedges_.push_back(wedge);
                    number_vertex(wedge);
                }
        }
        std::size_t steps = 1;
        for (std::size_t l = 0; l < logs_.size(); ++l) {
            steps += logs_[l].heads.size();
            step_of_[l].resize(logs_[l].heads.size());
        }
        h_.steps.reserve(steps);
        h_.steps.push_back(
            {static_cast<std::uint32_t>(base_.size()), static_cast<std::uint32_t>(base_wedges_.size()), 0});
    }

    void number_step(Cursor& c) {
        const Log::Head head = c.log->heads[--c.heads];
        c.deaths -= head.deaths;
        for (std::size_t d = c.deaths; d < c.deaths + head.deaths; ++d) {
            corners_ += c.log->deaths[d].corners;
            number_vertex(c.log->deaths[d].wedge);
        }
        step_of_[c.number][c.heads] = static_cast<std::uint32_t>(h_.steps.size());
        const Step& before = h_.steps.back();
        h_.steps.push_back(
            {before.triangles + head.faces, before.vertices + head.deaths, before.changes + head.changes});
    }

    void number_steps() {
        std::vector<Cursor> latest;  // a heap of the logs that have steps left, the step made last on top
        for (std::uint32_t l = 0; l < logs_.size(); ++l)
            if (!logs_[l].heads.empty()) latest.emplace_back(logs_[l], l);
        std::make_heap(latest.begin(), latest.end(), is_before);
        while (!latest.empty()) {
            std::pop_heap(latest.begin(), latest.end(), is_before);
            Cursor& cursor = latest.back();
            // As long as no other log's step comes first.
            do number_step(cursor);
            while (cursor.heads > 0 && (latest.size() == 1 || is_before(latest.front(), cursor)));
            if (cursor.heads == 0)
                latest.pop_back();
            else
                std::push_heap(latest.begin(), latest.end(), is_before);
        }
    }

    // Room is asked for here and filled side by side: what one thread frees, another does not get again.
    void make_room(const Executor& executor) {
        const Step& all = h_.steps.back();
        const std::size_t values = std::size_t{all.vertices} + all.changes;
        const Wedges& wedges = surface_.wedges();
        std::vector<std::function<void()>> fills;
        const auto plan = [&](auto& values_of, std::size_t count) {
            values_of.reserve(count);
            fills.emplace_back([&values_of, count] { values_of.resize(count); });
        };
        plan(h_.positions, values);
        if (wedges.has_normals()) plan(h_.normals, values);
        if (wedges.has_texture_coordinates()) plan(h_.texture_coordinates, values);
        if (wedges.has_colors()) plan(h_.colors, values);
        plan(h_.changed_vertices, all.changes);
        plan(h_.moved_corners, corners_);
        plan(h_.triangles, all.triangles);
        if (surface_.has_materials()) plan(h_.triangle_materials, all.triangles);
        simplify::run(executor, fills.size(), [&](std::size_t k) { fills[k](); });
    }

    void write_vertex(std::size_t value, std::uint32_t wedge) {
        const Wedges& wedges = surface_.wedges();
        const Attributes a = wedges.attributes(wedge);
        h_.positions[value] = Vec3f(Vec3d(surface_.place_of_wedge(wedge)) * to_source_);
        if (wedges.has_normals()) h_.normals[value] = pack_normal(a.normal);
        if (wedges.has_texture_coordinates()) h_.texture_coordinates[value] = a.texture_coordinate;
        if (wedges.has_colors()) h_.colors[value] = a.color;
    }

    void write_change(std::size_t value, std::size_t number, const Log& log, std::size_t change) {
        h_.changed_vertices[number] = vertex_of_[log.changed[change]];
        h_.positions[value] = Vec3f(Vec3d(log.positions[change]) * to_source_);
        if (!log.normals.empty()) h_.normals[value] = log.normals[change];
        if (!log.texture_coordinates.empty()) h_.texture_coordinates[value] = log.texture_coordinates[change];
        if (!log.colors.empty()) h_.colors[value] = log.colors[change];
    }

    void write_triangle(std::size_t triangle, std::uint32_t face) {
        mesh::Triangle t = surface_.face_wedges(face);
        for (std::uint32_t& corner : t) corner = vertex_of_[corner];
        h_.triangles[triangle] = t;
        if (surface_.has_materials()) h_.triangle_materials[triangle] = surface_.material(face);
    }

    void write_base() {
        for (std::size_t v = 0; v < base_wedges_.size(); ++v) write_vertex(v, base_wedges_[v]);
        for (std::uint32_t t = 0; t < base_.size(); ++t) {
            triangle_of_[base_[t]] = t;
            write_triangle(t, base_[t]);
        }
    }

    void number_triangles(std::size_t log) {
        const std::vector<Log::Head>& heads = logs_[log].heads;
        std::size_t face = 0;
        for (std::size_t i = 0; i < heads.size(); ++i) {
            std::uint32_t triangle = h_.steps[step_of_[log][i] - 1].triangles;
            for (std::uint32_t k = 0; k < heads[i].faces; ++k) triangle_of_[logs_[log].faces[face++]] = triangle++;
        }
    }

    // The log is freed: this is where memory peaks.
    void write(std::size_t number) {
        const Log log = std::move(logs_[number]);
        std::size_t death = 0, change = 0, corner = 0, face = 0;
        for (std::size_t i = 0; i < log.heads.size(); ++i) {
            const Step& before = h_.steps[step_of_[number][i] - 1];
            std::size_t value = std::size_t{before.vertices} + before.changes;
            std::size_t moved = before.vertices > 0 ? h_.moved_corner_ends[before.vertices - 1] : 0;
            for (std::uint32_t k = 0; k < log.heads[i].deaths; ++k, ++death) {
                write_vertex(value++, log.deaths[death].wedge);
                for (std::uint32_t c = 0; c < log.deaths[death].corners; ++c, ++corner)
                    h_.moved_corners[moved++] = 3 * triangle_of_[log.corners[corner] / 3] + log.corners[corner] % 3;
            }
            for (std::uint32_t k = 0; k < log.heads[i].changes; ++k)
                write_change(value++, before.changes + k, log, change++);
            for (std::uint32_t k = 0; k < log.heads[i].faces; ++k)
                write_triangle(before.triangles + k, log.faces[face++]);
        }
    }

    const Surface& surface_;
    std::vector<Log> logs_;
    std::vector<std::vector<std::uint32_t>> step_of_;  // of each log: its steps' numbers
    std::vector<std::uint32_t> base_, base_wedges_;    // faces that never went, and their wedges
    std::vector<std::uint32_t> vertex_of_;             // of each wedge
    std::vector<std::uint32_t> triangle_of_;           // of each face
    std::uint32_t corners_ = 0;                        // that have moved up to the step at hand
    const double to_source_;                           // from scaled lengths
    History h_;
};

}  // namespace

History assemble(const Surface& surface, std::vector<Log> logs, const Executor& executor) {
    return Assembler(surface, std::move(logs)).run(executor);
}

}  // namespace lodestream::simplify
