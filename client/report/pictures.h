// Small pictures from large ones.
#pragma once

#include <span>

#include "client/render/image.h"

namespace lodestream::report {

// Scaled down to `width` px, keeping its shape, each pixel the mean of those that it covers; as it is where not wider.
render::Image scaled_down(const render::Image& image, std::uint32_t width);

// Below each other, left sides aligned, on white, `gap_px` apart.
render::Image stacked(std::span<const render::Image> images, std::uint32_t gap_px = 8);

}  // namespace lodestream::report
