// What of a part of a scene can be seen from outside of it, and the closed surface that shows the same: pieces that lie
// closer than a cell are joined, what no way from outside leads to is left out.
// Source: Nooruddin and Turk 2003, "Simplification and repair of polygonal models using volumetric techniques", with
// the surface put back onto the pieces; HLOD paper (seeds-digest §4), which joins the objects of a branch.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/mesh.h"
#include "common/mesh/outside.h"

namespace lodestream::scene {

inline constexpr std::uint32_t min_cells = 8, max_cells = 256;

class Surroundings {
  public:
    // On so many cells along the longest side, clamped to the range above. `mesh` must outlive this; it has triangles.
    Surroundings(const mesh::Mesh& mesh, std::uint32_t cells);

    // The triangles that have a place at or beside a cell that is outside.
    const std::vector<std::uint32_t>& visible_triangles() const { return visible_; }

    // Whether a cell at or beside this place of the mesh is outside.
    bool sees(const Vec3f& position) const { return outside_.reaches(place(position)); }

    // The faces between what is outside and what is not: half of the triangles of wrapped().
    std::uint64_t faces() const;
    // The closed surface: vertices at the nearest places of the visible triangles, with the normals (turned outwards)
    // and colours there; no texture coordinates, one material.
    mesh::Mesh wrapped() const;

  private:
    Surroundings(const mesh::Mesh& mesh, const Box& box, std::uint32_t cells);
    Vec3d place(const Vec3f& position) const { return Vec3d(position) - low_; }
    template <class Visit>
    void for_each_face(Visit visit) const;

    const mesh::Mesh& mesh_;
    Vec3d low_;
    double cell_size_;
    mesh::Outside outside_;
    std::vector<std::uint32_t> visible_;
};

}  // namespace lodestream::scene
