// What triangles amount to on the screen, hidden ones included: what a rasterizer has to walk over, and so what a frame
// costs beside their number.
#pragma once

#include "common/budget/budget.h"
#include "common/mesh/mesh.h"
#include "common/shading/view.h"

namespace lodestream::shading {

struct ScreenExtent {
    double covered_px = 0.0;  // sum of their areas within the picture
    double extent_px = 0.0;   // sum of the sides of squares as large as their bounding rectangles, likewise
};

// A triangle that reaches behind the eye counts by its corners in front of it. Finite and never negative for any finite
// positions. pre: validate(view) succeeded
ScreenExtent screen_extent(const mesh::Mesh& mesh, const Vec3d& origin, const View& view,
                           const budget::Display& display);

}  // namespace lodestream::shading
