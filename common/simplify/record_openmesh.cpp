// The recording engine: half-edge collapses by a lazy heap over OpenMesh's connectivity.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>

#include "common/mesh/operations.h"
#include "common/simplify/history.h"
#include "common/simplify/quadric.h"
#include "common/simplify/sheet_mesh.h"
#include "common/simplify/wedges.h"

namespace lodestream::simplify {

namespace {

// What a merge has to leave intact, and the price of not doing so: the harm is taken to be that of moving the area
// around the source by the length of the merge, times `price`. A merge is tried by the first rules, and by the next
// where refused.
struct Rules {
    bool sheets;  // the surface stays manifold, open borders are not left
    bool seams;   // texture, colour and material borders stay whole
    bool shape;   // no triangle turns over, degenerates or becomes a sliver
    double price;
};
constexpr std::array<Rules, 4> rule_levels{
    {{true, true, true, 1e-6}, {false, true, true, 1.0}, {false, false, true, 3.0}, {false, false, false, 30.0}}};
constexpr std::uint8_t refused = rule_levels.size();

// Weights of the planes that hold open borders and seams in place, against those of the triangles.
constexpr double border_weight = 3.0;
constexpr double seam_weight = 1.0;
// A component is dropped once a merge costs more than its area times its squared size times this.
constexpr double drop_weight = 3.0;

constexpr double min_turn_cosine = 0.5;     // a triangle may turn by 60 degrees in one merge
constexpr double degenerate_height = 1e-7;  // of the longest side: the noise of float positions
constexpr double sliver_height = 1e-2;      // of the longest side; thinner only if it was so already

constexpr double retry_share = 0.9;  // refused merges are tried again when this share of the triangles is left
constexpr std::uint32_t iterations_per_report = 8192;
constexpr double infinity = std::numeric_limits<double>::infinity();

// The mesh as positions: numbered densely, in a unit box around the origin (scaled by a power of two: exactly).
struct Geometry {
    std::vector<std::uint32_t> position_of;    // of each vertex
    std::vector<Vec3d> points;                 // of each position
    std::vector<std::uint32_t> triangle_of;    // of each face: the source's triangle
    std::vector<mesh::Triangle> face_corners;  // of each face: positions
    std::vector<std::uint32_t> degenerate;     // triangles that are no faces
};

// Bits 0, 3, 6, … of the result are the 21 bits of `v`.
std::uint64_t spread_bits(std::uint64_t v) {
    v = (v | v << 32) & 0x1f00000000ffffull;
    v = (v | v << 16) & 0x1f0000ff0000ffull;
    v = (v | v << 8) & 0x100f00f00f00f00full;
    v = (v | v << 4) & 0x10c30c30c30c30c3ull;
    return (v | v << 2) & 0x1249249249249249ull;
}

// Place along a Morton curve of a point of the unit box around the origin.
std::uint64_t morton_code(const Vec3d& p) {
    const auto cell = [](double x) { return static_cast<std::uint64_t>(std::clamp(x + 0.5, 0.0, 1.0) * 0x1fffff); };
    return spread_bits(cell(p.x)) | spread_bits(cell(p.y)) << 1 | spread_bits(cell(p.z)) << 2;
}

std::vector<Vec3d> normalized(const std::vector<Vec3f>& positions) {
    Box box;
    for (const Vec3f& p : positions) box.add(Vec3d(p));
    const Vec3d extent = box.extent(), center = box.center();
    const double size = std::max({extent.x, extent.y, extent.z});
    const int exponent = size > 0 ? std::ilogb(size) + 1 : 0;
    std::vector<Vec3d> points;
    points.reserve(positions.size());
    for (const Vec3f& v : positions) {
        const Vec3d p = Vec3d(v) - center;
        points.emplace_back(std::ldexp(p.x, -exponent), std::ldexp(p.y, -exponent), std::ldexp(p.z, -exponent));
    }
    return points;
}

// Faces and positions are numbered along the curve: what is worked on together lies together in memory.
Geometry weld(const mesh::Mesh& mesh) {
    Geometry g;
    const std::vector<Vec3d> points = normalized(mesh.positions);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> along_curve(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const mesh::Triangle& v = mesh.triangles[t];
        along_curve[t] = {morton_code((points[v[0]] + points[v[1]] + points[v[2]]) / 3.0), t};
    }
    std::sort(along_curve.begin(), along_curve.end());

    const std::vector<std::uint32_t> first = mesh::weld_positions(mesh.positions);
    g.position_of.assign(first.size(), none);
    const auto number = [&](std::uint32_t vertex) {
        std::uint32_t& position = g.position_of[first[vertex]];
        if (position == none) {
            position = static_cast<std::uint32_t>(g.points.size());
            g.points.push_back(points[vertex]);
        }
        return position;
    };
    for (const auto& [code, t] : along_curve) {
        mesh::Triangle corners = mesh.triangles[t];
        for (std::uint32_t& c : corners) c = number(c);
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
            g.degenerate.push_back(t);
        } else {
            g.triangle_of.push_back(t);
            g.face_corners.push_back(corners);
        }
    }
    for (std::uint32_t v = 0; v < first.size(); ++v) g.position_of[v] = number(v);
    return g;
}

// The connected parts; merging never joins two, so a position's part is fixed.
struct Components {
    std::vector<std::uint32_t> of_position;
    std::vector<std::uint32_t> first_face;  // of each part, into faces
    std::vector<std::uint32_t> faces;
    std::vector<std::uint32_t> live;           // faces left of each part
    std::vector<double> visibility;            // of each part: what dropping it costs
    std::vector<std::uint32_t> by_visibility;  // parts, least visible first
};

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

Components find_components(const Geometry& g) {
    std::vector<std::uint32_t> parent(g.points.size());
    std::iota(parent.begin(), parent.end(), 0u);
    for (const mesh::Triangle& t : g.face_corners)
        for (const std::uint32_t corner : t) {
            const std::uint32_t a = root_of(parent, t[0]), b = root_of(parent, corner);
            parent[std::max(a, b)] = std::min(a, b);
        }

    Components c;
    c.of_position.assign(g.points.size(), none);
    for (const mesh::Triangle& t : g.face_corners) {
        std::uint32_t& number = c.of_position[root_of(parent, t[0])];
        if (number == none) {
            number = static_cast<std::uint32_t>(c.live.size());
            c.live.push_back(0);
        }
        ++c.live[number];
    }
    for (std::uint32_t p = 0; p < parent.size(); ++p) c.of_position[p] = c.of_position[root_of(parent, p)];

    c.first_face.assign(c.live.size() + 1, 0);
    std::partial_sum(c.live.begin(), c.live.end(), c.first_face.begin() + 1);
    std::vector<std::uint32_t> next(c.first_face.begin(), c.first_face.end() - 1);
    std::vector<Box> boxes(c.live.size());
    c.faces.resize(g.face_corners.size());
    c.visibility.assign(c.live.size(), 0.0);
    for (std::uint32_t f = 0; f < g.face_corners.size(); ++f) {
        const mesh::Triangle& t = g.face_corners[f];
        const std::uint32_t part = c.of_position[t[0]];
        c.faces[next[part]++] = f;
        c.visibility[part] += 0.5 * length(cross(g.points[t[1]] - g.points[t[0]], g.points[t[2]] - g.points[t[0]]));
        for (const std::uint32_t corner : t) boxes[part].add(g.points[corner]);
    }
    for (std::size_t part = 0; part < boxes.size(); ++part) {
        const Vec3d extent = boxes[part].extent();
        c.visibility[part] *= drop_weight * dot(extent, extent);
    }
    c.by_visibility.resize(c.live.size());
    std::iota(c.by_visibility.begin(), c.by_visibility.end(), 0u);
    std::stable_sort(c.by_visibility.begin(), c.by_visibility.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return c.visibility[a] < c.visibility[b]; });
    return c;
}

class Recorder {
  public:
    Recorder(const mesh::Mesh& mesh, const RecordOptions& options);
    Result<History> run();

  private:
    struct Entry {
        double cost;
        std::uint32_t edge;
        bool operator<(const Entry& other) const {  // for a heap with the cheapest on top
            return cost != other.cost ? cost > other.cost : edge > other.edge;
        }
    };
    struct Candidate {
        HalfedgeHandle halfedge;  // from what merges to what it merges into
        double cost;
    };
    struct Corner {
        std::uint32_t face;
        std::uint32_t corner;  // the one at the merge's source
    };

    void add_planes();
    void add_border_plane(HalfedgeHandle inner, double weight);
    bool is_seam(EdgeHandle edge) const;
    std::uint32_t vertex_at(FaceHandle face, std::uint32_t position) const;

    bool merge_all();
    bool keep_going();
    void retry_refused();
    void allow(EdgeHandle edge);
    Candidate pop();
    void push(EdgeHandle edge);
    double cost(HalfedgeHandle h) const;
    Candidate cheaper_direction(EdgeHandle edge) const;
    bool part_is_gone(std::uint32_t position) const { return dropped_[parts_.of_position[position]]; }

    bool merge(HalfedgeHandle h, const Rules& rules);
    bool gather(std::uint32_t source, std::uint32_t target);
    bool keeps_sheets(std::uint32_t source, std::uint32_t target);
    bool keeps_shape(const Corner& c, std::uint32_t target) const;
    bool keeps_texture(const Corner& c) const;
    bool find_partners(std::uint32_t source, std::uint32_t target, const Rules& rules);
    void commit(std::uint32_t source, std::uint32_t target);

    double area(std::uint32_t face) const;
    const Vec3d& point(std::uint32_t vertex) const { return g_.points[g_.position_of[vertex]]; }
    void vanish(std::uint32_t face);
    void drop_one_by_one(std::vector<std::uint32_t> faces, std::size_t count);
    void drop_part(std::uint32_t part, std::uint32_t keep);
    void drop_parts_cheaper_than(double limit);
    History finish();

    const mesh::Mesh& mesh_;
    const RecordOptions& options_;
    const Geometry g_;
    const Wedges wedges_;
    SheetMesh sheets_;
    OpenMesh::TriConnectivity& connectivity_;
    Components parts_;
    std::vector<mesh::Triangle> face_vertices_;  // of each face: the source's vertices that it has now
    std::vector<Quadric> quadrics_;              // of each position

    std::vector<Entry> heap_;
    std::vector<double> queued_cost_;  // of each edge: its valid entry's; infinity if it has none
    std::vector<std::uint8_t> level_;  // of each half-edge: the rules that it is tried by, or `refused`
    std::vector<EdgeHandle> refused_edges_;
    std::size_t merges_since_retry_ = 0;
    std::size_t retry_below_ = 0;   // faces
    std::vector<bool> dropped_;     // of each part
    std::size_t next_to_drop_ = 0;  // into by_visibility

    // The merge at hand.
    std::vector<Corner> staying_;
    std::vector<std::uint32_t> vanishing_;
    std::vector<Wedges::Pair> told_;
    std::vector<std::uint32_t> used_;
    std::vector<Wedges::Pair> partners_;
    std::vector<EdgeHandle> changed_;

    History history_;
    std::vector<bool> vanished_;  // of each face
    std::size_t live_ = 0;        // faces
    std::uint32_t step_ = 0;
    std::uint32_t iterations_ = 0;
    bool cancelled_ = false;
};

Recorder::Recorder(const mesh::Mesh& mesh, const RecordOptions& options)
    : mesh_(mesh),
      options_(options),
      g_(weld(mesh)),
      wedges_(mesh, g_.position_of, static_cast<std::uint32_t>(g_.points.size())),
      sheets_(g_.face_corners, g_.points),
      connectivity_(sheets_.connectivity()),
      parts_(find_components(g_)),
      quadrics_(g_.points.size()),
      queued_cost_(connectivity_.n_edges(), infinity),
      level_(connectivity_.n_halfedges(), 0),
      dropped_(parts_.live.size(), false),
      vanished_(g_.face_corners.size(), false),
      live_(g_.face_corners.size()) {
    face_vertices_.reserve(live_);
    for (const std::uint32_t t : g_.triangle_of) face_vertices_.push_back(mesh.triangles[t]);
    history_.vertex_parent.resize(mesh.positions.size());
    std::iota(history_.vertex_parent.begin(), history_.vertex_parent.end(), 0u);
    history_.vertex_step.assign(mesh.positions.size(), never);
    history_.triangle_order.reserve(mesh.triangles.size());
    history_.triangle_step.reserve(mesh.triangles.size());
    add_planes();
}

std::uint32_t Recorder::vertex_at(FaceHandle face, std::uint32_t position) const {
    const mesh::Triangle& t = face_vertices_[index_of(face)];
    return g_.position_of[t[0]] == position ? t[0] : g_.position_of[t[1]] == position ? t[1] : t[2];
}

bool Recorder::is_seam(EdgeHandle edge) const {
    const HalfedgeHandle h = connectivity_.halfedge_handle(edge, 0);
    const FaceHandle left = connectivity_.face_handle(h);
    const FaceHandle right = connectivity_.face_handle(connectivity_.opposite_halfedge_handle(h));
    for (const std::uint32_t end : {sheets_.from(h), sheets_.to(h)})
        if (wedges_.group(vertex_at(left, end)) != wedges_.group(vertex_at(right, end))) return true;
    return false;
}

// A plane through the edge, upright on the triangle inside.
void Recorder::add_border_plane(HalfedgeHandle inner, double weight) {
    const std::uint32_t from = sheets_.from(inner), to = sheets_.to(inner);
    const std::uint32_t apex = sheets_.to(connectivity_.next_halfedge_handle(inner));
    const Vec3d side = g_.points[to] - g_.points[from];
    const Vec3d upright = cross(side, cross(side, g_.points[apex] - g_.points[from]));
    const double size = length(upright);
    if (!(size > 0)) return;
    for (const std::uint32_t end : {from, to})
        quadrics_[end].add_plane(upright / size, g_.points[from], weight * dot(side, side));
}

void Recorder::add_planes() {
    for (const mesh::Triangle& t : g_.face_corners) {
        const Vec3d normal = cross(g_.points[t[1]] - g_.points[t[0]], g_.points[t[2]] - g_.points[t[0]]);
        const double size = length(normal);
        if (!(size > 0)) continue;
        for (const std::uint32_t corner : t) {
            quadrics_[corner].add_plane(normal / size, g_.points[t[0]], 0.5 * size);
            quadrics_[corner].area += 0.5 * size;
        }
    }
    for (std::size_t e = 0; e < connectivity_.n_edges(); ++e) {
        const EdgeHandle edge(static_cast<int>(e));
        const HalfedgeHandle h = connectivity_.halfedge_handle(edge, 0);
        const HalfedgeHandle opposite = connectivity_.opposite_halfedge_handle(h);
        const bool border = connectivity_.is_boundary(opposite);  // half-edge 0 always has its triangle
        if (!border && !is_seam(edge)) continue;
        add_border_plane(h, border ? border_weight : seam_weight);
        if (!border) add_border_plane(opposite, seam_weight);
    }
}

// Result

Result<History> Recorder::run() {
    for (const std::uint32_t t : g_.degenerate) {
        history_.triangle_order.push_back(t);
        history_.triangle_step.push_back(step_++);
    }
    if (!merge_all()) return fail(ErrorCode::unavailable, "simplification was cancelled");
    return finish();
}

bool Recorder::keep_going() {
    if (iterations_++ % iterations_per_report == 0 && options_.progress) {
        const double total = static_cast<double>(std::max<std::size_t>(1, vanished_.size()));
        cancelled_ = cancelled_ || !options_.progress(1.0 - static_cast<double>(live_) / total);
    }
    return !cancelled_;
}

bool Recorder::merge_all() {
    for (std::size_t e = 0; e < connectivity_.n_edges(); ++e) {
        const EdgeHandle edge(static_cast<int>(e));
        queued_cost_[e] = cheaper_direction(edge).cost;
        heap_.push_back({queued_cost_[e], index_of(edge)});
    }
    std::make_heap(heap_.begin(), heap_.end());
    retry_below_ = static_cast<std::size_t>(retry_share * static_cast<double>(live_));

    while (keep_going()) {
        if (live_ < retry_below_) retry_refused();
        const Candidate next = pop();
        if (!next.halfedge.is_valid()) {
            if (merges_since_retry_ == 0 || refused_edges_.empty()) return true;
            retry_refused();
            continue;
        }
        drop_parts_cheaper_than(next.cost);
        if (part_is_gone(sheets_.from(next.halfedge))) continue;
        std::uint8_t& level = level_[index_of(next.halfedge)];
        if (merge(next.halfedge, rule_levels[level])) {
            ++merges_since_retry_;
            continue;
        }
        const EdgeHandle edge = connectivity_.edge_handle(next.halfedge);
        if (level++ == 0) refused_edges_.push_back(edge);
        push(edge);
    }
    return false;
}

double Recorder::cost(HalfedgeHandle h) const {
    const std::uint8_t level = level_[index_of(h)];
    if (level == refused) return infinity;
    const std::uint32_t source = sheets_.from(h), target = sheets_.to(h);
    const Vec3d &from = g_.points[source], &to = g_.points[target];
    return quadrics_[source].error(to) + quadrics_[target].error(to) +
           rule_levels[level].price * quadrics_[source].area * dot(to - from, to - from);
}

Recorder::Candidate Recorder::cheaper_direction(EdgeHandle edge) const {
    const HalfedgeHandle a = connectivity_.halfedge_handle(edge, 0), b = connectivity_.halfedge_handle(edge, 1);
    const double cost_a = cost(a), cost_b = cost(b);
    return cost_b < cost_a ? Candidate{b, cost_b} : Candidate{a, cost_a};
}

void Recorder::push(EdgeHandle edge) {
    const double now = cheaper_direction(edge).cost;
    if (!(now < queued_cost_[index_of(edge)])) return;
    queued_cost_[index_of(edge)] = now;
    heap_.push_back({now, index_of(edge)});
    std::push_heap(heap_.begin(), heap_.end());
}

// The cheapest merge that may still be made. Costs mostly grow, so an entry's is a lower bound, checked here.
Recorder::Candidate Recorder::pop() {
    while (!heap_.empty()) {
        const Entry entry = heap_.front();
        std::pop_heap(heap_.begin(), heap_.end());
        heap_.pop_back();
        if (entry.cost != queued_cost_[entry.edge]) continue;
        queued_cost_[entry.edge] = infinity;
        const EdgeHandle edge(static_cast<int>(entry.edge));
        if (connectivity_.status(edge).deleted()) continue;
        const Candidate candidate = cheaper_direction(edge);
        if (part_is_gone(sheets_.from(candidate.halfedge))) continue;
        if (candidate.cost <= entry.cost) return candidate;
        push(edge);
    }
    return {HalfedgeHandle(), infinity};
}

void Recorder::allow(EdgeHandle edge) {
    for (const unsigned side : {0u, 1u}) level_[index_of(connectivity_.halfedge_handle(edge, side))] = 0;
    push(edge);
}

void Recorder::retry_refused() {
    std::vector<EdgeHandle> again;
    again.swap(refused_edges_);
    for (const EdgeHandle edge : again)
        if (!connectivity_.status(edge).deleted()) allow(edge);
    retry_below_ = static_cast<std::size_t>(retry_share * static_cast<double>(live_));
    merges_since_retry_ = 0;
}

// One merge

bool Recorder::merge(HalfedgeHandle h, const Rules& rules) {
    const std::uint32_t source = sheets_.from(h), target = sheets_.to(h);
    if (rules.sheets && !keeps_sheets(source, target)) return false;
    if (!gather(source, target)) return false;
    if (rules.shape &&
        !std::all_of(staying_.begin(), staying_.end(), [&](const Corner& c) { return keeps_shape(c, target); }))
        return false;
    if (!find_partners(source, target, rules)) return false;
    if (rules.seams &&
        !std::all_of(staying_.begin(), staying_.end(), [&](const Corner& c) { return keeps_texture(c); }))
        return false;
    commit(source, target);
    return true;
}

bool Recorder::keeps_sheets(std::uint32_t source, std::uint32_t target) {
    bool keeps = true;
    sheets_.for_each_sheet(
        source, [&](VertexHandle sheet) { keeps = keeps && sheets_.manifold_edge(sheet, target, true).is_valid(); });
    return keeps;
}

// Sorts the faces around the source into those that vanish and those that stay. A part is never merged away whole.
bool Recorder::gather(std::uint32_t source, std::uint32_t target) {
    staying_.clear();
    vanishing_.clear();
    told_.clear();
    sheets_.for_each_sheet(source, [&](VertexHandle sheet) {
        sheets_.for_each_outgoing(sheet, [&](HalfedgeHandle h) {
            const FaceHandle handle = connectivity_.face_handle(h);
            if (!handle.is_valid()) return;
            const std::uint32_t face = index_of(handle);
            const mesh::Triangle& t = face_vertices_[face];
            std::uint32_t at_source = 0, at_target = none;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t p = g_.position_of[t[k]];
                if (p == source) at_source = k;
                if (p == target) at_target = k;
            }
            if (at_target == none) {
                staying_.push_back({face, at_source});
            } else {
                vanishing_.push_back(face);
                told_.push_back({t[at_source], t[at_target]});
            }
        });
    });
    return !vanishing_.empty() && vanishing_.size() < parts_.live[parts_.of_position[source]];
}

bool Recorder::keeps_shape(const Corner& c, std::uint32_t target) const {
    const mesh::Triangle& t = face_vertices_[c.face];
    const Vec3d &old_apex = point(t[c.corner]), &new_apex = g_.points[target];
    const Vec3d &a = point(t[(c.corner + 1) % 3]), &b = point(t[(c.corner + 2) % 3]);
    const Vec3d old_cross = cross(a - old_apex, b - old_apex), new_cross = cross(a - new_apex, b - new_apex);
    const double base = dot(b - a, b - a);
    const double old_longest = std::max({base, dot(a - old_apex, a - old_apex), dot(b - old_apex, b - old_apex)});
    const double new_longest = std::max({base, dot(a - new_apex, a - new_apex), dot(b - new_apex, b - new_apex)});
    const double old_size = length(old_cross), new_size = length(new_cross);

    if (old_size <= degenerate_height * old_longest) return true;
    if (new_size <= degenerate_height * new_longest) return false;
    if (dot(old_cross / old_size, new_cross / new_size) < min_turn_cosine) return false;
    return new_size > sliver_height * new_longest || new_size * old_longest >= 0.5 * old_size * new_longest;
}

// Whether the triangle stays the same way round in the texture.
bool Recorder::keeps_texture(const Corner& c) const {
    if (mesh_.texture_coordinates.empty()) return true;
    const mesh::Triangle& t = face_vertices_[c.face];
    const std::uint32_t old_vertex = t[c.corner];
    std::uint32_t new_vertex = old_vertex;
    for (const Wedges::Pair& pair : partners_)
        if (pair.from == old_vertex) new_vertex = pair.to;
    const auto uv = [&](std::uint32_t v) { return glm::dvec2(mesh_.texture_coordinates[v]); };
    const auto a = uv(t[(c.corner + 1) % 3]), b = uv(t[(c.corner + 2) % 3]);
    const auto turn = [&](const auto& apex) {
        return (a.x - apex.x) * (b.y - apex.y) - (a.y - apex.y) * (b.x - apex.x);
    };
    const double before = turn(uv(old_vertex)), after = turn(uv(new_vertex));
    return before == 0 || (before > 0) == (after > 0);
}

bool Recorder::find_partners(std::uint32_t source, std::uint32_t target, const Rules& rules) {
    partners_.clear();
    const Wedges::Range here = wedges_.at(source), there = wedges_.at(target);
    if (here.size() == 1 && there.size() == 1) {
        partners_.push_back({*here.begin(), *there.begin()});
        return true;
    }
    used_.clear();
    for (const Corner& c : staying_) used_.push_back(face_vertices_[c.face][c.corner]);
    for (const Wedges::Pair& pair : told_) used_.push_back(pair.from);
    std::sort(used_.begin(), used_.end());
    used_.erase(std::unique(used_.begin(), used_.end()), used_.end());
    return wedges_.find_partners(used_, target, told_, rules.seams, partners_);
}

void Recorder::commit(std::uint32_t source, std::uint32_t target) {
    if (vanishing_.size() > 2) {
        drop_one_by_one(vanishing_, vanishing_.size() - 2);
        std::erase_if(vanishing_, [&](std::uint32_t face) { return vanished_[face]; });
    }
    for (const std::uint32_t face : vanishing_) vanish(face);
    for (const std::uint32_t vertex : wedges_.at(source)) {
        history_.vertex_parent[vertex] = *wedges_.at(target).begin();
        history_.vertex_step[vertex] = step_;
    }
    for (const Wedges::Pair& pair : partners_) history_.vertex_parent[pair.from] = pair.to;
    for (const Corner& c : staying_) {
        std::uint32_t& vertex = face_vertices_[c.face][c.corner];
        vertex = history_.vertex_parent[vertex];
    }
    ++step_;

    quadrics_[target] += quadrics_[source];
    changed_.clear();
    sheets_.merge(source, target, changed_);
    for (const EdgeHandle edge : changed_) allow(edge);
}

// Dropping

double Recorder::area(std::uint32_t face) const {
    const mesh::Triangle& t = face_vertices_[face];
    return 0.5 * length(cross(point(t[1]) - point(t[0]), point(t[2]) - point(t[0])));
}

void Recorder::vanish(std::uint32_t face) {
    vanished_[face] = true;
    --live_;
    --parts_.live[parts_.of_position[g_.position_of[face_vertices_[face][0]]]];
    history_.triangle_order.push_back(g_.triangle_of[face]);
    history_.triangle_step.push_back(step_);
}

// Drops `count` of the faces, each in a step of its own, smallest first.
void Recorder::drop_one_by_one(std::vector<std::uint32_t> faces, std::size_t count) {
    std::vector<std::pair<double, std::uint32_t>> by_area;
    for (const std::uint32_t face : faces) by_area.emplace_back(area(face), face);
    std::sort(by_area.begin(), by_area.end());
    for (std::size_t i = 0; i < count; ++i) {
        vanish(by_area[i].second);
        ++step_;
    }
}

void Recorder::drop_part(std::uint32_t part, std::uint32_t keep) {
    std::vector<std::uint32_t> faces;
    for (std::uint32_t i = parts_.first_face[part]; i < parts_.first_face[part + 1]; ++i)
        if (!vanished_[parts_.faces[i]]) faces.push_back(parts_.faces[i]);
    dropped_[part] = true;
    const std::size_t count = faces.size() - keep;
    drop_one_by_one(std::move(faces), count);
}

// The most visible part always stays.
void Recorder::drop_parts_cheaper_than(double limit) {
    while (next_to_drop_ + 1 < parts_.by_visibility.size()) {
        const std::uint32_t part = parts_.by_visibility[next_to_drop_];
        if (!(parts_.visibility[part] < limit)) return;
        drop_part(part, 0);
        ++next_to_drop_;
    }
}

History Recorder::finish() {
    drop_parts_cheaper_than(infinity);
    if (next_to_drop_ < parts_.by_visibility.size()) drop_part(parts_.by_visibility[next_to_drop_], 1);
    for (std::uint32_t face = 0; face < vanished_.size(); ++face)
        if (!vanished_[face]) {
            history_.triangle_order.push_back(g_.triangle_of[face]);
            history_.triangle_step.push_back(never);
        }
    std::reverse(history_.triangle_order.begin(), history_.triangle_order.end());
    std::reverse(history_.triangle_step.begin(), history_.triangle_step.end());
    return std::move(history_);
}

}  // namespace

Result<History> record_history(const mesh::Mesh& mesh, const RecordOptions& options) {
    try {
        return Recorder(mesh, options).run();
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "not enough memory to simplify the mesh");
    }
}

}  // namespace lodestream::simplify
