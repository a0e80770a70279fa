#include "common/simplify/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/mesh/nearest.h"
#include "common/simplify/geometry.h"

namespace lodestream::simplify {

namespace {

// Weights of the lines that hold open borders and seams in place, against the triangles.
constexpr double border_weight = 1.0;
constexpr double seam_weight = 0.8;

constexpr double min_turn_cosine = 0.5;     // a triangle may turn by 60 degrees in one merge
constexpr double degenerate_height = 1e-7;  // of the longest side: the noise of float positions
constexpr double sliver_height = 1e-2;      // of the longest side; thinner only if it was so already

// A position with more triangles stays where it is when others merge into it: what is far around it is left alone.
constexpr std::uint16_t hub_triangles = 256;
// A merge of more wedges is refused: a step of the log has room for no more, with those that go at other positions.
constexpr std::size_t max_step_wedges = Log::max_deaths / 2;
// An end of the edge that costs no more than this above the minimum (of the area times the squared length) is taken.
constexpr double end_tolerance = 1e-9;

constexpr double squared(double x) {
    return x * x;
}

constexpr std::uint16_t saturated(std::size_t count) {
    return static_cast<std::uint16_t>(std::min<std::size_t>(count, 0xffff));
}

}  // namespace

// What the mesh and the geometry hold is freed as soon as it has been taken over: this is where memory peaks.
Surface::Surface(mesh::Mesh mesh, const Executor& executor) {
    Geometry g = weld(mesh, executor);
    mesh.positions = {};
    exponent_ = g.exponent;
    points_ = std::move(g.points);
    const auto count = static_cast<std::uint32_t>(points_.size());

    std::vector<std::uint32_t> wedge_of_vertex;
    wedges_ = Wedges(mesh, g.position_of, count, wedge_of_vertex);
    mesh.normals = {};
    mesh.texture_coordinates = {};
    mesh.colors = {};
    g.position_of = {};

    struct FurtherCorner {
        std::uint32_t face, corner, wedge;
    };
    std::vector<FurtherCorner> further;  // whose wedges do not have their positions' numbers
    if (wedges_.size() > count)
        for (std::uint32_t face = 0; face < g.triangle_of.size(); ++face)
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t wedge = wedge_of_vertex[mesh.triangles[g.triangle_of[face]][k]];
                if (wedge >= count) further.push_back({face, k, wedge});
            }
    wedge_of_vertex = {};
    if (!mesh.triangle_materials.empty())
        for (const std::uint32_t t : g.triangle_of) face_materials_.push_back(mesh.triangle_materials[t]);
    mesh = {};
    face_wedges_ = std::move(g.faces);
    g = {};
    sheets_.emplace(face_wedges_, points_, executor);  // they are still positions
    for (const FurtherCorner& at : further) face_wedges_[at.face][at.corner] = at.wedge;
    further = {};
    for (const mesh::Triangle& t : face_wedges_)
        for (const std::uint32_t wedge : t) wedges_.add_use(wedge);
    prepare_positions(executor);
}

void Surface::prepare_positions(const Executor& executor) {
    live_.assign(faces(), 1);
    seam_.assign(positions(), 0);
    if (wedges_.has_seams())
        for (std::uint32_t p = 0; p < seam_.size(); ++p) seam_[p] = wedges_.has_seam(p);
    held_.assign(positions(), 0);
    keys_.assign(positions(), 0.0f);
    rules_.assign(sheets_->edges(), 0);
    slots_.assign(positions(), 0);
    run(executor, 2, [&](std::size_t task) {
        if (task == 0) return weigh_normals();
        for (std::uint32_t p = 0; p < held_.size(); ++p) held_[p] = must_hold(p);
    });
}

void Surface::weigh_normals() {
    if (!wedges_.has_normals()) return;
    std::vector<float> area_at(wedges_.size(), 0.0f);
    for (std::uint32_t f = 0; f < face_wedges_.size(); ++f) {
        const auto size = static_cast<float>(area(f));
        for (const std::uint32_t w : face_wedges_[f]) area_at[w] += size;
    }
    for (std::uint32_t w = 0; w < area_at.size(); ++w) wedges_.weigh_normal(w, double{area_at[w]});
}

void Surface::end_merging() {
    sheets_.reset();
    slots_ = {};
    held_ = {};
    keys_ = {};
    rules_ = {};
    wedges_.end_merging();
}

std::size_t Surface::live_faces() const {
    return static_cast<std::size_t>(std::count(live_.begin(), live_.end(), 1));
}

double Surface::area(std::uint32_t face) const {
    const mesh::Triangle& w = face_wedges_[face];
    const Vec3d a = point(position_of_wedge(w[0]));
    return 0.5 * length(cross(point(position_of_wedge(w[1])) - a, point(position_of_wedge(w[2])) - a));
}

std::uint32_t Surface::wedge_at(std::uint32_t face, std::uint32_t position) const {
    const mesh::Triangle& w = face_wedges_[face];
    return position_of_wedge(w[0]) == position ? w[0] : position_of_wedge(w[1]) == position ? w[1] : w[2];
}

// Energies

bool Surface::is_seam(HalfedgeHandle h) const {
    const std::uint32_t from = sheets_->from(h), to = sheets_->to(h);
    if (!seam_[from] || !seam_[to]) return false;
    const std::uint32_t left = index_of(sheets_->face(h)), right = index_of(sheets_->face(SheetMesh::opposite(h)));
    for (const std::uint32_t end : {from, to})
        if (wedges_.group(wedge_at(left, end)) != wedges_.group(wedge_at(right, end))) return true;
    return false;
}

// Whether the surface or its attributes end at the edge.
bool Surface::is_line(HalfedgeHandle h) const {
    return sheets_->is_open(h) || sheets_->is_open(SheetMesh::opposite(h)) || is_seam(h);
}

bool Surface::must_hold(std::uint32_t position) const {
    return seam_[position] || !sheets_->has_one_sheet(position) || sheets_->is_on_border(position);
}

void Surface::sum_form(std::uint32_t position, StoredForm& stored) const {
    Form sum;
    std::size_t triangles = 0;
    const Vec3d at = point(position);
    sheets_->for_each_sheet(position, [&](VertexHandle sheet) {
        const HalfedgeHandle start = sheets_->outgoing(sheet);
        HalfedgeHandle h = start;
        Vec3d side = point(sheets_->to(h)) - at;
        do {  // from spoke to spoke: each is a side of two triangles
            const HalfedgeHandle following = SheetMesh::opposite(sheets_->previous(h));
            const Vec3d next_side = point(sheets_->to(following)) - at;
            const bool open = sheets_->is_open(h);
            if (!open) {
                sum.add_triangle(cross(side, next_side));
                ++triangles;
            }
            if (open || sheets_->is_open(SheetMesh::opposite(h)))
                sum.add_line(side, border_weight);
            else if (seam_[position] && is_seam(h))
                sum.add_line(side, seam_weight);
            side = next_side;
            h = following;
        } while (h != start);
    });
    stored.matrix = Symmetric<float>(sum.matrix);
    for (int k = 0; k < 3; ++k) stored.area[k] = static_cast<float>(sum.area[k]);
    stored.triangles = saturated(triangles);
    stored.changes = 0;
}

// Twice the area vector of the triangles that both ends of an edge have in common.
Vec3d Surface::shared_area(HalfedgeHandle h) const {
    const HalfedgeHandle back = SheetMesh::opposite(h);
    const std::uint32_t from = sheets_->from(h);
    const std::uint32_t left = sheets_->is_open(h) ? from : sheets_->apex(h);
    const std::uint32_t right = sheets_->is_open(back) ? from : sheets_->apex(back);
    return cross(point(sheets_->to(h)) - point(from), point(left) - point(right));
}

Merge Surface::at_end(HalfedgeHandle h, const Rules& rules, double cost, double area) const {
    const Vec3d from = point(sheets_->from(h)), to = point(sheets_->to(h));
    return {h, cost + rules.price * area * dot(to - from, to - from), points_[sheets_->to(h)], &rules};
}

void Surface::keep(std::span<const std::uint32_t> positions, Scratch& s) {
    s.forms.assign(positions.size(), StoredForm{});
    for (std::uint32_t slot = 0; slot < positions.size(); ++slot) slots_[positions[slot]] = slot;
}

double Surface::cost(EdgeHandle edge) {
    const HalfedgeHandle h(2 * edge.idx());
    Scratch scratch;
    keep(std::array{sheets_->from(h), sheets_->to(h)}, scratch);
    return offer(edge, scratch).cost;
}

Merge Surface::offer(EdgeHandle edge, Scratch& s) const {
    std::uint8_t level = rules_[index_of(edge)];
    if (level >= refused || !sheets_->is_live(edge)) return Merge{};
    const HalfedgeHandle h(2 * edge.idx()), back = SheetMesh::opposite(h);
    const std::uint32_t a = sheets_->from(h), b = sheets_->to(h);
    const StoredForm &stored_a = summed(a, s), &stored_b = summed(b, s);
    const Form form_a = stored_a.form(), form_b = stored_b.form();
    const EdgeEnergy energy(form_a, form_b, shared_area(h), point(b) - point(a));
    const double at_a = energy.at_start(), at_b = energy.at_end();
    const double area_a = form_a.matrix.trace(), area_b = form_b.matrix.trace();

    const bool hub_a = stored_a.triangles > hub_triangles, hub_b = stored_b.triangles > hub_triangles;
    bool hold_a = held_[a] != 0, hold_b = held_[b] != 0;
    if (hold_a && hold_b) {
        const bool along = is_line(h) && sheets_->has_one_sheet(a) && sheets_->has_one_sheet(b);
        if (!along) level = std::max<std::uint8_t>(level, 1);
        hold_a = hold_b = false;
    }
    if (hub_a != hub_b) (hub_a ? hold_a : hold_b) = true;

    const Rules& rules = rule_levels[level];
    if (level < first_harmful_rules && hold_a != hold_b)
        return hold_a ? at_end(back, rules, at_a, area_b) : at_end(h, rules, at_b, area_a);
    if (!rules.placed || (hub_a && hub_b)) {
        const Merge to_b = at_end(h, rules, at_b, area_a), to_a = at_end(back, rules, at_a, area_b);
        return to_a.cost < to_b.cost ? to_a : to_b;
    }

    const Vec3d x = energy.minimum();
    const double length2 = energy.length2(), area = area_a + area_b, least = energy.at(x);
    const double enough = least + end_tolerance * area * length2;
    if (at_a <= enough || at_b <= enough)
        return at_a <= at_b ? at_end(back, rules, at_a, area_b) : at_end(h, rules, at_b, area_a);
    Merge merge{h, least + rules.price * area * length2, Vec3f(point(a) + x), &rules};
    if (stored_b.triangles < stored_a.triangles) merge.edge = back;
    return merge;
}

// Merges

bool Surface::merge(const Merge& merge, std::size_t max_vanishing, Log& log, Scratch& s) {
    const std::uint32_t source = sheets_->from(merge.edge), target = sheets_->to(merge.edge);
    const Rules& rules = *merge.rules;
    const bool moves = merge.point != points_[target];
    if (rules.sheets && !keeps_sheets(source, target)) return false;
    gather(source, target, moves, s);
    if (s.vanishing.empty() || s.vanishing.size() >= max_vanishing) return false;
    if (rules.shape) {
        const Vec3d apex(merge.point);
        const auto keeps = [&](const Scratch::Corner& c) { return keeps_shape(c, apex); };
        if (!std::all_of(s.staying.begin(), s.staying.end(), keeps)) return false;
        if (!std::all_of(s.around_target.begin(), s.around_target.end(), keeps)) return false;
    }
    if (!find_partners(source, target, rules, s)) return false;
    if (s.partners.size() + wedges_.at(target).size() > max_step_wedges) return false;
    find_changes(merge, target, s);
    if (rules.seams && wedges_.has_texture_coordinates()) {
        const auto keeps = [&](const Scratch::Corner& c) { return keeps_texture(c, s); };
        if (!std::all_of(s.staying.begin(), s.staying.end(), keeps)) return false;
        if (!std::all_of(s.around_target.begin(), s.around_target.end(), keeps)) return false;
    }
    commit(merge, source, target, log, s);
    return true;
}

bool Surface::keeps_sheets(std::uint32_t source, std::uint32_t target) const {
    bool keeps = true;
    sheets_->for_each_sheet(
        source, [&](VertexHandle sheet) { keeps = keeps && sheets_->manifold_edge(sheet, target, true).is_valid(); });
    return keeps;
}

// Sorts the faces around the source, and the target's where it moves, into those that vanish and those that stay.
void Surface::gather(std::uint32_t source, std::uint32_t target, bool moves, Scratch& s) const {
    s.staying.clear();
    s.around_target.clear();
    s.vanishing.clear();
    s.told.clear();
    s.neighbours.clear();
    s.edges.clear();
    const auto corner_of = [&](std::uint32_t face, std::uint32_t position) {
        const mesh::Triangle& w = face_wedges_[face];
        return position_of_wedge(w[0]) == position ? 0u : position_of_wedge(w[1]) == position ? 1u : 2u;
    };
    sheets_->for_each_outgoing(source, [&](HalfedgeHandle h) {
        const std::uint32_t end = sheets_->to(h);
        if (end != target) s.neighbours.push_back(end);
        s.edges.push_back(SheetMesh::edge(h));
        if (sheets_->is_open(h)) return;
        const std::uint32_t face = index_of(sheets_->face(h));
        if (end == target || sheets_->apex(h) == target) {
            s.vanishing.push_back(face);
            s.told.push_back({wedge_at(face, source), wedge_at(face, target)});
        } else {
            s.staying.push_back({face, corner_of(face, source)});
        }
    });
    if (!moves) return;
    sheets_->for_each_outgoing(target, [&](HalfedgeHandle h) {
        const std::uint32_t end = sheets_->to(h);
        if (end != source) s.neighbours.push_back(end);
        s.edges.push_back(SheetMesh::edge(h));
        if (sheets_->is_open(h) || end == source || sheets_->apex(h) == source) return;
        const std::uint32_t face = index_of(sheets_->face(h));
        s.around_target.push_back({face, corner_of(face, target)});
    });
}

bool Surface::keeps_shape(const Scratch::Corner& c, const Vec3d& new_apex) const {
    const mesh::Triangle& w = face_wedges_[c.face];
    const Vec3d old_apex = point(position_of_wedge(w[c.corner]));
    const Vec3d a = point(position_of_wedge(w[(c.corner + 1) % 3])),
                b = point(position_of_wedge(w[(c.corner + 2) % 3]));
    const Vec3d old_cross = cross(a - old_apex, b - old_apex), new_cross = cross(a - new_apex, b - new_apex);
    const double base = dot(b - a, b - a);
    const double old_longest = std::max({base, dot(a - old_apex, a - old_apex), dot(b - old_apex, b - old_apex)});
    const double new_longest = std::max({base, dot(a - new_apex, a - new_apex), dot(b - new_apex, b - new_apex)});
    const double old_size2 = dot(old_cross, old_cross), new_size2 = dot(new_cross, new_cross);

    if (old_size2 <= squared(degenerate_height * old_longest)) return true;
    if (new_size2 <= squared(degenerate_height * new_longest)) return false;
    const double turn = dot(old_cross, new_cross);
    if (turn <= 0 || turn * turn < squared(min_turn_cosine) * old_size2 * new_size2) return false;
    if (new_size2 > squared(sliver_height * new_longest)) return true;
    return new_size2 * squared(old_longest) >= 0.25 * old_size2 * squared(new_longest);
}

// Whether the triangle stays the same way round in the texture.
bool Surface::keeps_texture(const Scratch::Corner& c, const Scratch& s) const {
    const mesh::Triangle& w = face_wedges_[c.face];
    std::uint32_t wedge = w[c.corner];
    for (const Wedges::Pair& pair : s.partners)
        if (pair.from == w[c.corner]) wedge = pair.to;
    glm::dvec2 new_apex(wedges_.texture_coordinate(wedge));
    for (const Scratch::Change& change : s.changes)
        if (change.wedge == wedge) new_apex = glm::dvec2(change.attributes.texture_coordinate);
    const glm::dvec2 old_apex(wedges_.texture_coordinate(w[c.corner]));
    const glm::dvec2 a(wedges_.texture_coordinate(w[(c.corner + 1) % 3]));
    const glm::dvec2 b(wedges_.texture_coordinate(w[(c.corner + 2) % 3]));
    const auto turn = [&](const glm::dvec2& apex) {
        return (a.x - apex.x) * (b.y - apex.y) - (a.y - apex.y) * (b.x - apex.x);
    };
    const double before = turn(old_apex), after = turn(new_apex);
    return before == 0 || (before > 0) == (after > 0);
}

bool Surface::find_partners(std::uint32_t source, std::uint32_t target, const Rules& rules, Scratch& s) const {
    s.partners.clear();
    s.used.clear();
    const Wedges::Range here = wedges_.at(source), there = wedges_.at(target);
    if (here.size() == 1 && there.size() == 1) {
        s.used.push_back(here.own());
        s.partners.push_back({here.own(), there.own()});
        return true;
    }
    for (const std::uint32_t w : here)
        if (wedges_.is_used(w)) s.used.push_back(w);
    return wedges_.find_partners(s.used, target, s.told, rules.seams, s.partners);
}

// Texture coordinate and colour are those that the surface had at the place nearest to the merge's: on the edge between
// two ends on a line, else on the faces around them that the wedge, or one that becomes part of it, belongs to.
void Surface::set_nearest(const Merge& merge, std::uint32_t wedge, const Scratch& s, Attributes& attributes) const {
    const Vec3d at(merge.point);
    const auto partner =
        std::find_if(s.partners.begin(), s.partners.end(), [&](const Wedges::Pair& pair) { return pair.to == wedge; });
    const std::uint32_t source = sheets_->from(merge.edge), target = sheets_->to(merge.edge);
    if (held_[source] && held_[target] && partner != s.partners.end()) {
        const Vec3d weights = mesh::nearest_weights(at, point(source), point(target), point(target));
        return wedges_.blend({partner->from, wedge, wedge}, weights, attributes);
    }
    double least = std::numeric_limits<double>::infinity();
    mesh::Triangle nearest{wedge, wedge, wedge};
    Vec3d nearest_share{1, 0, 0};
    const auto consider = [&](std::uint32_t face) {
        const mesh::Triangle& w = face_wedges_[face];
        const Vec3d a = point(position_of_wedge(w[0])), b = point(position_of_wedge(w[1])),
                    c = point(position_of_wedge(w[2]));
        const Vec3d weights = mesh::nearest_weights(at, a, b, c);
        const Vec3d off = weights.x * a + weights.y * b + weights.z * c - at;
        if (!(dot(off, off) < least)) return;
        least = dot(off, off);
        nearest = w;
        nearest_share = weights;
    };
    const auto becomes = [&](std::uint32_t from) {
        return std::any_of(s.partners.begin(), s.partners.end(),
                           [&](const Wedges::Pair& pair) { return pair.from == from && pair.to == wedge; });
    };
    for (std::size_t i = 0; i < s.vanishing.size(); ++i)
        if (s.told[i].to == wedge) consider(s.vanishing[i]);
    for (const Scratch::Corner& c : s.around_target)
        if (face_wedges_[c.face][c.corner] == wedge) consider(c.face);
    for (const Scratch::Corner& c : s.staying)
        if (becomes(face_wedges_[c.face][c.corner])) consider(c.face);
    wedges_.blend(nearest, nearest_share, attributes);
}

// The values that the target's wedges get; none where it stays as it is.
void Surface::find_changes(const Merge& merge, std::uint32_t target, Scratch& s) const {
    s.changes.clear();
    if (merge.point == points_[target]) return;
    for (const std::uint32_t w : wedges_.at(target)) {
        if (!wedges_.is_used(w)) continue;
        Attributes attributes = wedges_.attributes(w);
        for (const Wedges::Pair& pair : s.partners)
            if (pair.to == w && wedges_.has_normals()) {
                attributes.normal = joined_normal(attributes.normal, wedges_.attributes(pair.from).normal);
                break;
            }
        if (wedges_.has_texture_coordinates() || wedges_.has_colors()) set_nearest(merge, w, s, attributes);
        s.changes.push_back({w, attributes});
    }
}

float Surface::step_key(const Merge& merge, std::uint32_t source, std::uint32_t target, const Scratch& s) const {
    float key = std::max({key_of_cost(merge.cost), keys_[source], keys_[target]});
    for (const std::uint32_t n : s.neighbours) key = std::max(key, keys_[n]);
    return key;
}

// A wedge that no triangle has any more goes.
void Surface::drop_use(std::uint32_t wedge, Log& log) {
    wedges_.drop_uses(wedge, 1);
    if (wedges_.is_used(wedge)) return;
    log.deaths.push_back({wedge, 0});
    log.add_change(wedge, points_[position_of_wedge(wedge)], wedges_);
}

// `dying`: a position whose wedges are seen to by the merge.
void Surface::vanish(std::uint32_t face, std::uint32_t dying, float key, Log& log) {
    live_[face] = 0;
    for (const std::uint32_t w : face_wedges_[face]) {
        const std::uint32_t at = position_of_wedge(w);
        if (at == dying) {
            wedges_.drop_uses(w, 1);
        } else {
            drop_use(w, log);
            keys_[at] = std::max(keys_[at], key);
        }
    }
    log.faces.push_back(face);
}

void Surface::commit(const Merge& merge, std::uint32_t source, std::uint32_t target, Log& log, Scratch& s) {
    const float key = std::max(step_key(merge, source, target, s), log.last_key());
    s.vanished = s.vanishing.size();
    for (const Wedges::Pair& pair : s.partners) wedges_.add_use(pair.to);  // it must not go before the corners come
    if (s.vanishing.size() > 2) {
        drop_smallest_first(s.vanishing, s.vanishing.size() - 2, key, log);
        std::erase_if(s.vanishing, [&](std::uint32_t face) { return !is_live(face); });
    }

    for (const Wedges::Pair& pair : s.partners) {
        if (!wedges_.is_used(pair.from)) continue;
        std::uint32_t corners = 0;
        for (const Scratch::Corner& c : s.staying) {
            std::uint32_t& wedge = face_wedges_[c.face][c.corner];
            if (wedge != pair.from) continue;
            wedge = pair.to;
            wedges_.add_use(pair.to);
            log.corners.push_back(3 * c.face + c.corner);
            ++corners;
        }
        log.deaths.push_back({pair.from, corners});
        wedges_.drop_uses(pair.from, corners);
    }
    for (const std::uint32_t face : s.vanishing) vanish(face, source, key, log);
    for (const Wedges::Pair& pair : s.partners) drop_use(pair.to, log);
    for (const Scratch::Change& change : s.changes) {
        if (!wedges_.is_used(change.wedge)) continue;
        log.add_change(change.wedge, points_[target], wedges_);
        wedges_.set_attributes(change.wedge, change.attributes);
    }
    log.end_step(key);

    points_[target] = merge.point;
    seam_[target] |= seam_[source];
    keys_[target] = key;
    if (merge.rules->sheets && sheets_->has_one_sheet(source))
        sheets_->collapse(merge.edge);
    else
        sheets_->merge(source, target);
    for (const EdgeHandle edge : s.edges) rules_[index_of(edge)] = 0;
    for (const std::uint32_t n : s.neighbours) form(n, s).note_change();
    form(target, s).outdate();
    held_[target] = must_hold(target);
    if (!merge.rules->sheets)
        for (const std::uint32_t n : s.neighbours) held_[n] = must_hold(n);
}

// Dropping

void Surface::drop(const std::vector<std::uint32_t>& faces, float key, Log& log) {
    for (const std::uint32_t face : faces) {
        float after = std::max(key, log.last_key());
        for (const std::uint32_t w : face_wedges_[face]) after = std::max(after, keys_[position_of_wedge(w)]);
        vanish(face, none, after, log);
        log.end_step(after);
    }
}

void Surface::drop_smallest_first(std::vector<std::uint32_t> faces, std::size_t count, float key, Log& log) {
    std::vector<std::pair<double, std::uint32_t>> by_area;
    by_area.reserve(faces.size());
    for (const std::uint32_t face : faces) by_area.emplace_back(area(face), face);
    std::sort(by_area.begin(), by_area.end());
    faces.clear();
    for (std::size_t i = 0; i < count; ++i) faces.push_back(by_area[i].second);
    drop(faces, key, log);
}

}  // namespace lodestream::simplify
