// Smaller pictures by averaging whole areas, as light adds up.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/result.h"
#include "common/image/codec.h"

namespace lodestream::image {

// What an image's numbers mean, which decides how they may be averaged.
enum class Content {
    color,              // sRGB, averaged as linear light; alpha is one more number, or of no meaning
    color_under_alpha,  // the same, each pixel counting by its alpha: what is invisible lends no colour to what is not
    data                // linear numbers (roughness, occlusion)
};

// Pixels to be made smaller again and again without rounding in between: linear, colour multiplied by alpha where
// Content says that it counts by it.
struct LinearPixels {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> rgba;  // 4 * width * height, each in [0,1]
};

// Exact area averages: every target pixel is the mean of the part of the source under it, whole or not.
// pre: is_consistent(source), 1 <= width <= source.width, 1 <= height <= source.height
LinearPixels shrink(const Pixels& source, Content content, std::uint32_t width, std::uint32_t height);
LinearPixels shrink(const LinearPixels& source, std::uint32_t width, std::uint32_t height);

// Rounded to the nearest 8-bit step. Where no alpha is left under Content::color_under_alpha colour is black.
Pixels to_pixels(const LinearPixels& source, Content content);

}  // namespace lodestream::image
