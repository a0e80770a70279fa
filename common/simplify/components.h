// The connected parts of what is left of a surface. Merging never joins two, so a position's part is fixed.
#pragma once

#include <cstdint>
#include <vector>

#include "common/simplify/surface.h"

namespace lodestream::simplify {

struct Components {
    std::vector<std::uint32_t> of_position;  // `none` where there is no face
    std::vector<std::uint32_t> first_face;   // of each part, into faces; one more than parts
    std::vector<std::uint32_t> faces;
    std::vector<std::uint32_t> live;           // of each part: its faces
    std::vector<double> visibility;            // of each part: what dropping it costs
    std::vector<std::uint32_t> by_visibility;  // parts, least visible first
};

Components find_components(const Surface& surface);

}  // namespace lodestream::simplify
