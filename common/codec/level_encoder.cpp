#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <tuple>

#include "common/codec/glb.h"
#include "common/codec/lean_shading.h"
#include "common/codec/level_codec.h"
#include "common/codec/plain_normals.h"
#include "common/codec/primitive_codec.h"
#include "common/codec/rounding.h"

namespace lodestream::codec {
namespace {

using mesh::Material;
using mesh::Mesh;
using mesh::Model;
using nlohmann::json;

constexpr double max_outside_grid = 1.0;  // grid ranges that a position may lie outside the grid
constexpr double float_rounding = 4.0 / (1 << 24);
constexpr int min_texture_coordinate_bits = 4;
constexpr double least_lean_tolerance_degrees = 0.1;

Status check_options(const EncodeOptions& options) {
    const QuantizationGrid& grid = options.grid;
    if (!all_finite(grid.origin) || !std::isfinite(grid.range) || grid.range <= 0.0f || grid.bits < min_position_bits ||
        grid.bits > max_position_bits)
        return invalid_input("encode: the quantization grid is not valid");
    if (options.normal_bits < 4 || options.normal_bits > 16 ||
        options.texture_coordinate_bits < min_texture_coordinate_bits || options.texture_coordinate_bits > 16)
        return invalid_input("encode: normals and texture coordinates take 4 to 16 bits");
    return Nothing{};
}

Status check_level(const Model& model, const Mesh& level, std::span<const std::uint8_t> gouraud) {
    const std::size_t vertices = level.positions.size();
    const auto complete = [&](std::size_t count) { return count == 0 || count == vertices; };
    if (level.triangles.size() > max_decoded_triangles || vertices > max_decoded_vertices)
        return fail(ErrorCode::limit_exceeded, "encode: the level has too many triangles or vertices");
    if (gouraud.size() != level.triangles.size()) return invalid_input("encode: not one shading a triangle");
    if (!complete(level.normals.size()) || !complete(level.texture_coordinates.size()) ||
        !complete(level.colors.size()))
        return invalid_input("encode: an attribute does not cover every vertex");
    if (!level.triangle_materials.empty() && level.triangle_materials.size() != level.triangles.size())
        return invalid_input("encode: not one material a triangle");
    if (!all_finite(model.origin)) return invalid_input("encode: the model's origin is not finite");
    for (std::size_t t = 0; t < level.triangles.size(); ++t) {
        for (const std::uint32_t v : level.triangles[t]) {
            if (v >= vertices)
                return invalid_input("encode: triangle " + std::to_string(t) + " refers to a missing vertex");
            if (!all_finite(level.positions[v]))
                return invalid_input("encode: vertex " + std::to_string(v) + " is not finite");
        }
        if (material_of(level, t) >= model.materials.size())
            return invalid_input("encode: triangle " + std::to_string(t) + " refers to a missing material");
        if (gouraud[t] && level.normals.empty()) return invalid_input("encode: Gouraud triangles without normals");
    }
    return Nothing{};
}

// The image that is sent for the model's.
const mesh::Image& sent_image(const Model& model, const EncodeOptions& options, std::size_t image) {
    const bool is_smaller = !options.images.empty() && options.images[image].image != nullptr;
    return is_smaller ? *options.images[image].image : model.images[image];
}

std::array<const mesh::TextureReference*, 4> textures_of(const Material& m) {
    return {&m.base_color_texture, &m.metallic_roughness_texture, &m.occlusion_texture, &m.emissive_texture};
}

Status check_texture(const Model& model, const EncodeOptions& options, const mesh::TextureReference& texture) {
    if (texture.image < 0) return Nothing{};
    if (static_cast<std::size_t>(texture.image) >= model.images.size())
        return invalid_input("encode: a material refers to a missing image");
    const mesh::Image& image = sent_image(model, options, static_cast<std::size_t>(texture.image));
    if (image_media_type(image.bytes).empty() || image_media_type(image.bytes) != image.media_type)
        return invalid_input("encode: image " + std::to_string(texture.image) + " is not the PNG or JPEG that it says");
    return Nothing{};
}

// The triangles of one material.
struct Group {
    std::uint32_t material = 0;
    std::vector<mesh::Triangle> gouraud;
    std::vector<mesh::Triangle> flat;
    std::optional<Rgba8> constant_color;  // where all its vertices have the same
    bool has_texture = false;             // and coordinates to read it at
};

std::vector<Group> group_by_material(const Model& model, const Mesh& level, std::span<const std::uint8_t> gouraud) {
    std::map<std::uint32_t, Group> groups;
    for (std::size_t t = 0; t < level.triangles.size(); ++t) {
        Group& group = groups[material_of(level, t)];
        (gouraud[t] ? group.gouraud : group.flat).push_back(level.triangles[t]);
    }
    std::vector<Group> result;
    for (auto& [material, group] : groups) {
        group.material = material;
        group.has_texture = has_texture(model.materials[material]) && !level.texture_coordinates.empty();
        if (!level.colors.empty()) {
            const mesh::Triangle& first = (group.gouraud.empty() ? group.flat : group.gouraud).front();
            const Rgba8 color = level.colors[first[0]];
            const auto is_same = [&](const mesh::Triangle& t) {
                return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return level.colors[v] == color; });
            };
            if (std::all_of(group.gouraud.begin(), group.gouraud.end(), is_same) &&
                std::all_of(group.flat.begin(), group.flat.end(), is_same))
                group.constant_color = color;
        }
        result.push_back(std::move(group));
    }
    return result;
}

struct Channels {
    Channel position;
    std::optional<Channel> normal;
    std::optional<Channel> texture_coordinate;
    std::optional<Channel> color;
};

// Where the decoded position is farther from its source than it may go and what floats round off.
bool strays(const Channel& position, const EncodeOptions& options) {
    const QuantizationGrid& grid = options.grid;
    const double farthest = options.rounding == Rounding::nearest ? 0.5 : 1.5;  // steps
    for (std::size_t value = 0; value < position.decoded_of_value.size(); ++value)
        for (int axis = 0; axis < 3; ++axis) {
            const double source = position.values[value * 3 + axis];
            const double decoded = position.decoded_value(position.decoded_of_value[value], axis);
            const double rounding = float_rounding * (std::abs(source) + std::abs(grid.origin[axis]) + grid.range);
            if (!(std::abs(decoded - source) <= farthest * grid.step() + rounding)) return true;
        }
    return false;
}

Status check_inside(const Mesh& level, const QuantizationGrid& grid) {
    const double slack = max_outside_grid * grid.range;
    for (const mesh::Triangle& t : level.triangles)
        for (const std::uint32_t v : t)
            for (int axis = 0; axis < 3; ++axis) {
                const double inside = static_cast<double>(level.positions[v][axis]) - grid.origin[axis];
                if (inside < -slack || inside > grid.range + slack)
                    return invalid_input("encode: vertex " + std::to_string(v) + " lies outside the quantization grid");
            }
    return Nothing{};
}

// Attributes of vertices that no triangle uses must not widen a range, so they are those of a used vertex.
template <class Value>
std::vector<Value> used_only(const Mesh& level, const std::vector<Value>& values) {
    std::vector<Value> result(values.size(), values[level.triangles.front()[0]]);
    for (const mesh::Triangle& t : level.triangles)
        for (const std::uint32_t v : t) result[v] = values[v];
    return result;
}

std::vector<Vec3d> grid_points_of(const Mesh& level, const EncodeOptions& options) {
    const std::vector<Vec3f> positions = used_only(level, level.positions);
    if (options.rounding == Rounding::along_surface)
        return SurfaceRounding(positions, level.triangles).round(options.grid).points;
    std::vector<Vec3d> points;
    points.reserve(positions.size());
    for (const Vec3f& p : positions) points.push_back(nearest_grid_point(p, options.grid));
    return points;
}

// The level with normals that cost less, within the tolerance, and the grid points with those of vertices added.
Mesh with_cheap_normals(const Mesh& level, std::span<const std::uint8_t> gouraud, const EncodeOptions& options,
                        std::vector<Vec3d>& grid_points) {
    Replaced replaced =
        replace_normals(level, gouraud, grid_points, options.normal_tolerance_degrees, options.normal_bits);
    for (const std::uint32_t source : replaced.sources) grid_points.push_back(grid_points[source]);
    return std::move(replaced.level);
}

// Over the images that are sent with the groups; 0 where one does not tell its size.
std::uint32_t most_texels(const Model& model, const EncodeOptions& options, const std::vector<Group>& groups) {
    std::uint32_t most = 1;
    for (const Group& group : groups) {
        for (const auto* texture : textures_of(model.materials[group.material])) {
            if (!group.has_texture || texture->image < 0) continue;
            const mesh::Image& image = sent_image(model, options, static_cast<std::size_t>(texture->image));
            if (image.width == 0 || image.height == 0) return 0;
            most = std::max({most, image.width, image.height});
        }
    }
    return most;
}

int texture_coordinate_bits(const Model& model, const EncodeOptions& options, const std::vector<Group>& groups) {
    const std::uint32_t texels = most_texels(model, options, groups);
    if (texels == 0) return options.texture_coordinate_bits;
    const int quarters = static_cast<int>(std::ceil(std::log2(4.0 * texels)));
    return std::min(options.texture_coordinate_bits, std::max(quarters, min_texture_coordinate_bits));
}

Result<Channels> make_channels(const Mesh& level, const std::vector<Vec3d>& grid_points, const EncodeOptions& options,
                               int texture_bits) {
    Channels channels;
    const auto keep = [](Result<Channel> made, auto& slot) -> Status {
        if (!made) return made.error();
        slot = std::move(*made);
        return Nothing{};
    };
    Status status =
        keep(position_channel(used_only(level, level.positions), used_only(level, grid_points), options.grid),
             channels.position);
    if (status && strays(channels.position, options))
        status = invalid_input("encode: the quantization grid is too fine or too far from zero for floats");
    if (status && !level.normals.empty())
        status = keep(normal_channel(used_only(level, level.normals), options.normal_bits), channels.normal);
    if (status && !level.texture_coordinates.empty())
        status = keep(texture_coordinate_channel(used_only(level, level.texture_coordinates), texture_bits),
                      channels.texture_coordinate);
    if (status && !level.colors.empty()) status = keep(color_channel(used_only(level, level.colors)), channels.color);
    if (!status) return status.error();
    return channels;
}

// The shortest decimal that reads back as the same float.
double shortest(float value) {
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    double result = value;
    std::from_chars(text.data(), end, result);
    return result;
}

float in_unit_range(float value, float otherwise) {
    return std::isfinite(value) ? std::clamp(value, 0.0f, 1.0f) : otherwise;
}

// The glTF document as it grows, and its binary chunk.
class Document {
  public:
    Document(const Model& model, const EncodeOptions& options) : model_(model), options_(options) {
        root_["asset"] = {{"version", "2.0"}, {"generator", "lodestream"}};
    }

    void set_extras(json extras) { root_["asset"]["extras"]["lodestream"] = std::move(extras); }
    void add_primitive(const EncodedPrimitive& primitive, std::size_t material,
                       const std::vector<std::byte>& lean_shading);
    std::size_t add_material(const Material& material, const Group& group);
    Result<std::vector<std::byte>> finish();
    std::uint64_t texture_bytes() const { return texture_bytes_; }

  private:
    std::size_t add_view(const void* data, std::size_t size, int target = 0);
    std::size_t add_accessor(json accessor);
    json indices_accessor(const DracoMesh& mesh) const;
    json attribute_accessor(const DracoMesh& mesh, const DracoAttribute& attribute) const;
    std::size_t add_indices_view(const DracoMesh& mesh);
    std::size_t add_attribute_view(const DracoAttribute& attribute);
    std::size_t add_image(int image);
    json texture_reference(const mesh::TextureReference& texture);
    std::size_t add_sampler(const mesh::TextureReference& texture);

    const Model& model_;
    const EncodeOptions& options_;
    std::uint64_t texture_bytes_ = 0;
    json root_ = json::object();
    json primitives_ = json::array();
    std::vector<std::byte> binary_;
    std::map<int, std::size_t> images_;
    std::map<std::pair<mesh::Wrap, mesh::Wrap>, std::size_t> samplers_;
    std::map<std::tuple<int, mesh::Wrap, mesh::Wrap>, std::size_t> textures_;
    bool is_compressed_ = false;
};

std::size_t append_to(json& array, json element) {
    array.push_back(std::move(element));
    return array.size() - 1;
}

std::size_t Document::add_view(const void* data, std::size_t size, int target) {
    binary_.resize((binary_.size() + 3) / 4 * 4);
    json view = {{"buffer", 0}, {"byteLength", size}};
    if (!binary_.empty()) view["byteOffset"] = binary_.size();
    if (target != 0) view["target"] = target;
    const auto* first = static_cast<const std::byte*>(data);
    binary_.insert(binary_.end(), first, first + size);
    return append_to(root_["bufferViews"], std::move(view));
}

std::size_t Document::add_accessor(json accessor) {
    return append_to(root_["accessors"], std::move(accessor));
}

json Document::indices_accessor(const DracoMesh& mesh) const {
    const bool narrow = mesh.points <= max_short_vertices;
    return {{"componentType", narrow ? gltf_unsigned_short : gltf_unsigned_int},
            {"count", mesh.triangles.size() * 3},
            {"type", "SCALAR"}};
}

json Document::attribute_accessor(const DracoMesh& mesh, const DracoAttribute& attribute) const {
    json accessor = {{"componentType", attribute.normalized ? gltf_unsigned_byte : gltf_float},
                     {"count", mesh.points},
                     {"type", "VEC" + std::to_string(attribute.components)}};
    if (attribute.normalized) accessor["normalized"] = true;
    if (attribute.semantic != DracoAttribute::Semantic::position) return accessor;
    for (int axis = 0; axis < 3; ++axis) {
        float low = attribute.values[axis], high = low;
        for (std::size_t i = axis; i < attribute.values.size(); i += 3) {
            low = std::min(low, attribute.values[i]);
            high = std::max(high, attribute.values[i]);
        }
        accessor["min"].push_back(shortest(low));
        accessor["max"].push_back(shortest(high));
    }
    return accessor;
}

std::size_t Document::add_indices_view(const DracoMesh& mesh) {
    if (mesh.points > max_short_vertices)
        return add_view(mesh.triangles.data(), mesh.triangles.size() * sizeof(mesh::Triangle),
                        gltf_element_array_buffer);
    std::vector<std::uint16_t> indices;
    for (const mesh::Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) indices.push_back(static_cast<std::uint16_t>(v));
    return add_view(indices.data(), indices.size() * sizeof(std::uint16_t), gltf_element_array_buffer);
}

std::size_t Document::add_attribute_view(const DracoAttribute& attribute) {
    if (!attribute.normalized)
        return add_view(attribute.values.data(), attribute.values.size() * sizeof(float), gltf_array_buffer);
    std::vector<std::uint8_t> bytes;
    for (const float value : attribute.values) bytes.push_back(static_cast<std::uint8_t>(std::lround(value * 255.0f)));
    return add_view(bytes.data(), bytes.size(), gltf_array_buffer);
}

const char* attribute_name(DracoAttribute::Semantic semantic) {
    switch (semantic) {
        case DracoAttribute::Semantic::normal:
            return "NORMAL";
        case DracoAttribute::Semantic::color:
            return "COLOR_0";
        case DracoAttribute::Semantic::texture_coordinate:
            return "TEXCOORD_0";
        default:
            return "POSITION";
    }
}

// `lean_shading` empty: none.
void Document::add_primitive(const EncodedPrimitive& primitive, std::size_t material,
                             const std::vector<std::byte>& lean_shading) {
    const bool compressed = !primitive.stream.empty();
    const DracoMesh& mesh = primitive.decoded;
    json result = {{"material", material}};
    json indices = indices_accessor(mesh);
    if (!compressed) indices["bufferView"] = add_indices_view(mesh);
    result["indices"] = add_accessor(std::move(indices));
    json ids = json::object();
    for (const auto& [id, attribute] : mesh.attributes) {
        json accessor = attribute_accessor(mesh, attribute);
        if (!compressed) accessor["bufferView"] = add_attribute_view(attribute);
        const char* name = attribute_name(attribute.semantic);
        result["attributes"][name] = add_accessor(std::move(accessor));
        ids[name] = id;
    }
    if (compressed) {
        json extension = {{"bufferView", add_view(primitive.stream.data(), primitive.stream.size())}};
        if (!options_.lean) extension["attributes"] = std::move(ids);
        result["extensions"][options_.lean ? lean_extension : draco_extension] = std::move(extension);
        is_compressed_ = true;
    }
    if (!lean_shading.empty())
        result["extras"]["lodestream"]["shading"] = add_view(lean_shading.data(), lean_shading.size());
    primitives_.push_back(std::move(result));
}

std::size_t Document::add_image(int image) {
    const auto found = images_.find(image);
    if (found != images_.end()) return found->second;
    const mesh::Image& source = sent_image(model_, options_, static_cast<std::size_t>(image));
    texture_bytes_ += source.bytes.size();
    const std::size_t view = add_view(source.bytes.data(), source.bytes.size());
    return images_[image] = append_to(root_["images"], {{"bufferView", view}, {"mimeType", source.media_type}});
}

std::size_t Document::add_sampler(const mesh::TextureReference& texture) {
    const auto wraps = std::pair(texture.wrap_s, texture.wrap_t);
    const auto found = samplers_.find(wraps);
    if (found != samplers_.end()) return found->second;
    return samplers_[wraps] = append_to(root_["samplers"],
                                        {{"wrapS", wrap_code(texture.wrap_s)}, {"wrapT", wrap_code(texture.wrap_t)}});
}

json Document::texture_reference(const mesh::TextureReference& texture) {
    const auto key = std::tuple(texture.image, texture.wrap_s, texture.wrap_t);
    const auto found = textures_.find(key);
    if (found != textures_.end()) return {{"index", found->second}};
    const std::size_t image = add_image(texture.image);
    const std::size_t sampler = add_sampler(texture);
    textures_[key] = append_to(root_["textures"], {{"source", image}, {"sampler", sampler}});
    return {{"index", textures_[key]}};
}

const char* alpha_mode_name(mesh::AlphaMode mode) {
    switch (mode) {
        case mesh::AlphaMode::mask:
            return "MASK";
        case mesh::AlphaMode::blend:
            return "BLEND";
        case mesh::AlphaMode::opaque:
            break;
    }
    return "OPAQUE";
}

// Factors only; glTF's defaults are left out.
json material_factors(const Material& material, Rgba8 tint) {
    json pbr = json::object();
    json base_color;
    bool white = true;
    for (int c = 0; c < 4; ++c) {
        const float factor = in_unit_range(material.base_color[c], 1.0f) * static_cast<float>(tint[c] / 255.0);
        base_color.push_back(shortest(factor));
        white = white && factor == 1.0f;
    }
    if (!white) pbr["baseColorFactor"] = std::move(base_color);
    const float metallic = in_unit_range(material.metallic, 0.0f);
    const float roughness = in_unit_range(material.roughness, 1.0f);
    if (metallic != 1.0f) pbr["metallicFactor"] = shortest(metallic);
    if (roughness != 1.0f) pbr["roughnessFactor"] = shortest(roughness);
    json result = json::object();
    if (!pbr.empty()) result["pbrMetallicRoughness"] = std::move(pbr);
    if (!material.name.empty()) result["name"] = material.name;
    json emissive;
    bool emits = false;
    for (int c = 0; c < 3; ++c) {
        const float factor = in_unit_range(material.emissive[c], 0.0f);
        emissive.push_back(shortest(factor));
        emits = emits || factor > 0.0f;
    }
    if (emits) result["emissiveFactor"] = std::move(emissive);
    if (material.double_sided) result["doubleSided"] = true;
    if (material.alpha_mode != mesh::AlphaMode::opaque) result["alphaMode"] = alpha_mode_name(material.alpha_mode);
    const float cutoff = std::isfinite(material.alpha_cutoff) ? std::max(material.alpha_cutoff, 0.0f) : 0.5f;
    if (material.alpha_mode == mesh::AlphaMode::mask && cutoff != 0.5f) result["alphaCutoff"] = shortest(cutoff);
    return result;
}

std::size_t Document::add_material(const Material& material, const Group& group) {
    json result = material_factors(material, group.constant_color.value_or(Rgba8(255)));
    if (group.has_texture) {
        const auto add = [&](json& parent, const char* name, const mesh::TextureReference& texture) {
            if (texture.image >= 0) parent[name] = texture_reference(texture);
        };
        add(result["pbrMetallicRoughness"], "baseColorTexture", material.base_color_texture);
        add(result["pbrMetallicRoughness"], "metallicRoughnessTexture", material.metallic_roughness_texture);
        add(result, "occlusionTexture", material.occlusion_texture);
        add(result, "emissiveTexture", material.emissive_texture);
        if (result["pbrMetallicRoughness"].empty()) result.erase("pbrMetallicRoughness");
    }
    return append_to(root_["materials"], std::move(result));
}

Result<std::vector<std::byte>> Document::finish() {
    root_["scene"] = 0;
    if (primitives_.empty()) {
        root_["scenes"] = json::array({json::object()});
        return join_glb(root_, {});
    }
    json node = {{"mesh", 0}};
    if (model_.origin != Vec3d(0.0)) node["translation"] = {model_.origin.x, model_.origin.y, model_.origin.z};
    root_["scenes"] = json::array({{{"nodes", json::array({0})}}});
    root_["nodes"] = json::array({std::move(node)});
    root_["meshes"] = json::array({{{"primitives", std::move(primitives_)}}});
    if (is_compressed_)
        root_["extensionsUsed"] = root_["extensionsRequired"] =
            json::array({options_.lean ? lean_extension : draco_extension});
    binary_.resize((binary_.size() + 3) / 4 * 4);
    root_["buffers"] = json::array({{{"byteLength", binary_.size()}}});
    return join_glb(root_, std::move(binary_));
}

// One primitive to be: its triangles, the Gouraud ones first, and the channels that they need.
struct Part {
    const Group* group;
    std::vector<mesh::Triangle> triangles;
    std::size_t gouraud = 0;
    std::vector<const Channel*> channels;
};

std::vector<Part> parts_of(const std::vector<Group>& groups, const Channels& channels, bool lean) {
    std::vector<Part> parts;
    const auto add = [&](const Group& group, std::vector<mesh::Triangle> triangles, std::size_t gouraud) {
        if (triangles.empty()) return;
        Part part{&group, std::move(triangles), gouraud, {&channels.position}};
        if (gouraud > 0 && !lean) part.channels.push_back(&*channels.normal);
        if (group.has_texture) part.channels.push_back(&*channels.texture_coordinate);
        if (channels.color && !group.constant_color) part.channels.push_back(&*channels.color);
        parts.push_back(std::move(part));
    };
    for (const Group& group : groups) {
        std::vector<mesh::Triangle> triangles = group.gouraud;
        if (lean) triangles.insert(triangles.end(), group.flat.begin(), group.flat.end());
        add(group, std::move(triangles), group.gouraud.size());
        if (!lean) add(group, group.flat, 0);
    }
    return parts;
}

std::vector<Vec3f> decoded_positions(const DracoMesh& mesh) {
    const std::vector<float>& values = mesh.attributes.at(0).values;
    std::vector<Vec3f> positions;
    for (std::size_t i = 0; i < values.size(); i += 3) positions.emplace_back(values[i], values[i + 1], values[i + 2]);
    return positions;
}

// Empty where all is flat, which is what a primitive without normals says by itself.
std::vector<std::byte> lean_shading(const Part& part, const Channel& normal, const EncodedPrimitive& primitive,
                                    double tolerance_degrees) {
    if (part.gouraud == 0) return {};
    const DracoMesh& decoded = primitive.decoded;
    const std::vector<std::uint32_t>& sources = primitive.source_corners;
    WantedShading wanted;
    KeyTable used(1);  // of the level's normals
    for (std::size_t c = 0; c < sources.size(); ++c) {
        const std::uint32_t value = normal.value_of_vertex[part.triangles[sources[c] / 3][sources[c] % 3]];
        wanted.normal_of_corner.push_back(used.find_or_add(&value));
        const float* n = &normal.values[3 * std::size_t{value}];
        if (used.size() > wanted.normals.size()) wanted.normals.emplace_back(n[0], n[1], n[2]);
        if (c % 3 == 0) wanted.gouraud.push_back(sources[c] / 3 < part.gouraud ? 1 : 0);
    }
    return encode_lean_shading(decoded_positions(decoded),
                               between_positions(decoded.triangles, decoded.first_at_position), wanted,
                               tolerance_degrees);
}

// What was not sent, by what it would have cost: the parts that lack it are encoded with it too, lean normals as plain
// ones, since a lean stream has none.
class Omissions {
  public:
    explicit Omissions(bool lean) : lean_(lean) {}

    void add(const char* what, std::uint64_t bytes) {
        if (bytes > 0) bytes_[what] += bytes;
    }
    void measure(const Part& part, std::uint64_t size, const std::optional<Channel>& channel, const char* what) {
        if (!channel || std::find(part.channels.begin(), part.channels.end(), &*channel) != part.channels.end()) return;
        std::vector<const Channel*> with = part.channels;
        with.push_back(&*channel);
        const bool as_lean = lean_ && channel->semantic != DracoAttribute::Semantic::normal;
        const std::uint64_t larger =
            as_lean ? measure_lean_primitive(part.triangles, with) : measure_primitive(part.triangles, with);
        add(what, larger > size ? larger - size : 0);
    }
    std::vector<std::pair<std::string, std::uint64_t>> list() const { return {bytes_.begin(), bytes_.end()}; }

  private:
    bool lean_;
    std::map<std::string, std::uint64_t> bytes_;
};

// `image` was sent smaller than the model has it.
void add_texels(const Model& model, const EncodeOptions& options, std::size_t image, Omissions& omissions) {
    if (options.images.empty()) return;
    const std::uint64_t full = model.images[image].bytes.size();
    const std::uint64_t saved = full - std::min<std::uint64_t>(full, sent_image(model, options, image).bytes.size());
    const std::uint64_t below_a_pixel = std::min(saved, options.images[image].bytes_below_a_pixel);
    omissions.add("texels below a pixel", below_a_pixel);
    omissions.add("texels beyond the network", saved - below_a_pixel);
}

void add_images_and_materials(const Model& model, const EncodeOptions& options, const std::vector<Group>& groups,
                              Omissions& omissions) {
    std::vector<bool> material_used(model.materials.size(), false), image_used(model.images.size(), false);
    for (const Group& group : groups) {
        material_used[group.material] = true;
        if (!group.has_texture) continue;
        for (const auto* texture : textures_of(model.materials[group.material]))
            if (texture->image >= 0) image_used[static_cast<std::size_t>(texture->image)] = true;
    }
    for (std::size_t i = 0; i < image_used.size(); ++i)
        if (image_used[i])
            add_texels(model, options, i, omissions);
        else
            omissions.add("unused images", model.images[i].bytes.size());
    for (std::size_t i = 0; i < material_used.size(); ++i)
        if (!material_used[i])
            omissions.add("unused materials", material_factors(model.materials[i], Rgba8(255))
                                                  .dump(-1, ' ', false, json::error_handler_t::replace)
                                                  .size());
}

Status check_textures(const Model& model, const EncodeOptions& options, const std::vector<Group>& groups) {
    if (!options.images.empty() && options.images.size() != model.images.size())
        return invalid_input("encode: not one smaller image for each of the model's");
    for (const Group& group : groups) {
        if (!group.has_texture) continue;
        for (const auto* texture : textures_of(model.materials[group.material]))
            if (Status status = check_texture(model, options, *texture); !status) return status;
    }
    return Nothing{};
}

Result<Encoded> encode(const Model& model, const Mesh& level, std::span<const std::uint8_t> gouraud,
                       const EncodeOptions& options) {
    for (const Status& status : {check_options(options), check_level(model, level, gouraud)})
        if (!status) return status.error();
    Document document(model, options);
    if (!options.extras_json.empty()) {
        Result<json> extras = parse_json(options.extras_json);
        if (!extras || !extras->is_object()) return invalid_input("encode: extras_json is not a JSON object");
        document.set_extras(std::move(*extras));
    }
    if (const Status status = check_inside(level, options.grid); !status) return status.error();
    std::vector<Vec3d> grid_points = level.triangles.empty() ? std::vector<Vec3d>{} : grid_points_of(level, options);
    const bool cheapens = !options.lean && options.normal_tolerance_degrees > 0.0 && !level.normals.empty();
    std::optional<Mesh> cheaper;
    if (cheapens) cheaper = with_cheap_normals(level, gouraud, options, grid_points);
    const Mesh& sent = cheaper ? *cheaper : level;
    const std::vector<Group> groups = group_by_material(model, sent, gouraud);
    if (2 * groups.size() > max_gltf_elements) return fail(ErrorCode::limit_exceeded, "encode: too many materials");
    if (const Status status = check_textures(model, options, groups); !status) return status.error();

    Encoded result;
    Omissions omissions(options.lean);
    add_images_and_materials(model, options, groups, omissions);
    if (!groups.empty()) {
        Result<Channels> channels =
            make_channels(sent, grid_points, options, texture_coordinate_bits(model, options, groups));
        if (!channels) return channels.error();
        std::map<const Group*, std::size_t> materials;
        for (const Group& group : groups)
            materials[&group] = document.add_material(model.materials[group.material], group);
        for (const Part& part : parts_of(groups, *channels, options.lean)) {
            Result<EncodedPrimitive> primitive = options.lean ? encode_lean_primitive(part.triangles, part.channels)
                                                              : encode_primitive(part.triangles, part.channels);
            if (!primitive) return primitive.error();
            std::vector<std::byte> lean;
            if (options.lean && channels->normal)
                lean = lean_shading(part, *channels->normal, *primitive,
                                    std::max(options.normal_tolerance_degrees, least_lean_tolerance_degrees));
            document.add_primitive(*primitive, materials[part.group], lean);
            result.triangles += primitive->decoded.triangles.size();
            result.vertices += primitive->decoded.points;
            result.geometry_bytes += primitive->stream.size() + lean.size();
            if (primitive->stream.empty()) continue;
            omissions.measure(part, primitive->stream.size() + lean.size(), channels->normal,
                              part.gouraud == 0 ? "normals of flat triangles" : "normals that are derived");
            omissions.measure(part, primitive->stream.size(), channels->texture_coordinate,
                              "texture coordinates without a texture");
            omissions.measure(part, primitive->stream.size(), channels->color, "constant colours");
        }
    }
    Result<std::vector<std::byte>> glb = document.finish();
    if (!glb) return glb.error();
    result.glb = std::move(*glb);
    result.texture_bytes = document.texture_bytes();
    result.left_out = omissions.list();
    return result;
}

}  // namespace

Result<Encoded> encode_level(const Model& model, const Mesh& level, std::span<const std::uint8_t> gouraud,
                             const EncodeOptions& options) {
    try {
        return encode(model, level, gouraud, options);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "encode: not enough memory");
    } catch (const std::exception& error) {
        return fail(ErrorCode::internal, std::string("encode: ") + error.what());
    }
}

}  // namespace lodestream::codec
