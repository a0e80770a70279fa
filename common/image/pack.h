// Rectangles side by side in one picture.
#pragma once

#include <cstdint>
#include <vector>

namespace lodestream::image {

struct Rectangle {
    std::uint32_t width = 0, height = 0;  // px, >= 1
    std::uint32_t x = 0, y = 0;           // where it was put
};

struct PackedSize {
    std::uint32_t width = 0, height = 0;  // px
};

// Puts each where it overlaps no other; the picture is as small as a few widths allow. The same places for the same
// sizes.
PackedSize pack(std::vector<Rectangle>& rectangles);

}  // namespace lodestream::image
