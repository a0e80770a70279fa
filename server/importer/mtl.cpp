#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "server/importer/formats.h"
#include "server/importer/images.h"
#include "server/importer/text_cursor.h"

namespace lodestream::importer {
namespace {

std::string with_slashes(std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    return name;
}

float clamped(float v) {
    return v >= 0 ? std::min(v, 1.0f) : 0.0f;
}

Vec3f color(const tinyobj::real_t (&srgb)[3]) {
    return {linear_from_srgb(clamped(srgb[0])), linear_from_srgb(clamped(srgb[1])), linear_from_srgb(clamped(srgb[2]))};
}

class TextureFiles {
  public:
    TextureFiles(const Source& source, Soup& soup) : source_(source), soup_(soup) {}

    mesh::TextureReference find(const std::string& name, const tinyobj::texture_option_t& option) {
        if (name.empty()) return {};
        auto [known, is_new] = images_.try_emplace(with_slashes(name), -1);
        if (is_new) known->second = add_image_file(known->first, source_.side_files, source_.limits, soup_);
        const mesh::Wrap wrap = option.clamp ? mesh::Wrap::clamp_to_edge : mesh::Wrap::repeat;
        return {known->second, wrap, wrap};
    }

  private:
    const Source& source_;
    Soup& soup_;
    std::map<std::string, int> images_;
};

mesh::Material converted(const tinyobj::material_t& from, TextureFiles& textures) {
    mesh::Material to;
    to.name = TextCursor(from.name).rest_of_line();
    // A surface that nobody could see is a writer's mistake: some write `Tr 1` for opaque.
    to.base_color = Vec4f{color(from.diffuse), from.dissolve > 0 ? clamped(from.dissolve) : 1.0f};
    to.emissive = color(from.emission);
    to.base_color_texture = textures.find(from.diffuse_texname, from.diffuse_texopt);
    to.emissive_texture = textures.find(from.emissive_texname, from.emissive_texopt);
    // A black factor under a texture is a writer's default, not a wish to see nothing.
    if (to.base_color_texture.image >= 0 && Vec3f(to.base_color) == Vec3f{0})
        to.base_color = Vec4f{Vec3f{1}, to.base_color.w};
    if (to.emissive_texture.image >= 0 && to.emissive == Vec3f{0}) to.emissive = Vec3f{1};
    if (to.base_color.w < 1) to.alpha_mode = mesh::AlphaMode::blend;
    to.metallic = clamped(from.metallic);
    // The width of a Blinn-Phong lobe of this exponent as a roughness.
    if (from.roughness > 0)
        to.roughness = clamped(from.roughness);
    else if (from.shininess > 1)
        to.roughness = std::sqrt(2.0f / (from.shininess + 2.0f));
    return to;
}

}  // namespace

void read_mtl(const Source& source, const std::string& name, Soup& soup) {
    const Result<std::vector<std::byte>> bytes = source.side_files(with_slashes(name));
    if (!bytes) return soup.warn("material library left out: " + bytes.error().message);
    std::string lines(as_text(*bytes));
    std::replace(lines.begin(), lines.end(), '\r', '\n');
    std::istringstream text(lines);
    std::map<std::string, int> names;
    std::vector<tinyobj::material_t> materials;
    std::string warning, error;
    tinyobj::LoadMtl(&names, &materials, &text, &warning, &error);
    if (!error.empty()) soup.warn("material library \"" + name + "\" is damaged");
    TextureFiles textures(source, soup);
    for (const tinyobj::material_t& material : materials)
        if (!material.name.empty()) soup.materials.push_back(converted(material, textures));
}

}  // namespace lodestream::importer
