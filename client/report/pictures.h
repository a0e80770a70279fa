// Small pictures from large ones.
#pragma once

#include <span>

#include "client/render/image.h"

namespace lodestream::report {

// Pixels [left, right) × [top, bottom).
struct Rectangle {
    std::uint32_t left = 0, top = 0, right = 0, bottom = 0;
};

// Around what any of the pictures shows, with a margin of `margin_px`; the background is a picture's upper left pixel.
// The whole picture where they show nothing. pre: all of one size
Rectangle shown_part(std::span<const render::Image> images, std::uint32_t margin_px);

// pre: part lies within the image
render::Image cropped(const render::Image& image, const Rectangle& part);

// Scaled down to `width` px, keeping its shape, each pixel the mean of those that it covers; as it is where not wider.
render::Image scaled_down(const render::Image& image, std::uint32_t width);

// Below each other, left sides aligned, on white, `gap_px` apart.
render::Image stacked(std::span<const render::Image> images, std::uint32_t gap_px = 8);

}  // namespace lodestream::report
