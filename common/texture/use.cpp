#include "common/texture/use.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/mesh/operations.h"

namespace lodestream::texture {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::array<int, 4> images_of(const mesh::Material& m) {
    return {m.base_color_texture.image, m.metallic_roughness_texture.image, m.occlusion_texture.image,
            m.emissive_texture.image};
}

bool exists(int image, const mesh::Model& model) {
    return image >= 0 && static_cast<std::size_t>(image) < model.images.size();
}

std::vector<bool> used_materials(const mesh::Model& model) {
    std::vector<bool> used(model.materials.size(), false);
    if (model.mesh.texture_coordinates.empty()) return used;
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) used[mesh::material_of(model.mesh, t)] = true;
    return used;
}

void add_use(ImageUse& use, image::Content content) {
    use.is_used = true;
    use.reads_alpha = use.reads_alpha || content == image::Content::color_under_alpha;
    if (use.content == image::Content::data || content == image::Content::color_under_alpha) use.content = content;
}

// One triangle's map from texels to the surface, as the longer axis of the ellipse that a texel's circle becomes.
struct TexelMap {
    Vec3d edge_1, edge_2;   // model units
    double u1, v1, u2, v2;  // the same edges in the image, [0,1] across it

    double longest(const mesh::Image& image) const {
        const double determinant = u1 * v2 - u2 * v1;
        if (determinant == 0.0 || !std::isfinite(determinant)) return infinity;
        const Vec3d along_u = (edge_1 * v2 - edge_2 * v1) / (determinant * std::max<double>(image.width, 1));
        const Vec3d along_v = (edge_2 * u1 - edge_1 * u2) / (determinant * std::max<double>(image.height, 1));
        const double e = dot(along_u, along_u), f = dot(along_u, along_v), g = dot(along_v, along_v);
        const double longest = std::sqrt(0.5 * (e + g + std::hypot(e - g, 2.0 * f)));
        return std::isfinite(longest) ? longest : infinity;
    }
};

TexelMap texel_map(const mesh::Mesh& mesh, const mesh::Triangle& t) {
    const std::vector<Vec3f>& p = mesh.positions;
    const Vec2f &a = mesh.texture_coordinates[t[0]], &b = mesh.texture_coordinates[t[1]],
                &c = mesh.texture_coordinates[t[2]];
    return {Vec3d(p[t[1]]) - Vec3d(p[t[0]]),
            Vec3d(p[t[2]]) - Vec3d(p[t[0]]),
            double{b.x} - a.x,
            double{b.y} - a.y,
            double{c.x} - a.x,
            double{c.y} - a.y};
}

struct Sample {
    double texel_size;
    double area;
};

double quantile(std::vector<Sample>& samples) {
    std::sort(samples.begin(), samples.end(), [](const auto& a, const auto& b) { return a.texel_size < b.texel_size; });
    double all = 0.0, sum = 0.0;
    for (const Sample& sample : samples) all += sample.area;
    for (const Sample& sample : samples)
        if ((sum += sample.area) >= counted_share_of_area * all) return sample.texel_size;
    return infinity;
}

}  // namespace

std::vector<ImageUse> image_uses(const mesh::Model& model) {
    std::vector<ImageUse> uses(model.images.size());
    const std::vector<bool> used = used_materials(model);
    for (std::size_t i = 0; i < model.materials.size(); ++i) {
        if (!used[i]) continue;
        const mesh::Material& m = model.materials[i];
        const auto add = [&](const mesh::TextureReference& texture, image::Content content) {
            if (exists(texture.image, model)) add_use(uses[static_cast<std::size_t>(texture.image)], content);
        };
        add(m.base_color_texture,
            m.alpha_mode == mesh::AlphaMode::opaque ? image::Content::color : image::Content::color_under_alpha);
        add(m.emissive_texture, image::Content::color);
        add(m.metallic_roughness_texture, image::Content::data);
        add(m.occlusion_texture, image::Content::data);
    }
    return uses;
}

std::vector<double> texel_sizes(const mesh::Model& model) {
    std::vector<double> sizes(model.images.size(), infinity);
    const mesh::Mesh& m = model.mesh;
    if (model.images.empty() || m.texture_coordinates.empty()) return sizes;
    std::vector<std::vector<Sample>> samples(model.images.size());
    for (std::size_t t = 0; t < m.triangles.size(); ++t) {
        const mesh::Triangle& corners = m.triangles[t];
        const TexelMap map = texel_map(m, corners);
        const double area = mesh::face_area(m.positions[corners[0]], m.positions[corners[1]], m.positions[corners[2]]);
        std::array<int, 4> images = images_of(model.materials[mesh::material_of(m, t)]);
        std::sort(images.begin(), images.end());
        for (std::size_t i = 0; i < images.size(); ++i) {
            if (!exists(images[i], model) || (i > 0 && images[i] == images[i - 1])) continue;
            const auto image = static_cast<std::size_t>(images[i]);
            samples[image].push_back({map.longest(model.images[image]), area});
        }
    }
    for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = quantile(samples[i]);
    return sizes;
}

}  // namespace lodestream::texture
