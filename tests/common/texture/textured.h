// A square of two triangles that shows one image.
#pragma once

#include <cmath>

#include "common/image/codec.h"
#include "common/mesh/mesh.h"

namespace lodestream::texture {

// Fine coloured noise, which no format packs well; opaque unless told otherwise.
inline image::Pixels noise(std::uint32_t width, std::uint32_t height, std::uint8_t alpha = 255) {
    image::Pixels pixels{width, height, {}};
    std::uint32_t state = 1;
    for (std::size_t i = 0; i < pixels.pixels() * 4; ++i) {
        state = state * 1'664'525u + 1'013'904'223u;
        pixels.rgba.push_back(i % 4 == 3 ? alpha : static_cast<std::uint8_t>(state >> 24));
    }
    return pixels;
}

inline mesh::Image png_of(const image::Pixels& pixels) {
    return {"image/png", *image::encode_png(pixels), pixels.width, pixels.height};
}
inline mesh::Image jpeg_of(const image::Pixels& pixels) {
    return {"image/jpeg", *image::encode_jpeg(pixels, 90), pixels.width, pixels.height};
}

// Side 1 in the xz plane, the image once across it; material 0 shows image 0.
inline mesh::Model square_with(mesh::Image image) {
    mesh::Model model;
    model.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 0, 1}};
    model.mesh.normals.assign(4, {0, 1, 0});
    model.mesh.texture_coordinates = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    model.mesh.triangles = {{0, 2, 1}, {1, 2, 3}};
    model.materials.resize(1);
    model.materials[0].base_color_texture.image = 0;
    model.images = {std::move(image)};
    return model;
}

}  // namespace lodestream::texture
