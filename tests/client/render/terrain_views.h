// Views of a terrain and the cracks in them: whatever is below the horizon shows ground.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

#include "client/render/image.h"
#include "client/render/renderer.h"
#include "common/base/math.h"
#include "common/shading/view.h"

namespace lodestream::render {

// A small picture in front of a colour that hills never are, 120 degrees across.
DrawOptions terrain_picture();

// From 10 to 1,000 m above the ground: heading in +-180, pitch in +-90 degrees.
shading::View any_terrain_view(const Vec3d& ground, std::mt19937& random);

// Pixels of background through which one looks at the ground: the line of sight comes down to the lowest ground within
// the terrain, but for a border where a level need not reach as far as the terrain, so it must have met the surface
// before.
std::size_t cracks(const Image& image, const shading::View& view, const Box& bounds);

// Whether the middle of the picture's lowest row shows ground.
bool looks_at_ground(const Image& image);

}  // namespace lodestream::render
