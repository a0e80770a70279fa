// Connectivity of any triangle mesh as manifold *sheets*, held by OpenMesh. A position where surfaces touch without
// forming one disc or half-disc is several OpenMesh vertices, one for each fan of triangles around it; they are kept
// together by their position, so that what touches before a merge touches after it.
#pragma once

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <cstdint>
#include <vector>

#include "common/base/math.h"
#include "common/mesh/mesh.h"
#include "common/simplify/executor.h"

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
    SheetMesh(const std::vector<mesh::Triangle>& corners, const std::vector<Vec3f>& points, const Executor& executor);

    // The connectivity for reading. What has been taken out has no vertex (half-edges), half-edge (vertices, faces).
    const OpenMesh::TriConnectivity& connectivity() const { return connectivity_; }
    std::size_t edges() const { return connectivity_.n_edges(); }
    std::size_t faces() const { return connectivity_.n_faces(); }
    bool is_live(EdgeHandle e) const { return to_sheet(connectivity_.halfedge_handle(e, 0)).is_valid(); }
    bool is_live(FaceHandle f) const { return connectivity_.halfedge_handle(f).is_valid(); }

    std::uint32_t position(VertexHandle sheet) const {
        const std::uint32_t s = index_of(sheet);
        return s < positions_ ? s : further_[s - positions_].position;
    }
    std::uint32_t from(HalfedgeHandle h) const { return to(opposite(h)); }
    std::uint32_t to(HalfedgeHandle h) const { return position(to_sheet(h)); }
    std::uint32_t apex(HalfedgeHandle h) const { return to(next(h)); }  // of the triangle left of h

    VertexHandle to_sheet(HalfedgeHandle h) const { return connectivity_.to_vertex_handle(h); }
    HalfedgeHandle outgoing(VertexHandle sheet) const { return connectivity_.halfedge_handle(sheet); }
    HalfedgeHandle next(HalfedgeHandle h) const { return connectivity_.next_halfedge_handle(h); }
    HalfedgeHandle previous(HalfedgeHandle h) const { return connectivity_.prev_halfedge_handle(h); }
    FaceHandle face(HalfedgeHandle h) const { return connectivity_.face_handle(h); }
    bool is_open(HalfedgeHandle h) const { return !face(h).is_valid(); }  // no triangle on its left
    static HalfedgeHandle opposite(HalfedgeHandle h) { return HalfedgeHandle(h.idx() ^ 1); }
    static EdgeHandle edge(HalfedgeHandle h) { return EdgeHandle(h.idx() >> 1); }

    bool has_one_sheet(std::uint32_t at) const { return outgoing(own_sheet(at)).is_valid() && !has_further(at); }
    // Whether any sheet here has an open border.
    bool is_on_border(std::uint32_t at) const {
        bool open = false;
        for_each_sheet(at, [&](VertexHandle sheet) { open = open || is_open(outgoing(sheet)); });
        return open;
    }

    template <class Visit>
    void for_each_sheet(std::uint32_t at, Visit visit) const {
        const auto visit_live = [&](VertexHandle sheet) {
            if (outgoing(sheet).is_valid()) visit(sheet);
        };
        visit_live(own_sheet(at));
        if (!has_further(at)) return;
        for (std::uint32_t i = first_further_[at]; i != none; i = further_[i].next) visit_live(further_sheet(i));
    }
    template <class Visit>
    void for_each_outgoing(VertexHandle sheet, Visit visit) const {
        const HalfedgeHandle start = outgoing(sheet);
        if (!start.is_valid()) return;
        HalfedgeHandle h = start;
        do {
            visit(h);
            h = opposite(previous(h));
        } while (h != start);
    }
    // Of all sheets at a position.
    template <class Visit>
    void for_each_outgoing(std::uint32_t at, Visit visit) const {
        for_each_sheet(at, [&](VertexHandle sheet) { for_each_outgoing(sheet, visit); });
    }

    // The edge by which a sheet can merge into `target` and stay manifold; invalid where there is none or no single
    // one. `along_border`: an open boundary may not be left.
    HalfedgeHandle manifold_edge(VertexHandle sheet, std::uint32_t target, bool along_border) const;

    // Takes out an edge and its triangles; what it starts from becomes what it ends at.
    // pre: manifold_edge() gave `h`, and the position that it starts from has one sheet
    void collapse(HalfedgeHandle h);

    // Moves all sheets of `source` to `target` and takes out the triangles between the two: by an edge collapse where
    // the result is manifold, else by cutting the triangles out.
    void merge(std::uint32_t source, std::uint32_t target);

  private:
    void build(std::size_t sheets, std::vector<std::uint32_t> mate, const std::vector<std::uint32_t>& sheet_of_dart,
               const Executor& executor);
    void link_borders();
    static VertexHandle own_sheet(std::uint32_t position) { return VertexHandle(static_cast<int>(position)); }
    VertexHandle further_sheet(std::uint32_t i) const { return VertexHandle(static_cast<int>(positions_ + i)); }
    bool has_further(std::uint32_t at) const { return !first_further_.empty() && first_further_[at] != none; }
    void list_further(std::uint32_t i, std::uint32_t position);
    VertexHandle renamed(VertexHandle sheet);
    bool dangles(HalfedgeHandle h) const;
    bool shares_other_neighbours(VertexHandle a, VertexHandle b, VertexHandle left, VertexHandle right) const;

    void fold(HalfedgeHandle keep, HalfedgeHandle remove);
    void link(HalfedgeHandle h, HalfedgeHandle following) { connectivity_.set_next_halfedge_handle(h, following); }
    void take_out(HalfedgeHandle h);
    void take_out_face(FaceHandle face);
    void start_at_border(VertexHandle sheet);
    void cut_out(VertexHandle sheet, std::uint32_t target);

    OpenMesh::TriConnectivity connectivity_;
    // A position's first sheet has its number. The others come after those, in lists.
    struct Further {
        std::uint32_t position;
        std::uint32_t next;  // of further_; none: the last one
    };
    std::uint32_t positions_ = 0;
    std::vector<Further> further_;
    std::vector<std::uint32_t> first_further_;  // of each position, of further_; empty: none has any
};

}  // namespace lodestream::simplify
