// What of a PNG makes its pixels.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lodestream::image {

// A PNG without its text, times, colour profiles, pixel sizes and animation: header, palette, transparency and pixels
// as they are. glTF 2.0 (3.8.3) has readers ignore colour profiles, and its validator warns of them. Any other bytes,
// and a PNG whose chunks do not add up, come back unchanged.
std::vector<std::byte> pixels_only(std::span<const std::byte> bytes);

}  // namespace lodestream::image
