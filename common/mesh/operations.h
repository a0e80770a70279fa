// Small whole-mesh operations that several stages share.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::mesh {

// The smallest box around the positions that triangles use; empty for a mesh without triangles.
Box bounds(const Mesh& mesh);

// For every vertex the lowest index of a vertex with the same position bit for bit (-0 counts as +0).
std::vector<std::uint32_t> weld_positions(const std::vector<Vec3f>& positions);

// Merges vertices that agree in every attribute and material, drops vertices without a triangle and triangles of fewer
// than three positions, and keeps the order of first use. Deterministic.
Mesh compact(const Mesh& mesh);

// These triangles of a mesh with the vertices that they use, in the order given. pre: triangles < mesh.triangles.size()
Mesh part(const Mesh& mesh, std::span<const std::uint32_t> triangles);

// Puts `from` behind `to`; vertices are not merged. pre: both have the same attributes, or `to` is empty
void append(Mesh& to, const Mesh& from);

// The mesh at another place: `matrix` maps world coordinates, positions are relative to `origin` before and after.
// Normals stay of unit length; where the matrix mirrors, triangles are turned around. pre: affine, not singular
Mesh placed(Mesh mesh, const Vec3d& origin, const Mat4d& matrix);

// The triangles without those that lie exactly on an earlier one and face the same way, whatever their attributes.
std::vector<std::uint32_t> distinct_triangles(const Mesh& mesh);

// Gives the mesh unit normals: the average over the triangles around a position, weighted by corner angle, of those
// whose own normals differ by at most `crease_degrees` from the corner's triangle. Sharper edges split their vertices.
// Zero-area triangles take the direction of their neighbours; where there is none, +y. Always finite.
Mesh with_normals(const Mesh& mesh, double crease_degrees);

// Corners whose normal is more than `max_degrees` off their triangle's own get that of with_normals() instead.
// pre: the mesh has unit normals
Mesh with_plausible_normals(const Mesh& mesh, double max_degrees, double crease_degrees);

// The unit normal of a triangle in double precision; (0,0,0) where it has no area.
Vec3d face_normal(const Vec3f& a, const Vec3f& b, const Vec3f& c);
double face_area(const Vec3f& a, const Vec3f& b, const Vec3f& c);

// Over the edges of all triangles; 0 where there are none.
double mean_edge_length(const Mesh& mesh);

}  // namespace lodestream::mesh
