#include "common/simplify/sheet_mesh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <utility>

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

// Every dart, listed at the lower of its two ends: those of position p are [first[p], first[p + 1]) of all.
struct DartLists {
    std::vector<std::uint32_t> first;
    std::vector<std::uint32_t> all;
};

DartLists list_darts(const Triangles& corners, std::size_t positions, const Executor& executor) {
    // Two halves of the triangles are counted and listed side by side, those of the first half first.
    const std::array<std::size_t, 3> bounds{0, corners.size() / 2, corners.size()};
    std::array<std::vector<std::uint32_t>, 2> next;
    for (std::vector<std::uint32_t>& of_half : next) of_half.reserve(positions);
    const auto visit_half = [&](std::size_t half, const auto& visit) {
        for (std::size_t t = bounds[half]; t < bounds[half + 1]; ++t)
            for (std::uint32_t k = 0; k < 3; ++k)
                visit(std::min(corners[t][k], corners[t][k == 2 ? 0 : k + 1]), static_cast<std::uint32_t>(3 * t + k));
    };
    run(executor, 2, [&](std::size_t half) {
        next[half].assign(positions, 0);
        visit_half(half, [&](std::uint32_t low_end, std::uint32_t) { ++next[half][low_end]; });
    });
    DartLists lists;
    lists.first.resize(positions + 1);
    std::uint32_t sum = 0;
    for (std::size_t p = 0; p < positions; ++p) {
        lists.first[p] = sum;
        for (std::vector<std::uint32_t>& of_half : next) {
            const std::uint32_t count = of_half[p];
            of_half[p] = sum;
            sum += count;
        }
    }
    lists.first[positions] = sum;
    lists.all.resize(sum);
    run(executor, 2, [&](std::size_t half) {
        visit_half(half, [&](std::uint32_t low_end, std::uint32_t dart) { lists.all[next[half][low_end]++] = dart; });
    });
    return lists;
}

// A dart at the lower of its two ends.
struct Spoke {
    std::uint32_t high_end;
    std::uint32_t dart;
};

// Calls visit(begin, end) for the spokes of every undirected edge, of several edges at a time.
template <class Visit>
void for_each_edge(const Triangles& corners, std::size_t positions, const Executor& executor, const Visit& visit) {
    const DartLists lists = list_darts(corners, positions, executor);
    for_each_run(executor, positions, positions_per_task, [&](std::size_t begin, std::size_t end) {
        std::vector<Spoke> spokes;
        for (std::size_t p = begin; p < end; ++p) {
            spokes.clear();
            for (std::uint32_t i = lists.first[p]; i < lists.first[p + 1]; ++i) {
                const std::uint32_t dart = lists.all[i];
                spokes.push_back({std::max(start_of(corners, dart), end_of(corners, dart)), dart});
            }
            std::sort(spokes.begin(), spokes.end(), [](const Spoke& a, const Spoke& b) {
                return a.high_end != b.high_end ? a.high_end < b.high_end : a.dart < b.dart;
            });
            const Spoke *first = spokes.data(), *last = first + spokes.size();
            while (first != last) {
                const Spoke* edge_end = first;
                while (edge_end != last && edge_end->high_end == first->high_end) ++edge_end;
                visit(first, edge_end);
                first = edge_end;
            }
        }
    });
}

// Turns triangles around so that neighbours across an edge of two agree on which side is outside, where that can be.
void orient(Triangles& corners, std::size_t positions, const Executor& executor) {
    std::vector<std::uint32_t> neighbour(3 * corners.size(), none);
    for_each_edge(corners, positions, executor, [&](const Spoke* begin, const Spoke* end) {
        if (end - begin != 2) return;
        neighbour[begin[0].dart] = begin[1].dart;
        neighbour[begin[1].dart] = begin[0].dart;
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
void pair_darts(const Triangles& corners, const std::vector<Vec3f>& points, const Spoke* begin, const Spoke* end,
                std::vector<std::uint32_t>& mate) {
    struct Pair {
        double flatness;
        std::uint32_t a, b;
    };
    std::vector<Pair> pairs;
    for (const Spoke* a = begin; a != end; ++a)
        for (const Spoke* b = a + 1; b != end; ++b)
            if (start_of(corners, a->dart) != start_of(corners, b->dart)) {
                const Vec3d normal = unit_normal(corners, points, a->dart);
                pairs.push_back({dot(normal, unit_normal(corners, points, b->dart)), a->dart, b->dart});
            }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) { return x.flatness > y.flatness; });
    for (const Pair& pair : pairs)
        if (mate[pair.a] == none && mate[pair.b] == none) {
            mate[pair.a] = pair.b;
            mate[pair.b] = pair.a;
        }
}

struct Pairing {
    std::vector<std::uint32_t> mate;  // of every dart the one that runs the other way beside it; none: a border
    std::vector<std::uint8_t> knots;  // of every position: whether an edge to a higher one is no pair and no border
    bool one_way = false;             // two triangles alone at an edge run along it the same way

    bool has_knots() const { return std::find(knots.begin(), knots.end(), 1) != knots.end(); }
};

Pairing pair_all(const Triangles& corners, const std::vector<Vec3f>& points, const Executor& executor) {
    std::vector<std::uint32_t> mate(3 * corners.size(), none);
    std::vector<std::uint8_t> knots(points.size(), 0);
    std::atomic<bool> one_way{false};
    for_each_edge(corners, points.size(), executor, [&](const Spoke* begin, const Spoke* end) {
        const auto count = static_cast<std::size_t>(end - begin);
        const std::uint32_t from = start_of(corners, begin->dart);
        if (count == 1) return;
        if (count == 2 && from != start_of(corners, begin[1].dart)) {
            mate[begin[0].dart] = begin[1].dart;
            mate[begin[1].dart] = begin[0].dart;
            return;
        }
        knots[from == begin->high_end ? end_of(corners, begin->dart) : from] = 1;
        if (count == 2)
            one_way = true;
        else if (count <= max_paired_at_edge)
            pair_darts(corners, points, begin, end, mate);
    });
    return {std::move(mate), std::move(knots), one_way};
}

std::size_t edge_count(const std::vector<std::uint32_t>& mate) {
    return (mate.size() + static_cast<std::size_t>(std::count(mate.begin(), mate.end(), none))) / 2;
}

// Turns every dart's mate into the dart's half-edge; the opposite one is its mate's, or open.
void number_halfedges(std::vector<std::uint32_t>& mate) {
    std::uint32_t edges = 0;
    for (std::uint32_t d = 0; d < mate.size(); ++d)
        mate[d] = mate[d] != none && mate[d] < d ? mate[mate[d]] + 1 : 2 * edges++;
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

// One sheet for each fan: of every dart's start.
struct Fans {
    std::vector<std::uint32_t> sheet;     // of every dart's start
    std::vector<std::uint32_t> position;  // of every sheet: the first ones are those of the positions' numbers
};

// The first fan of each position has the number of the position, and a position without triangles an idle one.
Fans number_fans(const Triangles& corners, const std::vector<std::uint32_t>& mate, std::size_t positions,
                 const Executor& executor) {
    Fans fans;
    fans.sheet.assign(mate.size(), none);
    fans.position.resize(positions);
    std::iota(fans.position.begin(), fans.position.end(), 0u);
    const auto number = [&](std::uint32_t dart, std::uint32_t sheet) {
        walk_fan(mate, first_of_fan(mate, dart), [&](std::uint32_t in_fan) { fans.sheet[in_fan] = sheet; });
    };
    std::vector<std::uint32_t> dart_at(positions, none);
    for (std::size_t t = corners.size(); t-- > 0;)
        for (std::uint32_t k = 0; k < 3; ++k) dart_at[corners[t][k]] = static_cast<std::uint32_t>(3 * t + k);
    for_each_run(executor, positions, positions_per_task, [&](std::size_t begin, std::size_t end) {
        for (auto p = static_cast<std::uint32_t>(begin); p < end; ++p)
            if (dart_at[p] != none) number(dart_at[p], p);
    });
    for (std::uint32_t d = 0; d < mate.size(); ++d) {
        if (fans.sheet[d] != none) continue;
        number(d, static_cast<std::uint32_t>(fans.position.size()));
        fans.position.push_back(start_of(corners, d));
    }
    return fans;
}

// A half-edge structure has at most one edge between two vertices. Triangles at a second one, which starts at a knot,
// become sheets of their own. Returns whether there are any.
bool isolate_double_edges(Pairing& pairing, const Fans& fans) {
    std::vector<std::uint32_t>& mate = pairing.mate;
    std::vector<std::uint8_t> unseen(fans.position.size());
    for (std::size_t s = 0; s < unseen.size(); ++s) unseen[s] = pairing.knots[fans.position[s]];
    std::vector<std::uint32_t> isolated;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> met;  // around one sheet: another, triangle
    for (std::uint32_t d = 0; d < mate.size(); ++d) {
        if (!unseen[fans.sheet[d]]) continue;
        unseen[fans.sheet[d]] = 0;
        met.clear();
        walk_fan(mate, first_of_fan(mate, d), [&](std::uint32_t in_fan) {
            met.emplace_back(fans.sheet[next_dart(in_fan)], in_fan / 3);
            if (mate[previous_dart(in_fan)] == none) met.emplace_back(fans.sheet[previous_dart(in_fan)], in_fan / 3);
        });
        std::sort(met.begin(), met.end());
        for (std::size_t i = 1; i < met.size(); ++i)
            if (met[i].first == met[i - 1].first) isolated.insert(isolated.end(), {met[i - 1].second, met[i].second});
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
    Fans fans = number_fans(*oriented, pairing.mate, points.size(), executor);
    if (pairing.has_knots())
        while (isolate_double_edges(pairing, fans))
            fans = number_fans(*oriented, pairing.mate, points.size(), executor);
    turned = {};
    positions_ = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t s = positions_; s < fans.position.size(); ++s) list_further(s - positions_, fans.position[s]);
    build(fans.position.size(), std::move(pairing.mate), fans.sheet, executor);
}

// pre: i is in no list, or the next number.
void SheetMesh::list_further(std::uint32_t i, std::uint32_t position) {
    if (first_further_.empty()) first_further_.assign(positions_, none);
    if (i == further_.size()) further_.emplace_back();
    further_[i] = {position, first_further_[position]};
    first_further_[position] = i;
}

// `sheet_of_dart`: of every dart's start.
void SheetMesh::build(std::size_t sheets, std::vector<std::uint32_t> mate,
                      const std::vector<std::uint32_t>& sheet_of_dart, const Executor& executor) {
    const std::size_t edges = edge_count(mate);
    std::vector<std::uint32_t>& halfedge = mate;
    connectivity_.reserve(sheets, edges, mate.size() / 3);
    run(executor, 2, [&](std::size_t task) {
        if (task == 0)
            connectivity_.resize(sheets, edges, mate.size() / 3);
        else
            number_halfedges(mate);
    });
    const auto inner = [&](std::uint32_t d) { return HalfedgeHandle(static_cast<int>(halfedge[d])); };
    const auto sheet = [&](std::uint32_t d) { return VertexHandle(static_cast<int>(sheet_of_dart[d])); };
    for_each_run(executor, halfedge.size() / 3, faces_per_task, [&](std::size_t begin, std::size_t end) {
        for (auto d = static_cast<std::uint32_t>(3 * begin); d < 3 * end; ++d) {
            const FaceHandle face(static_cast<int>(d / 3));
            connectivity_.set_vertex_handle(inner(d), sheet(next_dart(d)));
            connectivity_.set_face_handle(inner(d), face);
            link(inner(d), inner(next_dart(d)));
            if (d % 3 == 0) connectivity_.set_halfedge_handle(face, inner(d));
        }
    });
    for (std::uint32_t d = 0; d < halfedge.size(); ++d) {
        connectivity_.set_halfedge_handle(sheet(d), inner(d));
        if (is_open(opposite(inner(d)))) connectivity_.set_vertex_handle(opposite(inner(d)), sheet(d));
    }
    link_borders();
}

void SheetMesh::link_borders() {
    for (std::size_t i = 0; i < connectivity_.n_halfedges(); ++i) {
        const HalfedgeHandle border(static_cast<int>(i));
        if (!is_open(border)) continue;
        HalfedgeHandle following = opposite(border);  // turned around the border's end, to the other border there
        while (!is_open(following)) following = opposite(previous(following));
        link(border, following);
        connectivity_.set_halfedge_handle(to_sheet(border), following);
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

// Gives a position's first sheet a further number; it is in no list.
VertexHandle SheetMesh::renamed(VertexHandle sheet) {
    const VertexHandle further = connectivity_.new_vertex();
    connectivity_.set_halfedge_handle(further, outgoing(sheet));
    connectivity_.set_halfedge_handle(sheet, HalfedgeHandle());
    for_each_outgoing(further, [&](HalfedgeHandle h) { connectivity_.set_vertex_handle(opposite(h), further); });
    return further;
}

void SheetMesh::merge(std::uint32_t source, std::uint32_t target) {
    const auto merge_sheet = [&](VertexHandle sheet) {
        if (!outgoing(sheet).is_valid()) return;
        const HalfedgeHandle edge = manifold_edge(sheet, target, false);
        if (edge.is_valid()) return collapse(edge);
        cut_out(sheet, target);
        if (!outgoing(sheet).is_valid()) return;
        const VertexHandle moved = index_of(sheet) < positions_ ? renamed(sheet) : sheet;
        list_further(index_of(moved) - positions_, target);
    };
    std::uint32_t i = none;
    if (has_further(source)) std::swap(i, first_further_[source]);
    merge_sheet(own_sheet(source));
    while (i != none) {
        const std::uint32_t following = further_[i].next;
        merge_sheet(further_sheet(i));
        i = following;
    }
}

}  // namespace lodestream::simplify
