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
        return simple_ ? index_of(sheet) : sheet_position_[index_of(sheet)];
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

    bool has_one_sheet(std::uint32_t at) const {
        if (simple_) return outgoing(VertexHandle(static_cast<int>(at))).is_valid();
        const std::uint32_t first = first_sheet_[at];
        return first != none && next_sheet_[first] == none;
    }
    // Whether any sheet here has an open border.
    bool is_on_border(std::uint32_t at) const {
        bool open = false;
        for_each_sheet(at, [&](VertexHandle sheet) { open = open || is_open(outgoing(sheet)); });
        return open;
    }

    template <class Visit>
    void for_each_sheet(std::uint32_t at, Visit visit) const {
        if (simple_) {
            const VertexHandle sheet(static_cast<int>(at));
            if (outgoing(sheet).is_valid()) visit(sheet);
            return;
        }
        for (std::uint32_t s = first_sheet_[at]; s != none; s = next_sheet_[s]) {
            const VertexHandle sheet(static_cast<int>(s));
            if (outgoing(sheet).is_valid()) visit(sheet);
        }
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
    void place_sheets(const std::vector<mesh::Triangle>& corners, const std::vector<std::uint32_t>& sheet_of_dart,
                      std::size_t positions, std::size_t sheets);
    template <class SheetAt>
    void build(std::size_t sheets, const std::vector<std::uint32_t>& mate, const Executor& executor,
               const SheetAt& sheet_at);
    void list_sheets();
    void move(std::uint32_t sheet, std::uint32_t target);
    bool dangles(HalfedgeHandle h) const;
    bool shares_other_neighbours(VertexHandle a, VertexHandle b, VertexHandle left, VertexHandle right) const;

    void fold(HalfedgeHandle keep, HalfedgeHandle remove);
    void link(HalfedgeHandle h, HalfedgeHandle following) { connectivity_.set_next_halfedge_handle(h, following); }
    void take_out(HalfedgeHandle h);
    void take_out_face(FaceHandle face);
    void start_at_border(VertexHandle sheet);
    void cut_out(VertexHandle sheet, std::uint32_t target);

    OpenMesh::TriConnectivity connectivity_;
    bool simple_ = true;                         // each position has the one sheet of its number; no lists then
    std::vector<std::uint32_t> sheet_position_;  // of each OpenMesh vertex
    std::vector<std::uint32_t> first_sheet_;     // of each position, a list through next_sheet_
    std::vector<std::uint32_t> next_sheet_;
};

}  // namespace lodestream::simplify
