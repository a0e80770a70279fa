#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "common/codec/draco_mesh.h"
#include "common/codec/glb.h"
#include "common/codec/lean_shading.h"
#include "common/codec/level_codec.h"
#include "common/codec/primitive_codec.h"

namespace lodestream::codec {
namespace {

using mesh::Material;
using nlohmann::json;

// Thrown and caught in this file only: a reader of nested data is clearest when any step may refuse.
struct Refusal {
    Error error;
};

void require(bool holds, const char* what) {
    if (!holds) throw Refusal{invalid_input(std::string("GLB: ") + what)};
}

const json& member(const json& object, const char* name) {
    require(object.is_object(), "an object is expected");
    const auto found = object.find(name);
    if (found == object.end()) throw Refusal{invalid_input(std::string("GLB: no ") + name)};
    return *found;
}

const json* find(const json& object, const char* name) {
    require(object.is_object(), "an object is expected");
    const auto found = object.find(name);
    return found == object.end() ? nullptr : &*found;
}

const json& array_of(const json& object, const char* name) {
    static const json empty = json::array();
    const json* found = find(object, name);
    if (!found) return empty;
    require(found->is_array() && found->size() <= max_gltf_elements, "an array of a sensible length is expected");
    return *found;
}

std::uint64_t whole(const json& value) {
    require(value.is_number_unsigned(), "a whole number is expected");
    return value.get<std::uint64_t>();
}

std::uint64_t whole_or(const json& object, const char* name, std::uint64_t otherwise) {
    const json* found = find(object, name);
    return found ? whole(*found) : otherwise;
}

std::string text_or(const json& object, const char* name, const char* otherwise) {
    const json* found = find(object, name);
    require(!found || found->is_string(), "a string is expected");
    return found ? found->get<std::string>() : otherwise;
}

bool flag(const json& object, const char* name) {
    const json* found = find(object, name);
    require(!found || found->is_boolean(), "true or false is expected");
    return found && found->get<bool>();
}

double number(const json& value, double low, double high) {
    require(value.is_number(), "a number is expected");
    const double x = value.get<double>();
    require(x >= low && x <= high, "a number is out of range");
    return x;
}

float number_or(const json& object, const char* name, float high, float otherwise) {
    const json* found = find(object, name);
    return found ? static_cast<float>(number(*found, 0.0, high)) : otherwise;
}

template <class Vector>
Vector vector_or(const json& object, const char* name, double low, double high, Vector otherwise) {
    const json* found = find(object, name);
    if (!found) return otherwise;
    require(found->is_array() && found->size() == static_cast<std::size_t>(Vector::length()), "a vector is expected");
    for (int c = 0; c < Vector::length(); ++c)
        otherwise[c] =
            static_cast<typename Vector::value_type>(number((*found)[static_cast<std::size_t>(c)], low, high));
    return otherwise;
}

mesh::Wrap wrap_of(std::uint64_t code) {
    for (const mesh::Wrap wrap : {mesh::Wrap::repeat, mesh::Wrap::clamp_to_edge, mesh::Wrap::mirrored_repeat})
        if (code == static_cast<std::uint64_t>(wrap_code(wrap))) return wrap;
    throw Refusal{invalid_input("GLB: unknown texture wrap")};
}

struct Geometry {
    mesh::Mesh mesh;
    // Of each vertex, the first one at its position; empty: no two share one, or it was not asked for.
    std::vector<std::uint32_t> first_at_position;
};

class Reader {
  public:
    explicit Reader(Glb glb)
        : root_(std::move(glb.json)),
          binary_(glb.binary),
          view_is_used_(array_of(root_, "bufferViews").size(), false) {}

    Decoded read();

  private:
    void check_head() const;
    std::string read_extras() const;
    const json& element(const char* array, std::uint64_t index) const;
    std::span<const std::byte> take_view(std::uint64_t index);
    mesh::Image read_image(const json& image);
    Material read_material(const json& material) const;
    mesh::TextureReference read_texture(const json& parent, const char* name) const;
    const json& check_accessor(std::uint64_t index, const char* type, std::uint64_t component_type,
                               std::uint64_t count) const;
    template <class Read>
    void read_attributes(const json& attributes, std::uint64_t points, mesh::Mesh& mesh, const Read& read) const;
    Geometry read_geometry(const json& primitive, bool with_first_points);
    Primitive read_primitive(const json& primitive, mesh::Mesh mesh) const;
    std::vector<Primitive> read_shaded(const json& primitive);
    Geometry read_compressed(const json& primitive, const json& extension, bool with_first_points);
    Geometry read_lean(const json& primitive, const json& extension);
    void check_indices(const json& primitive, const mesh::Mesh& mesh) const;
    Geometry read_plain(const json& primitive);
    void read_plain_indices(const json& primitive, mesh::Mesh& mesh);
    const json* find_node() const;

    json root_;
    std::span<const std::byte> binary_;
    std::vector<bool> view_is_used_;
    std::uint64_t vertices_left_ = max_decoded_vertices;
    std::uint64_t triangles_left_ = max_decoded_triangles;
};

void Reader::check_head() const {
    require(text_or(member(root_, "asset"), "version", "") == "2.0", "not glTF 2.0");
    for (const json& extension : array_of(root_, "extensionsRequired"))
        if (extension != draco_extension && extension != lean_extension)
            throw Refusal{fail(ErrorCode::unsupported, "GLB: a required extension is not supported")};
    const json& buffers = array_of(root_, "buffers");
    require(buffers.size() == (binary_.empty() ? 0u : 1u), "one buffer is expected, the binary chunk");
    if (buffers.empty()) return;
    require(!find(buffers[0], "uri"), "a buffer outside the file");
    require(whole(member(buffers[0], "byteLength")) == binary_.size(), "the buffer is not the binary chunk");
}

std::string Reader::read_extras() const {
    const json* extras = find(member(root_, "asset"), "extras");
    const json* ours = extras ? find(*extras, "lodestream") : nullptr;
    if (!ours) return "";
    require(ours->is_object(), "extras.lodestream is not an object");
    return ours->dump();
}

const json& Reader::element(const char* array, std::uint64_t index) const {
    const json& elements = array_of(root_, array);
    require(index < elements.size(), "a reference to a missing element");
    require(elements[index].is_object(), "an object is expected");
    return elements[index];
}

// Each view has one user, so that a small file cannot ask for the same work many times.
std::span<const std::byte> Reader::take_view(std::uint64_t index) {
    const json& view = element("bufferViews", index);
    require(!view_is_used_[index], "a buffer view is used twice");
    view_is_used_[index] = true;
    require(whole(member(view, "buffer")) == 0 && !find(view, "byteStride"), "a buffer view of an unexpected kind");
    const std::uint64_t offset = whole_or(view, "byteOffset", 0), length = whole(member(view, "byteLength"));
    require(offset <= binary_.size() && length <= binary_.size() - offset, "a buffer view beyond the buffer");
    return binary_.subspan(offset, length);
}

std::uint32_t big_endian(std::span<const std::byte> bytes, std::size_t offset, int count) {
    std::uint32_t result = 0;
    for (int i = 0; i < count; ++i) result = result << 8 | std::to_integer<std::uint32_t>(bytes[offset + i]);
    return result;
}

// Sets width and height from the PNG's first chunk or the JPEG's frame header; they stay 0 where neither is found.
void read_image_size(mesh::Image& image) {
    const std::span<const std::byte> bytes = image.bytes;
    if (image.media_type == "image/png" && bytes.size() >= 24) {
        image.width = big_endian(bytes, 16, 4);
        image.height = big_endian(bytes, 20, 4);
        return;
    }
    for (std::size_t at = 2; image.media_type == "image/jpeg" && at + 9 <= bytes.size();) {
        const std::uint32_t marker = big_endian(bytes, at, 2), length = big_endian(bytes, at + 2, 2);
        const bool is_frame =
            marker >= 0xffc0 && marker <= 0xffcf && marker != 0xffc4 && marker != 0xffc8 && marker != 0xffcc;
        if (is_frame) {
            image.height = big_endian(bytes, at + 5, 2);
            image.width = big_endian(bytes, at + 7, 2);
            return;
        }
        at += 2 + std::size_t{length};
    }
}

mesh::Image Reader::read_image(const json& image) {
    const auto bytes = take_view(whole(member(image, "bufferView")));
    mesh::Image result;
    result.media_type = text_or(image, "mimeType", "");
    require(!result.media_type.empty() && image_media_type(bytes) == result.media_type, "an image is not what it says");
    result.bytes.assign(bytes.begin(), bytes.end());
    read_image_size(result);
    return result;
}

mesh::TextureReference Reader::read_texture(const json& parent, const char* name) const {
    mesh::TextureReference result;
    const json* reference = find(parent, name);
    if (!reference) return result;
    require(whole_or(*reference, "texCoord", 0) == 0, "a second set of texture coordinates");
    const json& texture = element("textures", whole(member(*reference, "index")));
    const std::uint64_t image = whole(member(texture, "source"));
    element("images", image);
    result.image = static_cast<int>(image);
    if (const json* index = find(texture, "sampler")) {
        const json& sampler = element("samplers", whole(*index));
        result.wrap_s = wrap_of(whole_or(sampler, "wrapS", 10497));
        result.wrap_t = wrap_of(whole_or(sampler, "wrapT", 10497));
    }
    return result;
}

Material Reader::read_material(const json& material) const {
    static const json no_factors = json::object();
    constexpr float largest = std::numeric_limits<float>::max();
    const json* pbr_member = find(material, "pbrMetallicRoughness");
    const json& pbr = pbr_member ? *pbr_member : no_factors;
    Material result;
    result.name = text_or(material, "name", "");
    result.base_color = vector_or(pbr, "baseColorFactor", 0.0, 1.0, Vec4f(1.0f));
    result.metallic = number_or(pbr, "metallicFactor", 1.0f, 1.0f);
    result.roughness = number_or(pbr, "roughnessFactor", 1.0f, 1.0f);
    result.emissive = vector_or(material, "emissiveFactor", 0.0, 1.0, Vec3f(0.0f));
    result.base_color_texture = read_texture(pbr, "baseColorTexture");
    result.metallic_roughness_texture = read_texture(pbr, "metallicRoughnessTexture");
    result.occlusion_texture = read_texture(material, "occlusionTexture");
    result.emissive_texture = read_texture(material, "emissiveTexture");
    const std::string mode = text_or(material, "alphaMode", "OPAQUE");
    require(mode == "OPAQUE" || mode == "MASK" || mode == "BLEND", "unknown alpha mode");
    result.alpha_mode = mode == "MASK"    ? mesh::AlphaMode::mask
                        : mode == "BLEND" ? mesh::AlphaMode::blend
                                          : mesh::AlphaMode::opaque;
    result.alpha_cutoff = number_or(material, "alphaCutoff", largest, 0.5f);
    result.double_sided = flag(material, "doubleSided");
    return result;
}

const json& Reader::check_accessor(std::uint64_t index, const char* type, std::uint64_t component_type,
                                   std::uint64_t count) const {
    const json& accessor = element("accessors", index);
    require(text_or(accessor, "type", "") == type, "an accessor of an unexpected type");
    require(whole(member(accessor, "componentType")) == component_type, "an accessor of an unexpected component type");
    require(whole(member(accessor, "count")) == count, "an accessor's count is not that of its data");
    require(flag(accessor, "normalized") == (component_type == gltf_unsigned_byte),
            "an accessor is wrongly normalized");
    require(whole_or(accessor, "byteOffset", 0) == 0 && !find(accessor, "sparse"), "an accessor of an unexpected kind");
    return accessor;
}

bool is_index_type(std::uint64_t component_type) {
    return component_type == gltf_unsigned_short || component_type == gltf_unsigned_int;
}

void Reader::check_indices(const json& primitive, const mesh::Mesh& mesh) const {
    const std::uint64_t indices = whole(member(primitive, "indices"));
    const std::uint64_t index_type = whole(member(element("accessors", indices), "componentType"));
    require(is_index_type(index_type), "indices of an unexpected type");
    check_accessor(indices, "SCALAR", index_type, std::uint64_t{mesh.triangles.size()} * 3);
}

// All at once, which takes a tenth of the time of a look at each.
bool all_finite(std::span<const float> values) {
    constexpr std::uint32_t not_finite = 0x7f800000;
    bool result = true;
    for (const float value : values) result &= (std::bit_cast<std::uint32_t>(value) & not_finite) != not_finite;
    return result;
}

bool all_of_unit_length(const std::vector<Vec3f>& normals) {
    constexpr float most_off = 0.02f;  // of the square
    bool result = true;
    for (const Vec3f& n : normals) result &= std::abs(dot(n, n) - 1.0f) < most_off;
    return result;
}

template <class Number, class Vector>
std::span<Number> numbers_of(std::vector<Vector>& vectors) {
    static_assert(sizeof(Vector) == Vector::length() * sizeof(Number));
    return {reinterpret_cast<Number*>(vectors.data()), vectors.size() * Vector::length()};
}

// Fills the mesh's attributes that `attributes` names: read(name, its entry, floats or bytes to fill).
template <class Read>
void Reader::read_attributes(const json& attributes, std::uint64_t points, mesh::Mesh& mesh, const Read& read) const {
    require(attributes.is_object(), "an object is expected");
    std::size_t known = 0;
    const auto add = [&](const char* name, auto& vectors, auto number, int component_type) {
        using Vector = typename std::remove_reference_t<decltype(vectors)>::value_type;
        const json* accessor = find(attributes, name);
        if (!accessor) return;
        constexpr std::array<const char*, 5> types{"", "SCALAR", "VEC2", "VEC3", "VEC4"};
        check_accessor(whole(*accessor), types[static_cast<std::size_t>(Vector::length())],
                       static_cast<std::uint64_t>(component_type), points);
        vectors.resize(points);
        const auto values = numbers_of<decltype(number)>(vectors);
        read(name, *accessor, values);
        if constexpr (std::is_same_v<decltype(number), float>)
            require(all_finite(values), "an attribute is not finite");
        ++known;
    };
    add("POSITION", mesh.positions, float{}, gltf_float);
    add("NORMAL", mesh.normals, float{}, gltf_float);
    add("TEXCOORD_0", mesh.texture_coordinates, float{}, gltf_float);
    add("COLOR_0", mesh.colors, std::uint8_t{}, gltf_unsigned_byte);
    require(known == attributes.size(), "an unknown attribute");
}

Geometry Reader::read_compressed(const json& primitive, const json& extension, bool with_first_points) {
    const auto taken = [](auto result) {
        if (!result) throw Refusal{fail(result.error().code, "GLB: " + result.error().message)};
        return *std::move(result);
    };
    const auto bytes = take_view(whole(member(extension, "bufferView")));
    const DracoStream stream = taken(DracoStream::decode(bytes, vertices_left_, triangles_left_));
    Geometry result;
    result.mesh.triangles = taken(stream.triangles());
    check_indices(primitive, result.mesh);
    const json& ids = member(extension, "attributes");
    const json& attributes = member(primitive, "attributes");
    require(ids.is_object() && ids.size() == attributes.size(), "attributes outside Draco");
    read_attributes(attributes, stream.points(), result.mesh, [&](const char* name, const json&, auto values) {
        const std::uint64_t id = whole(member(ids, name));
        require(id <= std::numeric_limits<std::uint32_t>::max() && stream.points() > 0, "a Draco attribute is missing");
        taken(stream.read(static_cast<std::uint32_t>(id), static_cast<int>(values.size() / stream.points()), values));
    });
    if (with_first_points) result.first_at_position = taken(stream.first_at_position());
    return result;
}

Geometry Reader::read_lean(const json& primitive, const json& extension) {
    Result<LeanMesh> decoded =
        decode_lean_mesh(take_view(whole(member(extension, "bufferView"))), vertices_left_, triangles_left_);
    if (!decoded) throw Refusal{fail(decoded.error().code, "GLB: " + decoded.error().message)};
    Geometry result;
    result.first_at_position = first_points(*decoded);
    const json& attributes = member(primitive, "attributes");
    const std::size_t points = decoded->position_of_point.size();
    std::size_t used = 0;
    read_attributes(attributes, points, result.mesh, [&](const char* name, const json&, auto values) {
        using Number = typename decltype(values)::value_type;
        ++used;
        if constexpr (std::is_same_v<Number, float>)
            if (std::strcmp(name, "POSITION") == 0) return read_positions(*decoded, values);
        const auto kind =
            std::is_same_v<Number, float> ? LeanAttribute::Kind::texture_coordinate : LeanAttribute::Kind::color;
        const auto found = std::find_if(decoded->attributes.begin(), decoded->attributes.end(),
                                        [&](const LeanAttribute& a) { return a.kind == kind; });
        require(found != decoded->attributes.end() && found->values.size() == values.size(),
                "an attribute outside the lean mesh");
        read_values(*found, values);
    });
    require(used == decoded->attributes.size() + 1 && !result.mesh.positions.empty(), "an attribute twice");
    result.mesh.triangles = std::move(decoded->triangles);
    check_indices(primitive, result.mesh);
    return result;
}

void Reader::read_plain_indices(const json& primitive, mesh::Mesh& mesh) {
    const std::uint64_t index = whole(member(primitive, "indices"));
    const json& accessor = element("accessors", index);
    const std::uint64_t type = whole(member(accessor, "componentType")), count = whole(member(accessor, "count"));
    require(is_index_type(type) && count % 3 == 0 && count / 3 <= triangles_left_, "indices of an unexpected kind");
    check_accessor(index, "SCALAR", type, count);
    const auto bytes = take_view(whole(member(accessor, "bufferView")));
    const std::uint64_t size = type == gltf_unsigned_short ? 2 : 4;
    require(bytes.size() == count * size, "indices do not fill their buffer view");
    mesh.triangles.resize(count / 3);
    for (std::uint64_t i = 0; i < count; ++i) {
        std::uint32_t vertex = 0;
        std::memcpy(&vertex, bytes.data() + i * size, size);
        require(vertex < mesh.positions.size(), "an index is out of range");
        mesh.triangles[i / 3][i % 3] = vertex;
    }
}

Geometry Reader::read_plain(const json& primitive) {
    const json& attributes = member(primitive, "attributes");
    const std::uint64_t points = whole(member(element("accessors", whole(member(attributes, "POSITION"))), "count"));
    require(points <= vertices_left_, "too many vertices");
    Geometry result;
    // What fills a vector has been checked to be in the file before the vector is made.
    for (const auto& [name, accessor] : attributes.items())
        require(points <= binary_.size() && accessor.is_number_unsigned(),
                "an attribute does not fill its buffer view");
    read_attributes(attributes, points, result.mesh, [&](const char*, const json& accessor, auto values) {
        const auto bytes = take_view(whole(member(element("accessors", whole(accessor)), "bufferView")));
        require(bytes.size() == values.size_bytes(), "an attribute does not fill its buffer view");
        if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    });
    read_plain_indices(primitive, result.mesh);
    return result;
}

Geometry Reader::read_geometry(const json& primitive, bool with_first_points) {
    require(whole_or(primitive, "mode", gltf_triangles) == gltf_triangles, "not triangles");
    const json* extensions = find(primitive, "extensions");
    const json* draco = extensions ? find(*extensions, draco_extension) : nullptr;
    const json* lean = extensions ? find(*extensions, lean_extension) : nullptr;
    Geometry geometry = draco  ? read_compressed(primitive, *draco, with_first_points)
                        : lean ? read_lean(primitive, *lean)
                               : read_plain(primitive);
    require(!geometry.mesh.positions.empty() && !geometry.mesh.triangles.empty(), "a primitive without triangles");
    vertices_left_ -= geometry.mesh.positions.size();
    triangles_left_ -= geometry.mesh.triangles.size();
    return geometry;
}

Primitive Reader::read_primitive(const json& primitive, mesh::Mesh mesh) const {
    Primitive result;
    const std::uint64_t material = whole(member(primitive, "material"));
    element("materials", material);
    result.material = static_cast<std::uint32_t>(material);
    result.mesh = std::move(mesh);
    require(all_of_unit_length(result.mesh.normals), "a normal is not of unit length");
    result.shading = result.mesh.normals.empty() ? Shading::flat : Shading::gouraud;
    return result;
}

// With one normal; beyond them a corner gets a vertex of its own without looking further.
constexpr std::size_t max_compared_vertices = 64;

void add_vertex_like(mesh::Mesh& mesh, std::uint32_t vertex) {
    const auto repeat = [&](auto& attribute) {
        if (!attribute.empty()) attribute.push_back(attribute[vertex]);
    };
    repeat(mesh.positions);
    repeat(mesh.normals);
    repeat(mesh.texture_coordinates);
    repeat(mesh.colors);
}

// Gives the mesh its normals. Corners with further ones become vertices of their own.
void set_normals(mesh::Mesh& mesh, LeanShading& lean, const std::vector<std::uint32_t>& first_at_position) {
    mesh.normals = std::move(lean.normals);
    // The first one comes before the others.
    for (std::uint32_t v = 0; v < first_at_position.size(); ++v) mesh.normals[v] = mesh.normals[first_at_position[v]];
    constexpr std::uint32_t none = 0xffffffffu;
    struct Added {
        std::uint32_t source, before;  // the one added before with the same normal
    };
    std::vector<Added> added;
    std::vector<std::uint32_t> last(lean.further_normals.size(), none);  // of each normal, the last one added
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const FurtherNormal& further : lean.further) {
        std::uint32_t& vertex = mesh.triangles[further.corner / 3][further.corner % 3];
        std::uint32_t found = last[further.normal];
        for (std::size_t i = 1; i < max_compared_vertices && found != none && added[found].source != vertex; ++i)
            found = added[found].before;
        if (found == none || added[found].source != vertex) {
            found = static_cast<std::uint32_t>(added.size());
            add_vertex_like(mesh, vertex);
            mesh.normals.back() = lean.further_normals[further.normal];
            added.push_back({vertex, std::exchange(last[further.normal], found)});
        }
        vertex = first + found;
    }
}

// The triangles of one shading with the vertices that they use, in the same order.
Primitive part_of(const Primitive& whole_primitive, const std::vector<std::uint8_t>& gouraud, Shading shading) {
    const mesh::Mesh& from = whole_primitive.mesh;
    Primitive part{shading, whole_primitive.material, {}};
    mesh::Mesh& to = part.mesh;
    constexpr std::uint32_t unused = 0xffffffffu;
    std::vector<std::uint32_t> number(from.positions.size(), unused);
    for (std::size_t t = 0; t < from.triangles.size(); ++t) {
        if ((gouraud[t] != 0) != (shading == Shading::gouraud)) continue;
        to.triangles.push_back(from.triangles[t]);
        for (const std::uint32_t v : from.triangles[t]) number[v] = 0;
    }
    const auto copy_used = [&](const auto& attribute, auto& target) {
        for (std::size_t v = 0; v < attribute.size(); ++v)
            if (number[v] != unused) target.push_back(attribute[v]);
    };
    copy_used(from.positions, to.positions);
    if (shading == Shading::gouraud) copy_used(from.normals, to.normals);
    copy_used(from.texture_coordinates, to.texture_coordinates);
    copy_used(from.colors, to.colors);
    std::uint32_t next = 0;
    for (std::uint32_t& n : number)
        if (n != unused) n = next++;
    for (mesh::Triangle& t : to.triangles)
        for (std::uint32_t& v : t) v = number[v];
    return part;
}

// The primitive by itself or, where it is lean, its Gouraud and its flat part.
std::vector<Primitive> Reader::read_shaded(const json& json_primitive) {
    const json* extras = find(json_primitive, "extras");
    const json* ours = extras ? find(*extras, "lodestream") : nullptr;
    const json* view = ours ? find(*ours, "shading") : nullptr;
    Geometry geometry = read_geometry(json_primitive, view != nullptr);
    const std::vector<std::uint32_t>& first_at_position = geometry.first_at_position;
    Primitive primitive = read_primitive(json_primitive, std::move(geometry.mesh));
    std::vector<Primitive> parts;
    if (!view) {
        parts.push_back(std::move(primitive));
        return parts;
    }
    require(primitive.shading == Shading::flat, "lean shading beside normals");
    const bool apart = first_at_position.empty();
    Result<LeanShading> lean = decode_lean_shading(
        primitive.mesh.positions,
        apart ? primitive.mesh.triangles : between_positions(primitive.mesh.triangles, first_at_position),
        take_view(whole(*view)));
    if (!lean) throw Refusal{fail(lean.error().code, "GLB: " + lean.error().message)};
    set_normals(primitive.mesh, *lean, first_at_position);
    const bool mixed = std::find(lean->gouraud.begin(), lean->gouraud.end(), 0) != lean->gouraud.end();
    primitive.shading = Shading::gouraud;
    if (!mixed) {
        parts.push_back(std::move(primitive));
        return parts;
    }
    for (const Shading shading : {Shading::gouraud, Shading::flat}) {
        Primitive part = part_of(primitive, lean->gouraud, shading);
        if (!part.mesh.triangles.empty()) parts.push_back(std::move(part));
    }
    return parts;
}

// The one node that draws the one mesh; none in an empty level.
const json* Reader::find_node() const {
    const json& nodes = array_of(root_, "nodes");
    require(array_of(root_, "scenes").size() == 1, "one scene is expected");
    require(nodes.size() == array_of(root_, "meshes").size() && nodes.size() <= 1,
            "one node with one mesh is expected");
    if (nodes.empty()) return nullptr;
    require(whole(member(nodes[0], "mesh")) == 0, "a reference to a missing mesh");
    for (const char* unexpected : {"matrix", "rotation", "scale", "children", "skin", "weights"})
        require(!find(nodes[0], unexpected), "a node that does more than to move its mesh");
    return &nodes[0];
}

Decoded Reader::read() {
    check_head();
    Decoded result;
    result.extras_json = read_extras();
    for (const json& image : array_of(root_, "images")) result.images.push_back(read_image(image));
    for (const json& material : array_of(root_, "materials")) result.materials.push_back(read_material(material));
    const json* node = find_node();
    if (!node) return result;
    constexpr double largest = std::numeric_limits<double>::max();
    result.origin = vector_or(*node, "translation", -largest, largest, Vec3d(0.0));
    for (const json& primitive : array_of(element("meshes", 0), "primitives"))
        for (Primitive& part : read_shaded(primitive)) result.primitives.push_back(std::move(part));
    return result;
}

}  // namespace

Result<Decoded> decode_level(std::span<const std::byte> glb) {
    try {
        Result<Glb> parts = split_glb(glb);
        if (!parts) return parts.error();
        return Reader(std::move(*parts)).read();
    } catch (const Refusal& refusal) {
        return refusal.error;
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "GLB: not enough memory to decode");
    } catch (const std::exception& error) {
        return invalid_input(std::string("GLB: ") + error.what());
    }
}

}  // namespace lodestream::codec
