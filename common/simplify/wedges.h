// The vertices ("wedges") at each position, and which of them may stand in for which when two positions merge.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::simplify {

class Wedges {
  public:
    // `positions`: of every vertex its position's number, below `count`.
    Wedges(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& positions, std::uint32_t count);

    struct Range {
        const std::uint32_t* first;
        const std::uint32_t* last;
        const std::uint32_t* begin() const { return first; }
        const std::uint32_t* end() const { return last; }
        std::size_t size() const { return static_cast<std::size_t>(last - first); }
    };
    Range at(std::uint32_t position) const {
        return {vertices_.data() + first_[position], vertices_.data() + first_[position + 1]};
    }

    // Vertices of one position that agree in texture coordinate, colour and material share a group; normals do not
    // count.
    std::uint32_t group(std::uint32_t vertex) const { return group_[vertex]; }

    struct Pair {
        std::uint32_t from;
        std::uint32_t to;
    };

    // For each vertex of `used` (all at one position) the vertex of `target` that it becomes; appended to `partners`.
    // `told`: the pairs that the vanishing triangles join. `keep_seams`: returns false if a seam, a colour border or a
    // material border would be torn; else the nearest attributes are taken and the answer is true.
    bool find_partners(const std::vector<std::uint32_t>& used, std::uint32_t target, const std::vector<Pair>& told,
                       bool keep_seams, std::vector<Pair>& partners) const;

  private:
    bool agree(std::uint32_t a, std::uint32_t b) const;
    double attribute_distance(std::uint32_t a, std::uint32_t b) const;
    double normal_distance(std::uint32_t a, std::uint32_t b) const;
    std::uint32_t partner_in_group(std::uint32_t vertex, std::uint32_t target, const std::vector<Pair>& told) const;
    std::uint32_t nearest(std::uint32_t vertex, Range candidates) const;

    const mesh::Mesh& mesh_;
    std::vector<std::uint32_t> material_;  // of each vertex
    std::vector<std::uint32_t> group_;     // of each vertex: the first vertex of its group
    std::vector<std::uint32_t> first_;     // of each position, into vertices_
    std::vector<std::uint32_t> vertices_;
};

}  // namespace lodestream::simplify
