// Which size of each image goes with a level.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "common/codec/level_codec.h"
#include "common/mesh/mesh.h"
#include "common/texture/ladder.h"
#include "common/texture/use.h"

namespace lodestream::texture {

// Of what the network carries in the time given, the textures' share where the triangles need the rest.
inline constexpr double network_share = 0.5;

// What a choice has to know of a model.
struct Textures {
    Ladder ladder;
    std::vector<ImageUse> uses;
    std::vector<double> texel_sizes;
};
Textures textures_of(const mesh::Model& model, Ladder ladder);
Textures textures_of(Ladder ladder, std::vector<ImageUse> uses, std::vector<double> texel_sizes);

struct Needs {
    double pixel_size = 0.0;  // model units that a pixel of the display covers at the nearest; 0: every texel is wanted
    double max_bytes = std::numeric_limits<double>::infinity();  // of all images together, kept where sizes allow
};

struct Choice {
    std::vector<codec::SmallerImage> images;  // one for each of the model's; points into the ladder
    std::uint64_t bytes = 0;                  // of the images that the model's materials use
    std::string key;                          // names the choice; empty: every image as it is
};

// First halves each image while its texels stay within a pixel, then the image of the most bytes ever further until all
// fit in max_bytes or nothing can be halved. pre: `textures` are those of `model`
Choice choose(const mesh::Model& model, const Textures& textures, const Needs& needs);

}  // namespace lodestream::texture
