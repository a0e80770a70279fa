// A mesh as welded positions and faces between them, numbered along a curve through space: what is worked on together
// lies together in memory.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/mesh.h"
#include "common/simplify/executor.h"

namespace lodestream::simplify {

struct Geometry {
    int exponent = 0;           // points are the mesh's positions times 2^-exponent, exact down to 2^-126
    std::vector<Vec3f> points;  // of each position, those that no triangle uses last; typical edges are near 1
    std::vector<std::uint32_t> position_of;  // of each vertex
    std::vector<std::uint32_t> triangle_of;  // of each face: the mesh's triangle
    std::vector<mesh::Triangle> faces;       // of each face: positions, three different ones
};

Geometry weld(const mesh::Mesh& mesh, const Executor& executor);

}  // namespace lodestream::simplify
