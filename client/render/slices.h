// The six orthographic views of the point-cloud paper (seeds-digest §3) by the GPU: each slice of each axis is drawn
// from both of its ends, as the paper does it. A triangle is drawn in the slices that it reaches into and nowhere else.
// points::resample() makes points of what is seen; without a GPU it draws the views itself.
#pragma once

#include <memory>
#include <vector>

#include "common/base/result.h"
#include "common/points/resample.h"

namespace lodestream::render {

// One context and thread, as the renderer.
class SliceRenderer {
  public:
    // Errors: unavailable (the current context is not OpenGL ES 3), internal (the shaders, with the driver's words).
    static Result<SliceRenderer> create();
    SliceRenderer(SliceRenderer&&) noexcept;
    SliceRenderer& operator=(SliceRenderer&&) noexcept;
    ~SliceRenderer();

    // A points::DrawSlices. Errors: limit_exceeded (more triangles than 32-bit indices name, a picture larger than the
    // driver draws, no memory).
    Result<std::vector<points::Seen>> draw(const points::SlicedView& view);

  private:
    struct Impl;
    explicit SliceRenderer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace lodestream::render
