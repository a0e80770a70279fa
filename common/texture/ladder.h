// A texture ladder: each image of a model again with its sides halved, and halved again, encoded once.
// Texels below a pixel are left out by choosing among them (choice.h).
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/texture/use.h"

namespace lodestream::texture {

inline constexpr std::uint32_t min_side = 4;  // texels; a side as short as this or shorter stays
inline constexpr int jpeg_quality = 85;
inline constexpr int data_jpeg_quality = 95;  // numbers in colour channels: nothing is halved
inline constexpr double jpeg_over_png = 0.5;  // an opaque colour PNG becomes a JPEG of at most this share of its bytes

struct SmallerImage {
    int halvings = 0;  // of both sides, >= 1
    mesh::Image image;
};

// Of one image: more halvings and strictly fewer bytes from one to the next, the first with fewer than the image
// itself.
using Sizes = std::vector<SmallerImage>;
using Ladder = std::vector<Sizes>;  // one for each of a model's images; empty: it goes as it is

// JPEG stays JPEG; PNG stays PNG unless it is opaque colour and a JPEG is far smaller. Alpha that no material reads is
// dropped. Errors: those of image::decode.
Result<Sizes> smaller_sizes(const mesh::Image& image, const ImageUse& use);

// Texels of a model's images that are made smaller, together: small files can hold huge pictures.
inline constexpr std::uint64_t max_texels = 256ull << 20;

// Of every used image. One that cannot be decoded or goes beyond `texels_allowed` has no sizes, and a line in the
// result's warnings.
Result<Ladder> make_ladder(const mesh::Model& model, const std::vector<ImageUse>& uses,
                           std::uint64_t texels_allowed = max_texels);
inline Result<Ladder> make_ladder(const mesh::Model& model) {
    return make_ladder(model, image_uses(model));
}

}  // namespace lodestream::texture
