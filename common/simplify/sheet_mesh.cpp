#include "common/simplify/sheet_mesh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>

namespace lodestream::simplify {

namespace {

using Triangles = std::vector<mesh::Triangle>;

// At an edge with more triangles than this they are not paired at all: each is its own sheet there.
constexpr std::size_t max_paired_at_edge = 32;

// A vertex's neighbours up to this number are listed to compare them; beyond it they are looked up.
constexpr std::size_t max_listed_ring = 64;

constexpr std::size_t positions_per_task = 1u << 14, faces_per_task = 1u << 15;

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

// Calls visit(begin, end) for the darts of every undirected edge, of several edges at a time.
template <class Visit>
void for_each_edge(const Triangles& corners, std::size_t positions, const Executor& executor, const Visit& visit) {
    const auto darts = static_cast<std::uint32_t>(3 * corners.size());
    const auto low = [&](std::uint32_t d) { return std::min(start_of(corners, d), end_of(corners, d)); };
    const auto high = [&](std::uint32_t d) { return std::max(start_of(corners, d), end_of(corners, d)); };

    std::vector<std::uint32_t> first(positions + 2, 0), sorted(darts);
    for (std::uint32_t d = 0; d < darts; ++d) ++first[low(d) + 2];
    std::partial_sum(first.begin(), first.end(), first.begin());
    for (std::uint32_t d = 0; d < darts; ++d) sorted[first[low(d) + 1]++] = d;

    const auto visit_edges_from = [&](std::size_t position) {
        std::uint32_t *begin = sorted.data() + first[position], *end = sorted.data() + first[position + 1];
        std::sort(begin, end,
                  [&](std::uint32_t a, std::uint32_t b) { return high(a) != high(b) ? high(a) < high(b) : a < b; });
        while (begin != end) {
            std::uint32_t* edge_end = begin;
            while (edge_end != end && high(*edge_end) == high(*begin)) ++edge_end;
            visit(begin, edge_end);
            begin = edge_end;
        }
    };
    for_each_run(executor, positions, positions_per_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) visit_edges_from(p);
    });
}

// Turns triangles around so that neighbours across an edge of two agree on which side is outside, where that can be.
void orient(Triangles& corners, std::size_t positions, const Executor& executor) {
    std::vector<std::uint32_t> neighbour(3 * corners.size(), none);
    for_each_edge(corners, positions, executor, [&](const std::uint32_t* begin, const std::uint32_t* end) {
        if (end - begin != 2) return;
        neighbour[begin[0]] = begin[1];
        neighbour[begin[1]] = begin[0];
    });

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

Vec3d unit_normal(const Triangles& corners, const std::vector<Vec3f>& points, std::uint32_t dart) {
    const mesh::Triangle& t = corners[dart / 3];
    const Vec3d origin(points[t[0]]);
    const Vec3d n = cross(Vec3d(points[t[1]]) - origin, Vec3d(points[t[2]]) - origin);
    const double size = length(n);
    return size > 0 ? n / size : Vec3d{0.0};
}

// Pairs the darts of one edge, opposite directions only, flattest pair first.
void pair_darts(const Triangles& corners, const std::vector<Vec3f>& points, const std::uint32_t* begin,
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

struct Pairing {
    std::vector<std::uint32_t> mate;  // of every dart the one that runs the other way beside it; none: a border
    bool one_way = false;             // two triangles alone at an edge run along it the same way
    bool crowded = false;             // more than two are at an edge
};

Pairing pair_all(const Triangles& corners, const std::vector<Vec3f>& points, const Executor& executor) {
    std::vector<std::uint32_t> mate(3 * corners.size(), none);
    std::atomic<bool> one_way{false}, crowded{false};
    for_each_edge(corners, points.size(), executor, [&](const std::uint32_t* begin, const std::uint32_t* end) {
        const auto count = static_cast<std::size_t>(end - begin);
        if (count == 2 && start_of(corners, begin[0]) != start_of(corners, begin[1])) {
            mate[begin[0]] = begin[1];
            mate[begin[1]] = begin[0];
        } else if (count == 2) {
            one_way = true;
        } else if (count > 2) {
            crowded = true;
            if (count <= max_paired_at_edge) pair_darts(corners, points, begin, end, mate);
        }
    });
    return {std::move(mate), one_way, crowded};
}

std::size_t edge_count(const std::vector<std::uint32_t>& mate) {
    return (mate.size() + static_cast<std::size_t>(std::count(mate.begin(), mate.end(), none))) / 2;
}

// Of every dart; the opposite one is its mate's, or open.
std::vector<int> inner_halfedges(const std::vector<std::uint32_t>& mate) {
    std::vector<int> halfedge(mate.size());
    int edges = 0;
    for (std::uint32_t d = 0; d < mate.size(); ++d)
        halfedge[d] = mate[d] != none && mate[d] < d ? halfedge[mate[d]] + 1 : 2 * edges++;
    return halfedge;
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

// Whether all triangles around each position are one fan.
bool has_one_fan_each(const Triangles& corners, const std::vector<std::uint32_t>& mate, std::size_t positions,
                      const Executor& executor) {
    std::vector<std::uint32_t> dart_at(positions, none);
    for (std::uint32_t d = 0; d < mate.size(); ++d) dart_at[start_of(corners, d)] = d;
    std::vector<std::uint8_t> seen(mate.size(), 0);
    for_each_run(executor, positions, positions_per_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p)
            if (dart_at[p] != none)
                walk_fan(mate, first_of_fan(mate, dart_at[p]), [&](std::uint32_t in_fan) { seen[in_fan] = 1; });
    });
    return std::find(seen.begin(), seen.end(), 0) == seen.end();
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

SheetMesh::SheetMesh(const Triangles& corners, const std::vector<Vec3f>& points, const Executor& executor) {
    Triangles turned;
    const Triangles* oriented = &corners;
    Pairing pairing = pair_all(corners, points, executor);
    if (pairing.one_way) {
        turned = corners;
        orient(turned, points.size(), executor);
        pairing = pair_all(turned, points, executor);
        oriented = &turned;
    }
    std::vector<std::uint32_t>& mate = pairing.mate;
    if (!pairing.one_way && !pairing.crowded && has_one_fan_each(*oriented, mate, points.size(), executor)) {
        build(points.size(), mate, executor, [&](std::uint32_t d) { return start_of(*oriented, d); });
        return;
    }
    std::uint32_t sheets = 0;
    std::vector<std::uint32_t> sheet_of_dart = number_fans(mate, sheets);
    while (isolate_double_edges(mate, sheet_of_dart, sheets)) sheet_of_dart = number_fans(mate, sheets);
    place_sheets(*oriented, sheet_of_dart, points.size(), sheets);
    turned = {};
    build(sheets, mate, executor, [&](std::uint32_t d) { return sheet_of_dart[d]; });
}

void SheetMesh::place_sheets(const Triangles& corners, const std::vector<std::uint32_t>& sheet_of_dart,
                             std::size_t positions, std::size_t sheets) {
    simple_ = false;
    sheet_position_.assign(sheets, none);
    for (std::uint32_t d = 0; d < sheet_of_dart.size(); ++d) sheet_position_[sheet_of_dart[d]] = start_of(corners, d);
    first_sheet_.assign(positions, none);
    next_sheet_.assign(sheets, none);
    for (std::uint32_t s = 0; s < sheets; ++s) {
        next_sheet_[s] = first_sheet_[sheet_position_[s]];
        first_sheet_[sheet_position_[s]] = s;
    }
}

// From now on any position may have any sheets.
void SheetMesh::list_sheets() {
    if (!simple_) return;
    simple_ = false;
    sheet_position_.resize(connectivity_.n_vertices());
    std::iota(sheet_position_.begin(), sheet_position_.end(), 0u);
    first_sheet_ = sheet_position_;
    next_sheet_.assign(sheet_position_.size(), none);
}

// `sheet_at(d)`: that of dart d's start.
template <class SheetAt>
void SheetMesh::build(std::size_t sheets, const std::vector<std::uint32_t>& mate, const Executor& executor,
                      const SheetAt& sheet_at) {
    std::vector<int> halfedge;
    run(executor, 2, [&](std::size_t task) {
        if (task == 0)
            connectivity_.resize(sheets, edge_count(mate), mate.size() / 3);
        else
            halfedge = inner_halfedges(mate);
    });
    const auto inner = [&](std::uint32_t d) { return HalfedgeHandle(halfedge[d]); };
    const auto outer = [&](std::uint32_t d) { return HalfedgeHandle(halfedge[d] + 1); };
    const auto sheet = [&](std::uint32_t d) { return VertexHandle(static_cast<int>(sheet_at(d))); };
    for_each_run(executor, mate.size() / 3, faces_per_task, [&](std::size_t begin, std::size_t end) {
        for (auto d = static_cast<std::uint32_t>(3 * begin); d < 3 * end; ++d) {
            const FaceHandle face(static_cast<int>(d / 3));
            connectivity_.set_vertex_handle(inner(d), sheet(next_dart(d)));
            connectivity_.set_face_handle(inner(d), face);
            connectivity_.set_next_halfedge_handle(inner(d), inner(next_dart(d)));
            if (d % 3 == 0) connectivity_.set_halfedge_handle(face, inner(d));
        }
    });
    for (std::uint32_t d = 0; d < mate.size(); ++d) connectivity_.set_halfedge_handle(sheet(d), inner(d));
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
    return is_open(opposite(next(h))) && is_open(opposite(previous(h)));
}

bool SheetMesh::shares_other_neighbours(VertexHandle a, VertexHandle b, VertexHandle left, VertexHandle right) const {
    std::array<VertexHandle, max_listed_ring> ring;
    std::size_t listed = 0;
    bool too_many = false;
    for_each_outgoing(b, [&](HalfedgeHandle h) {
        const VertexHandle neighbour = to_sheet(h);
        if (neighbour == left || neighbour == right) return;
        if (listed == ring.size()) too_many = true;
        if (!too_many) ring[listed++] = neighbour;
    });
    bool shares = false;
    for_each_outgoing(a, [&](HalfedgeHandle h) {
        const VertexHandle neighbour = to_sheet(h);
        if (shares || neighbour == left || neighbour == right || neighbour == b) return;
        if (too_many)
            for_each_outgoing(neighbour, [&](HalfedgeHandle g) { shares = shares || to_sheet(g) == b; });
        else
            shares = std::find(ring.data(), ring.data() + listed, neighbour) != ring.data() + listed;
    });
    return shares;
}

HalfedgeHandle SheetMesh::manifold_edge(VertexHandle sheet, std::uint32_t target, bool along_border) const {
    HalfedgeHandle edge;
    int edges = 0;
    for_each_outgoing(sheet, [&](HalfedgeHandle h) {
        if (to(h) != target) return;
        edge = h;
        ++edges;
    });
    if (edges != 1) return HalfedgeHandle();

    const HalfedgeHandle back = opposite(edge);
    const bool left_open = is_open(edge), right_open = is_open(back);
    const VertexHandle end = to_sheet(edge);
    if (!left_open && !right_open && is_open(outgoing(sheet)) && (along_border || is_open(outgoing(end))))
        return HalfedgeHandle();
    if ((!left_open && dangles(edge)) || (!right_open && dangles(back))) return HalfedgeHandle();
    const VertexHandle left = left_open ? VertexHandle() : to_sheet(next(edge));
    const VertexHandle right = right_open ? VertexHandle() : to_sheet(next(back));
    if (left == right || shares_other_neighbours(sheet, end, left, right)) return HalfedgeHandle();
    return edge;
}

// Vertices at an open border start their ring there, as OpenMesh wants it.
void SheetMesh::start_at_border(VertexHandle sheet) {
    const HalfedgeHandle start = outgoing(sheet);
    if (!start.is_valid()) return;
    HalfedgeHandle h = start;
    do {
        if (is_open(h)) return connectivity_.set_halfedge_handle(sheet, h);
        h = opposite(previous(h));
    } while (h != start);
}

void SheetMesh::take_out(HalfedgeHandle h) {
    connectivity_.set_vertex_handle(h, VertexHandle());
    connectivity_.set_vertex_handle(opposite(h), VertexHandle());
}

// `keep` and `remove` have become the only two sides of what was a triangle: `keep` takes the place of the half-edge
// opposite to `remove`.
void SheetMesh::fold(HalfedgeHandle keep, HalfedgeHandle remove) {
    const HalfedgeHandle replaced = opposite(remove);
    const VertexHandle keep_end = to_sheet(keep), remove_end = to_sheet(remove);
    connectivity_.set_halfedge_handle(face(keep), HalfedgeHandle());
    const FaceHandle outer = face(replaced);
    link(previous(replaced), keep);
    link(keep, next(replaced));
    if (outer.is_valid()) {
        connectivity_.set_face_handle(keep, outer);
        connectivity_.set_halfedge_handle(outer, keep);
    } else {
        connectivity_.set_boundary(keep);
    }
    // `replaced` started where `keep` does, `remove` where keep's opposite does.
    if (outgoing(remove_end) == replaced) connectivity_.set_halfedge_handle(remove_end, keep);
    if (outgoing(keep_end) == remove) connectivity_.set_halfedge_handle(keep_end, opposite(keep));
    take_out(remove);
}

// pre: manifold_edge() gave h. Both its triangles go, and the vertex that it starts from.
void SheetMesh::collapse(HalfedgeHandle h) {
    const HalfedgeHandle back = opposite(h);
    const HalfedgeHandle left_next = next(h), left_previous = previous(h);
    const HalfedgeHandle right_next = next(back), right_previous = previous(back);
    const bool left_open = is_open(h), right_open = is_open(back);
    const VertexHandle removed = to_sheet(back), kept = to_sheet(h);
    const bool border = is_open(outgoing(removed)) || is_open(outgoing(kept));

    for_each_outgoing(removed, [&](HalfedgeHandle g) { connectivity_.set_vertex_handle(opposite(g), kept); });
    link(left_previous, left_next);
    link(right_previous, right_next);
    if (outgoing(kept) == back) connectivity_.set_halfedge_handle(kept, left_next);
    connectivity_.set_halfedge_handle(removed, HalfedgeHandle());
    take_out(h);
    if (!left_open) fold(left_next, left_previous);
    if (!right_open) fold(right_previous, right_next);
    if (border) start_at_border(kept);
}

void SheetMesh::take_out_face(FaceHandle gone) {
    std::array<HalfedgeHandle, 3> sides;
    sides[0] = connectivity_.halfedge_handle(gone);
    sides[1] = next(sides[0]);
    sides[2] = next(sides[1]);
    std::array<VertexHandle, 3> ends;
    for (std::size_t k = 0; k < 3; ++k) ends[k] = to_sheet(sides[k]);
    connectivity_.set_halfedge_handle(gone, HalfedgeHandle());
    for (const HalfedgeHandle h : sides) connectivity_.set_boundary(h);
    for (const HalfedgeHandle h : sides) {
        const HalfedgeHandle back = opposite(h);
        if (!is_open(back)) continue;
        const VertexHandle end = to_sheet(h), start = to_sheet(back);
        const HalfedgeHandle after = next(h), before = previous(h), back_after = next(back),
                             back_before = previous(back);
        link(before, back_after);
        link(back_before, after);
        if (outgoing(end) == back) connectivity_.set_halfedge_handle(end, after == back ? HalfedgeHandle() : after);
        if (outgoing(start) == h)
            connectivity_.set_halfedge_handle(start, back_after == h ? HalfedgeHandle() : back_after);
        take_out(h);
    }
    for (const VertexHandle end : ends) start_at_border(end);
}

void SheetMesh::cut_out(VertexHandle sheet, std::uint32_t target) {
    std::vector<FaceHandle> gone;
    for_each_outgoing(sheet, [&](HalfedgeHandle h) {
        if (!is_open(h) && (to(h) == target || apex(h) == target)) gone.push_back(face(h));
    });
    for (const FaceHandle f : gone) take_out_face(f);
}

void SheetMesh::move(std::uint32_t sheet, std::uint32_t target) {
    list_sheets();
    sheet_position_[sheet] = target;
    next_sheet_[sheet] = first_sheet_[target];
    first_sheet_[target] = sheet;
}

void SheetMesh::merge(std::uint32_t source, std::uint32_t target) {
    const auto merge_sheet = [&](VertexHandle sheet) {
        const HalfedgeHandle edge = manifold_edge(sheet, target, false);
        if (edge.is_valid()) return collapse(edge);
        cut_out(sheet, target);
        if (outgoing(sheet).is_valid()) move(index_of(sheet), target);
    };
    if (simple_) {
        const VertexHandle sheet(static_cast<int>(source));
        if (outgoing(sheet).is_valid()) merge_sheet(sheet);
        if (!simple_) first_sheet_[source] = none;
        return;
    }
    std::uint32_t following = none;
    for (std::uint32_t s = first_sheet_[source]; s != none; s = following) {
        following = next_sheet_[s];
        const VertexHandle sheet(static_cast<int>(s));
        if (outgoing(sheet).is_valid()) merge_sheet(sheet);
    }
    first_sheet_[source] = none;
}

}  // namespace lodestream::simplify
