#include "common/simplify/sheet_mesh.h"

#include <algorithm>
#include <numeric>

namespace lodestream::simplify {

namespace {

using Triangles = std::vector<mesh::Triangle>;

// At an edge with more triangles than this they are not paired at all: each is its own sheet there.
constexpr std::size_t max_paired_at_edge = 32;

// A *dart* is a triangle's directed side: dart 3 * t + k runs from corner k to corner k + 1.
constexpr std::uint32_t next_dart(std::uint32_t dart) {
    return dart % 3 == 2 ? dart - 2 : dart + 1;
}
constexpr std::uint32_t previous_dart(std::uint32_t dart) {
    return dart % 3 == 0 ? dart + 2 : dart - 1;
}
std::uint32_t start_of(const Triangles& corners, std::uint32_t dart) {
    return corners[dart / 3][dart % 3];
}
std::uint32_t end_of(const Triangles& corners, std::uint32_t dart) {
    return start_of(corners, next_dart(dart));
}

// Calls visit(begin, end) for the darts of every undirected edge.
template <class Visit>
void for_each_edge(const Triangles& corners, std::size_t positions, Visit visit) {
    const auto darts = static_cast<std::uint32_t>(3 * corners.size());
    const auto low = [&](std::uint32_t d) { return std::min(start_of(corners, d), end_of(corners, d)); };
    const auto high = [&](std::uint32_t d) { return std::max(start_of(corners, d), end_of(corners, d)); };

    std::vector<std::uint32_t> first(positions + 2, 0), sorted(darts);
    for (std::uint32_t d = 0; d < darts; ++d) ++first[low(d) + 2];
    std::partial_sum(first.begin(), first.end(), first.begin());
    for (std::uint32_t d = 0; d < darts; ++d) sorted[first[low(d) + 1]++] = d;

    for (std::size_t p = 0; p < positions; ++p) {
        std::uint32_t *begin = sorted.data() + first[p], *end = sorted.data() + first[p + 1];
        std::sort(begin, end,
                  [&](std::uint32_t a, std::uint32_t b) { return high(a) != high(b) ? high(a) < high(b) : a < b; });
        while (begin != end) {
            std::uint32_t* edge_end = begin;
            while (edge_end != end && high(*edge_end) == high(*begin)) ++edge_end;
            visit(begin, edge_end);
            begin = edge_end;
        }
    }
}

// Turns triangles around so that neighbours across an edge of two agree on which side is outside, where that can be.
void orient(Triangles& corners, std::size_t positions) {
    std::vector<std::uint32_t> neighbour(3 * corners.size(), none);
    bool conflict = false;
    for_each_edge(corners, positions, [&](const std::uint32_t* begin, const std::uint32_t* end) {
        if (end - begin != 2) return;
        neighbour[begin[0]] = begin[1];
        neighbour[begin[1]] = begin[0];
        conflict |= start_of(corners, begin[0]) == start_of(corners, begin[1]);
    });
    if (!conflict) return;

    std::vector<bool> seen(corners.size(), false), turned(corners.size(), false);
    std::vector<std::uint32_t> queue;
    for (std::uint32_t seed = 0; seed < corners.size(); ++seed) {
        if (seen[seed]) continue;
        seen[seed] = true;
        queue.assign(1, seed);
        while (!queue.empty()) {
            const std::uint32_t t = queue.back();
            queue.pop_back();
            for (std::uint32_t d = 3 * t; d < 3 * t + 3; ++d) {
                const std::uint32_t mate = neighbour[d];
                if (mate == none || seen[mate / 3]) continue;
                seen[mate / 3] = true;
                turned[mate / 3] = turned[t] != (start_of(corners, d) == start_of(corners, mate));
                queue.push_back(mate / 3);
            }
        }
    }
    for (std::size_t t = 0; t < corners.size(); ++t)
        if (turned[t]) std::swap(corners[t][1], corners[t][2]);
}

Vec3d unit_normal(const Triangles& corners, const std::vector<Vec3d>& points, std::uint32_t dart) {
    const mesh::Triangle& t = corners[dart / 3];
    const Vec3d n = cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
    const double size = length(n);
    return size > 0 ? n / size : Vec3d{0.0};
}

// Pairs the darts of one edge, opposite directions only, flattest pair first.
void pair_darts(const Triangles& corners, const std::vector<Vec3d>& points, const std::uint32_t* begin,
                const std::uint32_t* end, std::vector<std::uint32_t>& mate) {
    struct Pair {
        double flatness;
        std::uint32_t a, b;
    };
    std::vector<Pair> pairs;
    for (const std::uint32_t* a = begin; a != end; ++a)
        for (const std::uint32_t* b = a + 1; b != end; ++b)
            if (start_of(corners, *a) != start_of(corners, *b))
                pairs.push_back({dot(unit_normal(corners, points, *a), unit_normal(corners, points, *b)), *a, *b});
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) { return x.flatness > y.flatness; });
    for (const Pair& pair : pairs)
        if (mate[pair.a] == none && mate[pair.b] == none) {
            mate[pair.a] = pair.b;
            mate[pair.b] = pair.a;
        }
}

// Of every dart the one that runs the other way in the neighbouring triangle; none at a border of the sheet.
std::vector<std::uint32_t> pair_all(const Triangles& corners, const std::vector<Vec3d>& points) {
    std::vector<std::uint32_t> mate(3 * corners.size(), none);
    for_each_edge(corners, points.size(), [&](const std::uint32_t* begin, const std::uint32_t* end) {
        const auto count = static_cast<std::size_t>(end - begin);
        if (count == 2 && start_of(corners, begin[0]) != start_of(corners, begin[1])) {
            mate[begin[0]] = begin[1];
            mate[begin[1]] = begin[0];
        } else if (count > 2 && count <= max_paired_at_edge) {
            pair_darts(corners, points, begin, end, mate);
        }
    });
    return mate;
}

// The first dart of the fan around a dart's start: the one at its border, or `dart` itself in a closed fan.
std::uint32_t first_of_fan(const std::vector<std::uint32_t>& mate, std::uint32_t dart) {
    std::uint32_t d = dart;
    while (mate[d] != none) {
        d = next_dart(mate[d]);
        if (d == dart) break;
    }
    return d;
}

template <class Visit>
void walk_fan(const std::vector<std::uint32_t>& mate, std::uint32_t first, Visit visit) {
    std::uint32_t d = first;
    do {
        visit(d);
        d = mate[previous_dart(d)];
    } while (d != none && d != first);
}

// One sheet for each fan; the sheet of dart d's start.
std::vector<std::uint32_t> number_fans(const std::vector<std::uint32_t>& mate, std::uint32_t& sheets) {
    std::vector<std::uint32_t> sheet(mate.size(), none);
    sheets = 0;
    for (std::uint32_t d = 0; d < mate.size(); ++d) {
        if (sheet[d] != none) continue;
        walk_fan(mate, first_of_fan(mate, d), [&](std::uint32_t in_fan) { sheet[in_fan] = sheets; });
        ++sheets;
    }
    return sheet;
}

// A half-edge structure has at most one edge between two vertices. Triangles at a second one become sheets of their
// own.
bool isolate_double_edges(std::vector<std::uint32_t>& mate, const std::vector<std::uint32_t>& sheet,
                          std::uint32_t sheets) {
    std::vector<std::uint32_t> seen(sheets, none), seen_dart(sheets, none), isolated;
    std::vector<bool> done(sheets, false);
    for (std::uint32_t d = 0; d < mate.size(); ++d) {
        const std::uint32_t at = sheet[d];
        if (done[at]) continue;
        done[at] = true;
        const auto meet = [&](std::uint32_t neighbour, std::uint32_t dart) {
            if (seen[neighbour] == at) isolated.insert(isolated.end(), {dart / 3, seen_dart[neighbour] / 3});
            seen[neighbour] = at;
            seen_dart[neighbour] = dart;
        };
        walk_fan(mate, first_of_fan(mate, d), [&](std::uint32_t in_fan) {
            meet(sheet[next_dart(in_fan)], in_fan);
            if (mate[previous_dart(in_fan)] == none) meet(sheet[previous_dart(in_fan)], in_fan);
        });
    }
    for (const std::uint32_t triangle : isolated)
        for (std::uint32_t d = 3 * triangle; d < 3 * triangle + 3; ++d)
            if (mate[d] != none) {
                mate[mate[d]] = none;
                mate[d] = none;
            }
    return !isolated.empty();
}

}  // namespace

SheetMesh::SheetMesh(const Triangles& corners, const std::vector<Vec3d>& points) {
    Triangles oriented = corners;
    orient(oriented, points.size());
    std::vector<std::uint32_t> mate = pair_all(oriented, points);
    std::uint32_t sheets = 0;
    std::vector<std::uint32_t> sheet_of_dart = number_fans(mate, sheets);
    while (isolate_double_edges(mate, sheet_of_dart, sheets)) sheet_of_dart = number_fans(mate, sheets);

    first_sheet_.assign(points.size(), none);
    next_sheet_.assign(sheets, none);
    sheet_position_.assign(sheets, none);
    mark_.assign(sheets, 0);
    for (std::uint32_t d = 0; d < mate.size(); ++d) {
        const std::uint32_t sheet = sheet_of_dart[d], at = start_of(oriented, d);
        if (sheet_position_[sheet] != none) continue;
        sheet_position_[sheet] = at;
        next_sheet_[sheet] = first_sheet_[at];
        first_sheet_[at] = sheet;
    }
    build(oriented, mate, sheet_of_dart);
}

void SheetMesh::build(const Triangles& corners, const std::vector<std::uint32_t>& mate,
                      const std::vector<std::uint32_t>& sheet_of_dart) {
    std::vector<int> halfedge(mate.size());
    int edges = 0;
    for (std::uint32_t d = 0; d < mate.size(); ++d)
        halfedge[d] = mate[d] != none && mate[d] < d ? halfedge[mate[d]] + 1 : 2 * edges++;
    connectivity_.resize(sheet_position_.size(), static_cast<std::size_t>(edges), corners.size());
    connectivity_.request_vertex_status();
    connectivity_.request_edge_status();
    connectivity_.request_face_status();

    const auto inner = [&](std::uint32_t d) { return HalfedgeHandle(halfedge[d]); };
    const auto outer = [&](std::uint32_t d) { return HalfedgeHandle(halfedge[d] + 1); };
    const auto sheet = [&](std::uint32_t d) { return VertexHandle(static_cast<int>(sheet_of_dart[d])); };
    for (std::uint32_t d = 0; d < mate.size(); ++d) {
        const FaceHandle face(static_cast<int>(d / 3));
        connectivity_.set_vertex_handle(inner(d), sheet(next_dart(d)));
        connectivity_.set_face_handle(inner(d), face);
        connectivity_.set_next_halfedge_handle(inner(d), inner(next_dart(d)));
        connectivity_.set_halfedge_handle(sheet(d), inner(d));
        if (d % 3 == 0) connectivity_.set_halfedge_handle(face, inner(d));
    }
    for (std::uint32_t d = 0; d < mate.size(); ++d) {
        if (mate[d] != none) continue;
        std::uint32_t last = d;
        walk_fan(mate, d, [&](std::uint32_t in_fan) { last = in_fan; });
        const HalfedgeHandle following = outer(previous_dart(last));
        connectivity_.set_vertex_handle(outer(d), sheet(d));
        connectivity_.set_boundary(outer(d));
        connectivity_.set_next_halfedge_handle(outer(d), following);
        connectivity_.set_halfedge_handle(sheet(d), following);
    }
}

// Whether the triangle left of `h` hangs on the mesh by that edge alone.
bool SheetMesh::dangles(HalfedgeHandle h) const {
    const HalfedgeHandle next = connectivity_.next_halfedge_handle(h);
    const HalfedgeHandle previous = connectivity_.prev_halfedge_handle(h);
    return connectivity_.is_boundary(connectivity_.opposite_halfedge_handle(next)) &&
           connectivity_.is_boundary(connectivity_.opposite_halfedge_handle(previous));
}

bool SheetMesh::shares_other_neighbours(VertexHandle a, VertexHandle b, VertexHandle left, VertexHandle right) {
    const std::uint32_t ring = ++ring_;
    for_each_outgoing(a, [&](HalfedgeHandle h) { mark_[index_of(connectivity_.to_vertex_handle(h))] = ring; });
    if (left.is_valid()) mark_[index_of(left)] = 0;
    if (right.is_valid()) mark_[index_of(right)] = 0;
    const HalfedgeHandle start = connectivity_.halfedge_handle(b);
    HalfedgeHandle h = start;
    do {
        if (mark_[index_of(connectivity_.to_vertex_handle(h))] == ring) return true;
        h = connectivity_.opposite_halfedge_handle(connectivity_.prev_halfedge_handle(h));
    } while (h != start);
    return false;
}

HalfedgeHandle SheetMesh::manifold_edge(VertexHandle sheet, std::uint32_t target, bool along_border) {
    HalfedgeHandle edge;
    int edges = 0;
    for_each_outgoing(sheet, [&](HalfedgeHandle h) {
        if (to(h) != target) return;
        edge = h;
        ++edges;
    });
    if (edges != 1) return HalfedgeHandle();

    const HalfedgeHandle back = connectivity_.opposite_halfedge_handle(edge);
    const bool left_open = connectivity_.is_boundary(edge), right_open = connectivity_.is_boundary(back);
    const VertexHandle end = connectivity_.to_vertex_handle(edge);
    if (!left_open && !right_open && connectivity_.is_boundary(sheet) &&
        (along_border || connectivity_.is_boundary(end)))
        return HalfedgeHandle();
    if ((!left_open && dangles(edge)) || (!right_open && dangles(back))) return HalfedgeHandle();
    const VertexHandle left = left_open ? VertexHandle() : connectivity_.opposite_vh(edge);
    const VertexHandle right = right_open ? VertexHandle() : connectivity_.opposite_vh(back);
    if (left == right || shares_other_neighbours(sheet, end, left, right)) return HalfedgeHandle();
    return edge;
}

void SheetMesh::cut_out(VertexHandle sheet, std::uint32_t target) {
    cut_faces_.clear();
    for_each_outgoing(sheet, [&](HalfedgeHandle h) {
        const FaceHandle face = connectivity_.face_handle(h);
        if (!face.is_valid()) return;
        const HalfedgeHandle across = connectivity_.next_halfedge_handle(h);
        if (to(h) == target || to(across) == target) cut_faces_.push_back(face);
    });
    for (const FaceHandle face : cut_faces_) connectivity_.delete_face(face, true);
}

void SheetMesh::merge(std::uint32_t source, std::uint32_t target, std::vector<EdgeHandle>& changed) {
    const std::size_t first_changed = changed.size();
    std::uint32_t next = none;
    for (std::uint32_t s = first_sheet_[source]; s != none; s = next) {
        next = next_sheet_[s];
        const VertexHandle sheet(static_cast<int>(s));
        if (connectivity_.status(sheet).deleted()) continue;
        const HalfedgeHandle edge = manifold_edge(sheet, target, false);
        if (!edge.is_valid()) cut_out(sheet, target);
        if (connectivity_.status(sheet).deleted()) continue;
        for_each_outgoing(sheet, [&](HalfedgeHandle h) { changed.push_back(connectivity_.edge_handle(h)); });
        if (edge.is_valid()) {
            connectivity_.collapse(edge);
        } else {
            sheet_position_[s] = target;
            next_sheet_[s] = first_sheet_[target];
            first_sheet_[target] = s;
        }
    }
    first_sheet_[source] = none;
    const auto gone = [&](EdgeHandle e) { return connectivity_.status(e).deleted(); };
    changed.erase(std::remove_if(changed.begin() + static_cast<std::ptrdiff_t>(first_changed), changed.end(), gone),
                  changed.end());
}

}  // namespace lodestream::simplify
