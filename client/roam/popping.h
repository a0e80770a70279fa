// What a change of levels shows: two pictures in one view, one of the levels before and one of those after it, so that
// nothing that the camera's motion changes counts.
#pragma once

#include "client/render/image.h"
#include "common/base/result.h"

namespace lodestream::roam {

// 8-bit steps, of the channel that changes most in a pixel.
struct Popping {
    double largest = 0.0;
    double p999 = 0.0;  // what one pixel of a thousand changes by or more
    double rms = 0.0;   // over all pixels
};

// Errors: invalid_input (sizes differ, or empty).
Result<Popping> popping_between(const render::Image& before, const render::Image& after);

}  // namespace lodestream::roam
