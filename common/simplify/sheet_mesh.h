// Connectivity of any triangle mesh as manifold *sheets*, held by OpenMesh. A position where surfaces touch without
// forming one disc or half-disc is several OpenMesh vertices, one for each fan of triangles around it; they are kept
// together by their position, so that what touches before a merge touches after it.
#pragma once

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <cstdint>
#include <vector>

#include "common/base/math.h"
#include "common/mesh/mesh.h"

namespace lodestream::simplify {

inline constexpr std::uint32_t none = 0xffffffffu;

using OpenMesh::EdgeHandle;
using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

inline std::uint32_t index_of(const OpenMesh::BaseHandle& handle) {
    return static_cast<std::uint32_t>(handle.idx());
}

class SheetMesh {
  public:
    // `corners`: of every triangle three different positions, each < points.size(). Face i is corners[i].
    SheetMesh(const std::vector<mesh::Triangle>& corners, const std::vector<Vec3d>& points);

    OpenMesh::TriConnectivity& connectivity() { return connectivity_; }
    std::uint32_t position(VertexHandle sheet) const { return sheet_position_[index_of(sheet)]; }
    std::uint32_t from(HalfedgeHandle h) const { return position(connectivity_.from_vertex_handle(h)); }
    std::uint32_t to(HalfedgeHandle h) const { return position(connectivity_.to_vertex_handle(h)); }

    template <class Visit>
    void for_each_sheet(std::uint32_t at, Visit visit) const {
        for (std::uint32_t s = first_sheet_[at]; s != none; s = next_sheet_[s]) {
            const VertexHandle sheet(static_cast<int>(s));
            if (!connectivity_.status(sheet).deleted()) visit(sheet);
        }
    }

    template <class Visit>
    void for_each_outgoing(VertexHandle sheet, Visit visit) const {
        const HalfedgeHandle start = connectivity_.halfedge_handle(sheet);
        if (!start.is_valid()) return;
        HalfedgeHandle h = start;
        do {
            visit(h);
            h = connectivity_.opposite_halfedge_handle(connectivity_.prev_halfedge_handle(h));
        } while (h != start);
    }

    // The edge by which a sheet can merge into `target` and stay manifold; invalid where there is none or no single
    // one. `along_border`: an open boundary may not be left.
    HalfedgeHandle manifold_edge(VertexHandle sheet, std::uint32_t target, bool along_border);

    // Moves all sheets of `source` to `target` and takes out the triangles between the two: by an edge collapse where
    // the result is manifold, else by cutting the triangles out. Appends the edges whose ends have changed.
    void merge(std::uint32_t source, std::uint32_t target, std::vector<EdgeHandle>& changed);

  private:
    void build(const std::vector<mesh::Triangle>& corners, const std::vector<std::uint32_t>& mate,
               const std::vector<std::uint32_t>& sheet_of_corner);
    bool shares_other_neighbours(VertexHandle a, VertexHandle b, VertexHandle left, VertexHandle right);
    bool dangles(HalfedgeHandle h) const;
    void cut_out(VertexHandle sheet, std::uint32_t target);

    OpenMesh::TriConnectivity connectivity_;
    std::vector<std::uint32_t> sheet_position_;  // of each OpenMesh vertex
    std::vector<std::uint32_t> first_sheet_;     // of each position, a list through next_sheet_
    std::vector<std::uint32_t> next_sheet_;
    std::vector<std::uint32_t> mark_;  // of each OpenMesh vertex: the last ring that it was seen in
    std::uint32_t ring_ = 0;
    std::vector<FaceHandle> cut_faces_;
};

}  // namespace lodestream::simplify
