// What triangles amount to on the screen: what a rasterizer has to walk over, what of it a fragment shader has to
// colour, and so what a frame costs beside their number.
#pragma once

#include <cstdint>
#include <vector>

#include "common/budget/budget.h"
#include "common/mesh/mesh.h"
#include "common/shading/view.h"

namespace lodestream::shading {

struct ScreenExtent {
    // Sum of their areas within the picture, but for what lay behind those drawn before: about, from a raster of
    // samples.
    double shaded_px = 0.0;
    // Sum of the sides of squares as large as their bounding rectangles, likewise, hidden ones included.
    double extent_px = 0.0;
};

// Of meshes in the order in which they are drawn: with a depth test, each is shaded where it lies before all before it.
class ScreenExtents {
  public:
    // pre: validate(view) succeeded
    ScreenExtents(const View& view, const budget::Display& display);

    // A triangle that reaches behind the eye counts by its corners in front of it, and hides nothing. Finite and never
    // negative for any finite positions.
    ScreenExtent draw(const mesh::Mesh& mesh, const Vec3d& origin);

  private:
    View view_;
    budget::Display display_;
    std::uint32_t width_ = 0, height_ = 0;  // of the raster
    std::vector<float> nearest_;            // 1 / depth of each sample; 0: nothing yet
};

}  // namespace lodestream::shading
