// What a frame costs on this device, from pictures that were timed; and what a level's picture has in it.
#pragma once

#include <span>

#include "common/budget/budget.h"
#include "common/codec/level_codec.h"
#include "common/control/frame_time_model.h"
#include "common/shading/view.h"

namespace lodestream::probe {

struct TimedPicture {
    control::Work work;
    double ms = 0.0;  // > 0
};

// The fixed cost and those of triangles, vertices, the picture's, shaded and textured pixels, and of extent
// that come closest to all pictures: least squares of relative errors, none below 0. Costs that no picture asks for are
// 0; what uploading and decoding take is not told (frame_time_model.h's guess). Finite for any pictures.
control::FrameCosts fit_costs(std::span<const TimedPicture> pictures);

// What drawing this takes in a picture of that size. pre: as render::Renderer::upload()
control::Work work_of(const codec::Decoded& content, const shading::View& view, const budget::Display& display);

}  // namespace lodestream::probe
