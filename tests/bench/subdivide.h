// Large models made from the scans at hand.
#pragma once

#include <cstdint>

#include "common/mesh/mesh.h"

namespace lodestream::bench {

// Four triangles for one, smoothed (Loop 1987; Warren's weights; boundaries by cubic splines). Positions and triangles
// alone. pre: manifold (see connectivity.h)
mesh::Mesh loop_subdivide(const mesh::Mesh& mesh);

// `base` subdivided `steps` times, then moved along its normals by seeded noise: octaves from eight of the base's mean
// edges down to two of the result's, each with an amplitude of `roughness` times its wavelength. So the slopes are the
// same at every scale and the finest detail is as fine as the triangles, as in a scan.
mesh::Mesh detailed(const mesh::Mesh& base, int steps, double roughness, std::uint64_t seed);

}  // namespace lodestream::bench
