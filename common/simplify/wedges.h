// The vertices ("wedges") at each position with their attributes as they are now, and which of them may stand in for
// which when two positions merge.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::simplify {

// What a vertex has beside its position. A normal is as long as the area that it stands for, so that merged normals are
// the mean over what was merged; only its direction leaves the engine.
struct Attributes {
    Vec3f normal{0.0f};
    Vec2f texture_coordinate{0.0f};
    Rgba8 color{0};
};

class Wedges {
  public:
    Wedges() = default;
    // `positions`: of every vertex of the mesh its position's number, below `count`; each is some vertex's.
    // `wedge_of_vertex` is filled with the wedges' numbers: the first of a position has the position's, the others come
    // after those, in the order of their positions.
    Wedges(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& positions, std::uint32_t count,
           std::vector<std::uint32_t>& wedge_of_vertex);

    // The wedges of one position.
    class Range {
      public:
        struct Iterator {
            std::uint32_t wedge, next;
            std::uint32_t operator*() const { return wedge; }
            Iterator& operator++() {
                wedge = next++;
                return *this;
            }
            bool operator!=(const Iterator& o) const { return next != o.next; }
        };
        Range(std::uint32_t own, std::uint32_t further, std::uint32_t end) : own_(own), further_(further), end_(end) {}
        std::uint32_t own() const { return own_; }
        std::uint32_t size() const { return end_ - further_ + 1; }
        Iterator begin() const { return {own_, further_}; }
        Iterator end() const { return {end_, end_ + 1}; }

      private:
        std::uint32_t own_, further_, end_;
    };
    Range at(std::uint32_t position) const {
        if (first_.empty()) return {position, 0, 0};
        return {position, first_[position], first_[position + 1]};
    }
    std::uint32_t position(std::uint32_t wedge) const {
        return wedge < positions_ ? wedge : further_position_[wedge - positions_];
    }
    std::size_t size() const { return size_; }

    // Vertices of one position that agree in texture coordinate, colour and material share a group; normals do not
    // count.
    std::uint32_t group(std::uint32_t wedge) const { return group_.empty() ? 0 : group_[wedge]; }
    bool has_seams() const { return !group_.empty(); }  // whether any position may have one
    bool has_seam(std::uint32_t position) const;

    // The corners of triangles at a wedge; counted until merging ends.
    void add_use(std::uint32_t wedge) { ++uses_[wedge]; }
    void drop_uses(std::uint32_t wedge, std::uint32_t count) { uses_[wedge] -= count; }
    bool is_used(std::uint32_t wedge) const { return uses_[wedge] > 0; }

    void end_merging() { uses_ = {}; }

    // The area around a wedge, >= 0: how much its normal counts.
    void weigh_normal(std::uint32_t wedge, double area);

    bool has_normals() const { return !normals_.empty(); }
    bool has_texture_coordinates() const { return !texture_coordinates_.empty(); }
    bool has_colors() const { return !colors_.empty(); }
    const Vec2f& texture_coordinate(std::uint32_t wedge) const { return texture_coordinates_[wedge]; }
    Attributes attributes(std::uint32_t wedge) const;
    void set_attributes(std::uint32_t wedge, const Attributes& a);
    // Texture coordinate and colour are set to those within a triangle of wedges; weights are of sum 1.
    void blend(const std::array<std::uint32_t, 3>& wedges, const Vec3d& weights, Attributes& a) const;

    struct Pair {
        std::uint32_t from;
        std::uint32_t to;
    };

    // For each wedge of `used` (all at one position) the used wedge of `target` that it becomes; appended to
    // `partners`. `told`: the pairs that the vanishing triangles join. `keep_seams`: returns false if a seam, a colour
    // border or a material border would be torn; else the nearest attributes are taken and the answer is true.
    bool find_partners(const std::vector<std::uint32_t>& used, std::uint32_t target, const std::vector<Pair>& told,
                       bool keep_seams, std::vector<Pair>& partners) const;

  private:
    std::uint32_t material(std::uint32_t wedge) const { return material_.empty() ? 0 : material_[wedge]; }
    bool agree(std::uint32_t a, std::uint32_t b) const;
    double attribute_distance(std::uint32_t a, std::uint32_t b) const;
    double normal_distance(std::uint32_t a, std::uint32_t b) const;
    std::uint32_t partner_in_group(std::uint32_t wedge, Range candidates, const std::vector<Pair>& told) const;
    std::uint32_t nearest(std::uint32_t wedge, Range candidates) const;
    void find_groups();

    std::size_t size_ = 0;
    std::uint32_t positions_ = 0;
    std::vector<Vec3f> normals_;
    std::vector<Vec2f> texture_coordinates_;
    std::vector<Rgba8> colors_;
    std::vector<std::uint32_t> material_;  // empty: all are of one
    std::vector<std::uint32_t> group_;     // the first wedge of the group; empty: all at a position agree
    std::vector<std::uint32_t> first_;     // of each position: its first further wedge; empty: each has one wedge
    std::vector<std::uint32_t> further_position_;  // of the wedges after those of the positions' numbers
    std::vector<std::uint32_t> uses_;
};

// The sum of two weighted normals; the first where they cancel out.
Vec3f joined_normal(const Vec3f& a, const Vec3f& b);

}  // namespace lodestream::simplify
