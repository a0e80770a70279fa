// The colours of a coarse surface's vertices that come nearest to those of the surface it stands for.
#pragma once

#include <vector>

#include "common/mesh/mesh.h"

namespace lodestream::scene {

// Least squares over places spread evenly on `level`, each to show the colour of the nearest place of `source`, linear
// RGBA. Where nothing tells, as on triangles without area, a vertex keeps its colour.
// pre: both have triangles and colours
std::vector<Rgba8> fit_colors(const mesh::Mesh& level, const mesh::Mesh& source);

}  // namespace lodestream::scene
