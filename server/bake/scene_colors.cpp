#include "server/bake/scene_colors.h"

#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "common/image/codec.h"
#include "common/image/resample.h"
#include "common/mesh/nearest.h"
#include "common/mesh/operations.h"
#include "common/scene/atlas.h"
#include "server/bake/seen_surface.h"

namespace lodestream::bake {

namespace {

constexpr int jpeg_quality = 85;
constexpr double hint_slack = 1.0 + 1e-6;

Vec3d place_of(const mesh::Mesh& mesh, const scene::Texel& texel) {
    const mesh::Triangle& t = mesh.triangles[texel.triangle];
    const Vec3d w(texel.weights);
    return w.x * Vec3d(mesh.positions[t[0]]) + w.y * Vec3d(mesh.positions[t[1]]) + w.z * Vec3d(mesh.positions[t[2]]);
}

// Gives every texel without a colour that of one of the nearest that have some.
void spread(std::vector<std::optional<Rgba8>>& texels, std::uint32_t width) {
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < texels.size(); ++i)
        if (texels[i]) open.push_back(i);
    for (std::size_t k = 0; k < open.size(); ++k) {
        const std::size_t i = open[k], x = i % width;
        const auto give = [&](bool is_there, std::size_t to) {
            if (!is_there || texels[to]) return;
            texels[to] = texels[i];
            open.push_back(to);
        };
        give(x > 0, i - 1);
        give(x + 1 < width, i + 1);
        give(i >= width, i - width);
        give(i + width < texels.size(), i + width);
    }
}

image::Pixels pixels_of(const std::vector<std::optional<Rgba8>>& texels, std::uint32_t width) {
    image::LinearPixels linear{width, static_cast<std::uint32_t>(texels.size() / width), {}};
    for (const std::optional<Rgba8>& texel : texels)
        for (int k = 0; k < 4; ++k) linear.rgba.push_back(static_cast<float>((*texel)[k]) / 255.0f);
    return image::to_pixels(linear, image::Content::color);
}

// Lossless where that is no larger.
Result<mesh::Image> encode(const image::Pixels& pixels) {
    Result<std::vector<std::byte>> png = image::encode_small_png(pixels);
    if (!png) return png.error();
    Result<std::vector<std::byte>> jpeg = image::encode_jpeg(pixels, jpeg_quality);
    if (!jpeg) return jpeg.error();
    const bool is_lossless = png->size() <= jpeg->size();
    mesh::Image image;
    image.media_type = image::media_type(is_lossless ? image::Format::png : image::Format::jpeg);
    image.bytes = is_lossless ? *std::move(png) : *std::move(jpeg);
    image.width = pixels.width;
    image.height = pixels.height;
    return image;
}

}  // namespace

SceneColors::SceneColors(const mesh::Model& model, mesh::Mesh seen)
    : seen_(std::move(seen)), colors_(model, seen_), tree_(seen_) {}

Result<mesh::Model> SceneColors::paint(const mesh::Mesh& surface) const {
    mesh::Model painted;
    mesh::Material& material = painted.materials.emplace_back();
    material.name = painted_name;
    const mesh::Mesh shaded = mesh::with_normals(bare(surface), level_crease_degrees);
    if (const std::optional<Vec4f> color = colors_.constant()) {
        painted.mesh = shaded;
        material.base_color = *color;
        return painted;
    }
    scene::Atlas atlas = scene::unfold(shaded, texels_per_triangle * shaded.triangles.size());
    std::vector<std::optional<Rgba8>> texels(atlas.texels.size());
    double before = std::numeric_limits<double>::infinity();
    Vec3d last(0.0);
    for (std::size_t i = 0; i < texels.size(); ++i) {
        if (atlas.texels[i].triangle == scene::Texel::nothing) continue;
        const Vec3d place = place_of(atlas.mesh, atlas.texels[i]);
        const double bound = (before + distance(place, last)) * hint_slack;
        metric::TriangleTree::Hit hit = tree_.nearest(place, bound * bound);
        if (hit.triangle == metric::TriangleTree::no_triangle)
            hit = tree_.nearest(place, std::numeric_limits<double>::infinity());
        const std::uint32_t t = tree_.order()[hit.triangle];
        const auto corner = [&](std::size_t k) { return Vec3d(seen_.positions[seen_.triangles[t][k]]); };
        texels[i] = colors_.at(t, Vec3f(mesh::nearest_weights(place, corner(0), corner(1), corner(2))));
        before = std::sqrt(hit.squared_distance);
        last = place;
    }
    spread(texels, atlas.width);
    Result<mesh::Image> image = encode(pixels_of(texels, atlas.width));
    if (!image) return image.error();
    painted.mesh = std::move(atlas.mesh);
    painted.images.push_back(*std::move(image));
    material.base_color_texture.image = 0;
    material.base_color_texture.wrap_s = material.base_color_texture.wrap_t = mesh::Wrap::clamp_to_edge;
    return painted;
}

}  // namespace lodestream::bake
