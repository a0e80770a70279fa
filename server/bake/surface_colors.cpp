#include "server/bake/surface_colors.h"

#include <algorithm>
#include <cmath>

#include "common/base/srgb.h"

namespace lodestream::bake {

namespace {

float linear(std::uint8_t srgb) {
    return static_cast<float>(light_of_srgb(srgb / 255.0));
}

// The texel that shows at a coordinate, of `size`.
std::size_t texel_at(float coordinate, mesh::Wrap wrap, std::uint32_t size) {
    double place = std::isfinite(coordinate) ? coordinate : 0.0;
    if (wrap == mesh::Wrap::mirrored_repeat) place = 1.0 - std::abs(std::fmod(std::abs(place), 2.0) - 1.0);
    if (wrap == mesh::Wrap::repeat) place -= std::floor(place);
    return static_cast<std::size_t>(std::clamp(place * size, 0.0, size - 1.0));
}

}  // namespace

SurfaceColors::SurfaceColors(const mesh::Model& model, const mesh::Mesh& mesh) : model_(model), mesh_(mesh) {
    Images images(model.images.size());
    for (const mesh::Material& material : model.materials) {
        const int image = material.base_color_texture.image;
        if (mesh.texture_coordinates.empty() || image < 0 || !images[static_cast<std::size_t>(image)].rgba.empty())
            continue;
        Result<image::Pixels> pixels = image::decode(model.images[static_cast<std::size_t>(image)].bytes);
        if (pixels) images[static_cast<std::size_t>(image)] = *std::move(pixels);
    }
    images_ = std::make_shared<const Images>(std::move(images));
}

SurfaceColors SurfaceColors::on(const mesh::Mesh& mesh) const {
    return {model_, mesh, images_};
}

std::optional<Vec4f> SurfaceColors::constant() const {
    if (!mesh_.colors.empty() || mesh_.triangles.empty()) return std::nullopt;
    const mesh::Material& first = model_.materials[material_of(mesh_, 0)];
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        const mesh::Material& material = model_.materials[material_of(mesh_, t)];
        const int image = material.base_color_texture.image;
        const bool is_textured = image >= 0 && !(*images_)[static_cast<std::size_t>(image)].rgba.empty();
        if (is_textured || material.base_color != first.base_color) return std::nullopt;
    }
    return first.base_color;
}

Vec4f SurfaceColors::texel(const mesh::TextureReference& texture, const Vec2f& place) const {
    const image::Pixels& image = (*images_)[static_cast<std::size_t>(texture.image)];
    if (image.rgba.empty()) return Vec4f(1.0f);
    const std::size_t x = texel_at(place.x, texture.wrap_s, image.width);
    const std::size_t y = texel_at(place.y, texture.wrap_t, image.height);
    const std::uint8_t* rgba = image.rgba.data() + 4 * (y * image.width + x);
    return {linear(rgba[0]), linear(rgba[1]), linear(rgba[2]), static_cast<float>(rgba[3]) / 255.0f};
}

Rgba8 SurfaceColors::at(std::size_t triangle, const Vec3f& weights) const {
    const mesh::Triangle& t = mesh_.triangles[triangle];
    const mesh::Material& material = model_.materials[material_of(mesh_, triangle)];
    Vec4f color = material.base_color;
    const auto blend = [&](const auto& values) {
        return weights.x * values[t[0]] + weights.y * values[t[1]] + weights.z * values[t[2]];
    };
    if (!mesh_.colors.empty()) {
        const auto corner = [&](int k) { return Vec4f(mesh_.colors[t[static_cast<std::size_t>(k)]]) / 255.0f; };
        color *= weights.x * corner(0) + weights.y * corner(1) + weights.z * corner(2);
    }
    if (material.base_color_texture.image >= 0 && !mesh_.texture_coordinates.empty())
        color *= texel(material.base_color_texture, blend(mesh_.texture_coordinates));
    return Rgba8(clamp(color, Vec4f(0.0f), Vec4f(1.0f)) * 255.0f + 0.5f);
}

}  // namespace lodestream::bake
