#include "server/bake/scene_colors.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/base/srgb.h"
#include "common/image/codec.h"
#include "common/image/resample.h"
#include "common/mesh/nearest.h"
#include "common/mesh/operations.h"
#include "server/bake/seen_surface.h"

namespace lodestream::bake {

namespace {

constexpr int jpeg_quality = 85;
constexpr double hint_slack = 1.0 + 1e-6;
constexpr std::size_t directions = 32;  // all around
constexpr double least_cosine = 0.1;    // of a direction to the surface's normal: what is seen flatter hardly counts
constexpr double own_distance = 1e-4;   // of the scene's diagonal; nearer, a surface does not hide itself

std::array<Vec3d, 3> corners_of(const mesh::Mesh& mesh, std::size_t triangle) {
    const mesh::Triangle& t = mesh.triangles[triangle];
    return {Vec3d(mesh.positions[t[0]]), Vec3d(mesh.positions[t[1]]), Vec3d(mesh.positions[t[2]])};
}

Vec3d place_of(const mesh::Mesh& mesh, const scene::Texel& texel) {
    const auto [a, b, c] = corners_of(mesh, texel.triangle);
    const Vec3d w(texel.weights);
    return w.x * a + w.y * b + w.z * c;
}

// Evenly around, along a spiral that turns by the golden angle.
std::array<Vec3d, directions> directions_around() {
    constexpr double golden_angle = std::numbers::pi * (3.0 - 2.2360679774997896964);
    std::array<Vec3d, directions> all{};
    for (std::size_t k = 0; k < directions; ++k) {
        const auto i = static_cast<double>(k);
        const double height = 1.0 - (2.0 * i + 1.0) / directions, around = std::sqrt(1.0 - height * height);
        all[k] = {around * std::cos(golden_angle * i), height, around * std::sin(golden_angle * i)};
    }
    return all;
}

// As a display is told of it, from 0 to 1 in each channel: equal steps look alike.
Vec3d shown(const Rgba8& color) {
    const auto channel = [&](int k) { return srgb_of_light(color[k] / 255.0); };
    return {channel(0), channel(1), channel(2)};
}

// What is seen from one direction, and how much of a picture from there it takes.
struct Sight {
    Rgba8 color;
    double weight;
};

// Of the colours seen the one that is least off them all in the mean. pre: there are some, of positive weight
Rgba8 most_alike(const std::vector<Sight>& sights) {
    Vec3d mean(0.0);
    double weight = 0.0;
    for (const Sight& sight : sights) {
        mean += sight.weight * shown(sight.color);
        weight += sight.weight;
    }
    mean /= weight;
    const Sight* best = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const Sight& sight : sights)
        if (const double off = distance(shown(sight.color), mean); off < least) {
            least = off;
            best = &sight;
        }
    return best->color;
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

SceneColors::Texels SceneColors::nearest_colors(const scene::Atlas& atlas) const {
    Texels texels(atlas.texels.size());
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
        const auto [a, b, c] = corners_of(seen_, t);
        texels[i] = colors_.at(t, Vec3f(mesh::nearest_weights(place, a, b, c)));
        before = std::sqrt(hit.squared_distance);
        last = place;
    }
    return texels;
}

void SceneColors::take_seen_colors(const scene::Atlas& atlas, Texels& texels) const {
    static const std::array<Vec3d, directions> all_around = directions_around();
    const metric::TriangleTree own(atlas.mesh);
    const double size = mesh::bounds(seen_).diagonal() + mesh::bounds(atlas.mesh).diagonal();
    std::vector<Sight> sights;
    for (std::size_t i = 0; i < texels.size(); ++i) {
        if (atlas.texels[i].triangle == scene::Texel::nothing) continue;
        const Vec3d place = place_of(atlas.mesh, atlas.texels[i]);
        const auto [a, b, c] = corners_of(atlas.mesh, atlas.texels[i].triangle);
        const Vec3d normal = cross(b - a, c - a) / length(cross(b - a, c - a));
        sights.clear();
        for (const Vec3d& direction : all_around) {
            const double cosine = dot(normal, direction);
            if (!(cosine > least_cosine)) continue;
            if (own.first_along(place, direction, own_distance * size, size).triangle !=
                metric::TriangleTree::no_triangle)
                continue;
            const auto seen = tree_.first_along(place + size * direction, -direction, 0.0, 2.0 * size);
            if (seen.triangle == metric::TriangleTree::no_triangle) continue;
            sights.push_back({colors_.at(tree_.order()[seen.triangle], Vec3f(seen.weights)), cosine});
        }
        if (!sights.empty()) texels[i] = most_alike(sights);
    }
}

template <class Colors>
Result<mesh::Model> SceneColors::paint(const mesh::Mesh& surface, std::uint64_t texels_a_triangle,
                                       Colors colors) const {
    mesh::Model painted;
    mesh::Material& material = painted.materials.emplace_back();
    material.name = painted_name;
    const mesh::Mesh shaded = mesh::with_normals(bare(surface), level_crease_degrees);
    if (const std::optional<Vec4f> color = colors_.constant()) {
        painted.mesh = shaded;
        material.base_color = *color;
        return painted;
    }
    scene::Atlas atlas = scene::unfold(shaded, texels_a_triangle * shaded.triangles.size());
    Texels texels = colors(atlas);
    spread(texels, atlas.width);
    Result<mesh::Image> image = encode(pixels_of(texels, atlas.width));
    if (!image) return image.error();
    painted.mesh = std::move(atlas.mesh);
    painted.images.push_back(*std::move(image));
    material.base_color_texture.image = 0;
    material.base_color_texture.wrap_s = material.base_color_texture.wrap_t = mesh::Wrap::clamp_to_edge;
    return painted;
}

Result<mesh::Model> SceneColors::paint(const mesh::Mesh& surface) const {
    return paint(surface, texels_per_triangle, [&](const scene::Atlas& atlas) { return nearest_colors(atlas); });
}

Result<mesh::Model> SceneColors::paint_as_seen(const mesh::Mesh& surface) const {
    if (surface.triangles.size() > max_seen_triangles) return paint(surface);
    return paint(surface, seen_texels_per_triangle, [&](const scene::Atlas& atlas) {
        Texels texels = nearest_colors(atlas);
        take_seen_colors(atlas, texels);
        return texels;
    });
}

}  // namespace lodestream::bake
