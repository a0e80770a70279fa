// The operations of the paper's Table 3, counted where they are done.
//
// The paper counts runs of its loops: one a polygon for its size and eight for "ambient, diffuse and specular
// reflection at each vertex", nine in all; then one more for a flat polygon's normal and four for the averaged normals
// of a Gouraud polygon's corners. Our reading of the eight: the ambient part once a polygon, for it is the same at
// every corner; the diffuse and the specular part once a corner each; one comparison of the three sums. Of the four:
// the polygon's own normal and its share in the average of each corner.
#pragma once

#include <cstdint>

namespace lodestream::shading {

// Every field is raised by one where that operation is done, nowhere else.
struct OperationCounts {
    std::uint64_t sizes = 0;           // one a polygon
    std::uint64_t ambient = 0;         // one a polygon
    std::uint64_t diffuse = 0;         // one a corner
    std::uint64_t specular = 0;        // one a corner
    std::uint64_t comparisons = 0;     // one a polygon
    std::uint64_t face_normals = 0;    // one a polygon that is shaded
    std::uint64_t corner_normals = 0;  // one a corner of a Gouraud polygon

    std::uint64_t criterion() const { return sizes + ambient + diffuse + specular + comparisons; }
    std::uint64_t shading() const { return face_normals + corner_normals; }
    std::uint64_t total() const { return criterion() + shading(); }
};

}  // namespace lodestream::shading
