// The surface while it is simplified: connectivity, places, attributes, and the one operation on it, the merge of two
// positions. Workers may change it at the same time as long as no two of them touch one position or its neighbours.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "common/simplify/log.h"
#include "common/simplify/placement.h"
#include "common/simplify/sheet_mesh.h"
#include "common/simplify/wedges.h"

namespace lodestream::simplify {

// What a merge has to leave intact, and the price of not doing so: the harm is taken to be that of moving the area
// around the source by the length of the merge, times `price`. A merge is tried by the first rules, and by the next
// where refused.
struct Rules {
    bool placed;  // at the place of least energy; else at one of the two ends
    bool sheets;  // the surface stays manifold, open borders are not left
    bool seams;   // texture, colour and material borders stay whole
    bool shape;   // no triangle turns over, degenerates or becomes a sliver
    double price;
};
inline constexpr std::array<Rules, 5> rule_levels{{{true, true, true, true, 1e-6},
                                                   {false, true, true, true, 1e-6},
                                                   {false, false, true, true, 1.0},
                                                   {false, false, false, true, 3.0},
                                                   {false, false, false, false, 30.0}}};
inline constexpr std::uint8_t first_harmful_rules = 2;
inline constexpr std::uint8_t refused = rule_levels.size();

// A merge that may be tried: `source` becomes part of `target`, which moves to `point`.
struct Merge {
    HalfedgeHandle edge{};  // from source to target; invalid if there is none
    double cost = std::numeric_limits<double>::infinity();
    Vec3f point{0.0f};
    const Rules* rules = nullptr;
};

class Surface {
  public:
    Surface(mesh::Mesh mesh, const Executor& executor);

    std::size_t positions() const { return points_.size(); }
    std::size_t faces() const { return face_wedges_.size(); }
    int exponent() const { return exponent_; }                    // Geometry's
    const std::vector<Vec3f>& places() const { return points_; }  // of each position, scaled
    const Vec3f& place(std::uint32_t position) const { return points_[position]; }
    const Vec3f& place_of_wedge(std::uint32_t wedge) const { return points_[position_of_wedge(wedge)]; }
    bool has_materials() const { return !face_materials_.empty(); }
    std::uint32_t material(std::uint32_t face) const { return face_materials_[face]; }
    const SheetMesh& sheets() const { return *sheets_; }  // pre: merging has not ended
    const Wedges& wedges() const { return wedges_; }
    const mesh::Triangle& face_wedges(std::uint32_t face) const { return face_wedges_[face]; }
    std::uint32_t position_of_wedge(std::uint32_t wedge) const { return wedges_.position(wedge); }
    bool is_live(std::uint32_t face) const { return live_[face] != 0; }
    std::size_t live_faces() const;  // O(faces)
    double area(std::uint32_t face) const;

    struct Scratch;
    // Has `scratch` keep sums for these positions; another worker may not have one of them.
    void keep(std::span<const std::uint32_t> positions, Scratch& scratch);
    // The merge that an edge offers by the rules it has come to. pre: sums of both ends are kept
    Merge offer(EdgeHandle edge, Scratch& scratch) const;
    double cost(EdgeHandle edge);  // of the merge that it offers
    // Keeps an edge from being tried by the same rules again until something near it changes.
    void refuse(EdgeHandle edge, std::uint8_t level) { rules_[index_of(edge)] = static_cast<std::uint8_t>(level + 1); }
    void allow(EdgeHandle edge) { rules_[index_of(edge)] = 0; }
    void allow_all() { rules_.assign(rules_.size(), 0); }
    std::uint8_t rules_of(EdgeHandle edge) const { return rules_[index_of(edge)]; }

    // Memory of one worker: of the positions it was given, and for the merge at hand.
    struct Scratch {
        struct Corner {
            std::uint32_t face;
            std::uint32_t corner;  // the one that moves
        };
        struct Change {
            std::uint32_t wedge;
            Attributes attributes;
        };
        std::vector<StoredForm> forms;
        std::vector<Corner> staying;        // around the source
        std::vector<Corner> around_target;  // that stay too
        std::vector<std::uint32_t> vanishing;
        std::vector<Wedges::Pair> told;
        std::vector<std::uint32_t> used;
        std::vector<Wedges::Pair> partners;
        std::vector<Change> changes;  // of the target's wedges
        std::vector<std::uint32_t> neighbours;
        std::vector<EdgeHandle> edges;  // of what moves
        std::size_t vanished = 0;       // faces, by the last merge
    };
    // Makes the merge and logs it, or changes nothing and returns false where its rules forbid it. `max_vanishing`:
    // a merge that takes this many triangles or more is refused. pre: sums of all that it touches are kept
    bool merge(const Merge& merge, std::size_t max_vanishing, Log& log, Scratch& scratch);

    // Drops the faces, each in a step of its own, at `key` or later.
    void drop(const std::vector<std::uint32_t>& faces, float key, Log& log);
    void drop_smallest_first(std::vector<std::uint32_t> faces, std::size_t count, float key, Log& log);

    // Frees what only merging needs.
    void end_merging();

  private:
    void weigh_normals();
    StoredForm& form(std::uint32_t position, Scratch& s) const { return s.forms[slots_[position]]; }
    const StoredForm& summed(std::uint32_t position, Scratch& s) const {
        StoredForm& stored = form(position, s);
        if (stored.is_stale()) sum_form(position, stored);
        return stored;
    }
    void sum_form(std::uint32_t position, StoredForm& stored) const;
    Vec3d shared_area(HalfedgeHandle h) const;
    bool is_line(HalfedgeHandle h) const;
    bool is_seam(HalfedgeHandle h) const;
    bool must_hold(std::uint32_t position) const;
    std::uint32_t wedge_at(std::uint32_t face, std::uint32_t position) const;
    Merge at_end(HalfedgeHandle h, const Rules& rules, double cost, double area) const;
    Vec3d point(std::uint32_t position) const { return Vec3d(points_[position]); }

    bool keeps_sheets(std::uint32_t source, std::uint32_t target) const;
    void prepare_positions(const Executor& executor);
    void gather(std::uint32_t source, std::uint32_t target, bool moves, Scratch& s) const;
    bool keeps_shape(const Scratch::Corner& c, const Vec3d& new_apex) const;
    bool keeps_texture(const Scratch::Corner& c, const Scratch& s) const;
    bool find_partners(std::uint32_t source, std::uint32_t target, const Rules& rules, Scratch& s) const;
    void set_nearest(const Merge& merge, std::uint32_t wedge, const Scratch& s, Attributes& attributes) const;
    void find_changes(const Merge& merge, std::uint32_t target, Scratch& s) const;
    float step_key(const Merge& merge, std::uint32_t source, std::uint32_t target, const Scratch& s) const;
    void commit(const Merge& merge, std::uint32_t source, std::uint32_t target, Log& log, Scratch& s);
    void drop_use(std::uint32_t wedge, Log& log);
    void vanish(std::uint32_t face, std::uint32_t dying, float key, Log& log);

    int exponent_ = 0;
    std::vector<Vec3f> points_;  // of each position, scaled
    std::optional<SheetMesh> sheets_;
    Wedges wedges_;
    std::vector<mesh::Triangle> face_wedges_;    // of each face, in the corner order of the source's triangle
    std::vector<std::uint32_t> face_materials_;  // of each face; empty: all alike
    std::vector<std::uint8_t> live_;             // of each face
    std::vector<std::uint8_t> seam_;             // of each position: whether attributes part there
    std::vector<std::uint8_t> held_;             // of each position: whether it must not move on its own
    std::vector<std::uint32_t> slots_;           // of each position: of the forms of the worker that has it
    std::vector<float> keys_;                    // of each position: of the last step that touched it
    std::vector<std::uint8_t> rules_;            // of each edge
};

// The square root of a cost, as steps are ordered by.
inline float key_of_cost(double cost) {
    return static_cast<float>(std::min(std::sqrt(cost), double{std::numeric_limits<float>::max()}));
}

}  // namespace lodestream::simplify
