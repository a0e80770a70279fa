// How a model's images are used: by which materials, and how large a texel is on the surface.
#pragma once

#include <vector>

#include "common/image/resample.h"
#include "common/mesh/mesh.h"

namespace lodestream::texture {

struct ImageUse {
    bool is_used = false;  // by a material of a triangle that has texture coordinates
    image::Content content = image::Content::data;
    bool reads_alpha = false;  // as opacity
};

// One for each of model.images. An image read in several ways is averaged as colour, and under alpha where any way
// reads that.
std::vector<ImageUse> image_uses(const mesh::Model& model);

// Of the textured surface, the most stretched tenth does not count: it asks for no more than its neighbours get.
inline constexpr double counted_share_of_area = 0.9;

// For each of model.images how long a texel is on the surface: model units, along its longer axis; on nine tenths of
// the area texels are at most so long. Infinity where a larger part than the rest has no extent in the image (one texel
// colours a whole face) and for images that no triangle uses.
std::vector<double> texel_sizes(const mesh::Model& model);

}  // namespace lodestream::texture
