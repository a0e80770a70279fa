// What finest tiles of a scene have in common decodes to the same bits in all of them, however fine each is by itself:
// a border is rounded to the lattice of the coarsest tile that it belongs to, or to one four times as coarse as the
// finest one's, and every tile's lattice is at least as fine as its borders'. Lattices are of powers of two
// (codec::choose_window), so the finer holds all of the coarser.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/codec/level_codec.h"
#include "common/mesh/mesh.h"
#include "common/simplify/executor.h"

namespace lodestream::bake {

class TileBorders {
  public:
    // `triangles`: of each leaf, those of `mesh`; may be empty. Memory: 8 bytes a vertex and 4 a triangle, and 16 a
    // vertex meanwhile. `mesh` is to outlive it.
    TileBorders(const mesh::Mesh& mesh, std::vector<std::vector<std::uint32_t>> triangles,
                const simplify::Executor& executor);

    // The leaf's borders rounded. `part`: mesh::part of its triangles
    mesh::Mesh rounded(std::size_t leaf, mesh::Mesh part) const;
    // That holds all of them, and what the leaf deserves by itself. `rounded`: as above, not empty
    codec::QuantizationGrid grid(std::size_t leaf, const mesh::Mesh& rounded) const;

    std::span<const std::uint32_t> triangles(std::size_t leaf) const { return triangles_[leaf]; }

  private:
    void find_borders(std::span<const double> coarsest, std::span<const double> finest);

    const mesh::Mesh& mesh_;
    std::vector<std::vector<std::uint32_t>> triangles_;
    std::vector<std::uint32_t> first_;  // of each vertex: the first one in the same place
    std::vector<float> border_steps_;   // of those; 0: not on a border
    std::vector<double> steps_;         // of each leaf
};

}  // namespace lodestream::bake
