#include "server/importer/gltf_material.h"

#include <cmath>

#include "server/importer/images.h"

namespace lodestream::importer {

struct GltfMaterials::Slot {
    mesh::TextureReference* to;
    int texture;
    int set;
    const tinygltf::ExtensionMap* extensions;
};

namespace {

constexpr int wrap_clamp = 33071, wrap_mirror = 33648;

mesh::Wrap wrap_of(int mode) {
    return mode == wrap_clamp    ? mesh::Wrap::clamp_to_edge
           : mode == wrap_mirror ? mesh::Wrap::mirrored_repeat
                                 : mesh::Wrap::repeat;
}

float clamped(double v) {
    return v >= 0 ? static_cast<float>(std::min(v, 1.0)) : 0.0f;
}

float clamped_at(const std::vector<double>& numbers, std::size_t i, float otherwise) {
    return i < numbers.size() ? clamped(numbers[i]) : otherwise;
}

double number_at(const tinygltf::Value& object, const char* key, int i, double otherwise) {
    if (!object.Has(key)) return otherwise;
    const tinygltf::Value& list = object.Get(key);
    if (!list.IsArray() || list.ArrayLen() <= static_cast<std::size_t>(i) || !list.Get(i).IsNumber()) return otherwise;
    return list.Get(i).GetNumberAsDouble();
}

GltfTextureCoordinates coordinates_of(int set, const tinygltf::ExtensionMap& extensions) {
    GltfTextureCoordinates c;
    c.set = set;
    const auto extension = extensions.find("KHR_texture_transform");
    if (extension == extensions.end()) return c;
    const tinygltf::Value& transform = extension->second;
    for (int i = 0; i < 2; ++i) {
        c.offset[i] = number_at(transform, "offset", i, 0);
        c.scale[i] = number_at(transform, "scale", i, 1);
    }
    if (transform.Has("rotation") && transform.Get("rotation").IsNumber())
        c.rotation = transform.Get("rotation").GetNumberAsDouble();
    if (transform.Has("texCoord") && transform.Get("texCoord").IsInt())
        c.set = transform.Get("texCoord").GetNumberAsInt();
    return c;
}

mesh::Material factors_of(const tinygltf::Material& from) {
    mesh::Material to;
    const auto& pbr = from.pbrMetallicRoughness;
    to.name = from.name;
    for (int i = 0; i < 4; ++i) to.base_color[i] = clamped_at(pbr.baseColorFactor, static_cast<std::size_t>(i), 1.0f);
    for (int i = 0; i < 3; ++i) to.emissive[i] = clamped_at(from.emissiveFactor, static_cast<std::size_t>(i), 0.0f);
    to.metallic = clamped(pbr.metallicFactor);
    to.roughness = clamped(pbr.roughnessFactor);
    to.alpha_mode = from.alphaMode == "BLEND"  ? mesh::AlphaMode::blend
                    : from.alphaMode == "MASK" ? mesh::AlphaMode::mask
                                               : mesh::AlphaMode::opaque;
    to.alpha_cutoff = clamped(from.alphaCutoff);
    to.double_sided = from.doubleSided;
    return to;
}

}  // namespace

Vec2f GltfTextureCoordinates::applied(float u, float v) const {
    const double x = u * scale[0], y = v * scale[1];
    const double c = std::cos(rotation), s = std::sin(rotation);
    return Vec2f(glm::dvec2{c * x + s * y + offset[0], c * y - s * x + offset[1]});
}

GltfMaterials::GltfMaterials(const GltfDocument& document, GltfAccessors& accessors, const Source& source, Soup& soup)
    : document_(document), accessors_(accessors), source_(source), soup_(soup) {
    soup_.materials.emplace_back();
    used_[-1] = {};
}

Result<GltfMaterialUse> GltfMaterials::use(int material) {
    const auto known = used_.find(material);
    if (known != used_.end()) return known->second;
    if (material < 0 || static_cast<std::size_t>(material) >= document_.json.materials.size())
        return invalid_input("material " + std::to_string(material) + " does not exist");
    return used_[material] = convert(document_.json.materials[static_cast<std::size_t>(material)]);
}

int GltfMaterials::image(int index) {
    const auto [known, is_new] = images_.try_emplace(index, -1);
    if (!is_new || index < 0 || static_cast<std::size_t>(index) >= document_.images.size()) return known->second;
    const GltfImage& from = document_.images[static_cast<std::size_t>(index)];
    if (!from.uri.empty()) return known->second = add_image_file(from.uri, source_.side_files, source_.limits, soup_);
    std::span<const std::byte> bytes = from.bytes;
    if (from.buffer_view >= 0)
        if (const Result<std::span<const std::byte>> view = accessors_.view(from.buffer_view)) bytes = *view;
    return known->second = add_image(bytes, from.label, source_.limits, soup_);
}

mesh::TextureReference GltfMaterials::texture(int index) {
    const tinygltf::Model& json = document_.json;
    if (index < 0) return {};
    if (static_cast<std::size_t>(index) >= json.textures.size()) {
        soup_.warn("texture " + std::to_string(index) + " does not exist");
        return {};
    }
    const tinygltf::Texture& from = json.textures[static_cast<std::size_t>(index)];
    mesh::TextureReference to;
    to.image = image(from.source);
    if (from.source < 0) soup_.warn("texture " + std::to_string(index) + " dropped: it has neither PNG nor JPEG");
    if (from.sampler >= 0 && static_cast<std::size_t>(from.sampler) < json.samplers.size()) {
        to.wrap_s = wrap_of(json.samplers[static_cast<std::size_t>(from.sampler)].wrapS);
        to.wrap_t = wrap_of(json.samplers[static_cast<std::size_t>(from.sampler)].wrapT);
    }
    return to;
}

// The mesh keeps one set of coordinates, so the first texture decides and others that sample elsewhere go.
GltfMaterialUse GltfMaterials::convert(const tinygltf::Material& from) {
    mesh::Material to = factors_of(from);
    const auto& pbr = from.pbrMetallicRoughness;
    const Slot slots[] = {
        {&to.base_color_texture, pbr.baseColorTexture.index, pbr.baseColorTexture.texCoord,
         &pbr.baseColorTexture.extensions},
        {&to.metallic_roughness_texture, pbr.metallicRoughnessTexture.index, pbr.metallicRoughnessTexture.texCoord,
         &pbr.metallicRoughnessTexture.extensions},
        {&to.occlusion_texture, from.occlusionTexture.index, from.occlusionTexture.texCoord,
         &from.occlusionTexture.extensions},
        {&to.emissive_texture, from.emissiveTexture.index, from.emissiveTexture.texCoord,
         &from.emissiveTexture.extensions},
    };
    GltfMaterialUse use;
    bool any = false;
    for (const Slot& slot : slots) {
        const mesh::TextureReference reference = texture(slot.texture);
        if (reference.image < 0) continue;
        const GltfTextureCoordinates coordinates = coordinates_of(slot.set, *slot.extensions);
        if (!any) use.coordinates = coordinates;
        any = true;
        if (coordinates == use.coordinates)
            *slot.to = reference;
        else
            soup_.warn("material \"" + from.name + "\": a texture with its own coordinates dropped");
    }
    use.material = static_cast<std::uint32_t>(soup_.materials.size());
    soup_.materials.push_back(std::move(to));
    return use;
}

}  // namespace lodestream::importer
