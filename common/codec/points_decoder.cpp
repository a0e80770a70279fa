#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <string>

#include "common/codec/glb.h"
#include "common/codec/points_codec.h"
#include "common/codec/points_compression.h"
#include "common/codec/points_layout.h"

namespace lodestream::codec {
namespace {

using nlohmann::json;

// Thrown and caught in this file only, as nlohmann's own exceptions are.
struct Refusal {
    std::string what;
};

void require(bool holds, const char* what) {
    if (!holds) throw Refusal{what};
}

std::uint64_t whole(const json& object, const char* name) {
    const json& value = object.at(name);
    require(value.is_number_unsigned(), "a whole number is expected");
    return value.get<std::uint64_t>();
}

double number(const json& value, double low, double high) {
    require(value.is_number(), "a number is expected");
    const double x = value.get<double>();
    require(x >= low && x <= high, "a number is out of range");
    return x;
}

template <class Vector>
Vector vector_of(const json& value, double low, double high) {
    require(value.is_array() && value.size() == static_cast<std::size_t>(Vector::length()), "a vector is expected");
    Vector result;
    for (int c = 0; c < Vector::length(); ++c)
        result[c] = static_cast<typename Vector::value_type>(number(value.at(static_cast<std::size_t>(c)), low, high));
    return result;
}

const json& only(const json& root, const char* array) {
    const json& elements = root.at(array);
    require(elements.is_array() && elements.size() == 1, "one element is expected");
    return elements.at(0);
}

std::vector<points::Level> read_levels(const json& root) {
    constexpr double largest = std::numeric_limits<double>::max();
    const json& array = root.at("asset").at("extras").at("lodestream").at("levels");
    require(array.is_array() && array.size() <= max_point_levels, "levels are expected");
    std::vector<points::Level> levels;
    for (const json& object : array) {
        const points::Level level{
            whole(object, "points"),
            {number(object.at("rms_error"), 0.0, largest), number(object.at("max_error"), 0.0, largest)},
            number(object.at("radius"), 0.0, largest)};
        require(levels.empty() || (level.points < levels.back().points && level.radius >= levels.back().radius),
                "levels are not in order");
        levels.push_back(level);
    }
    return levels;
}

struct Attribute {
    const char* name;
    int component_type;
    const char* type;
};
constexpr Attribute position_attribute{"POSITION", gltf_unsigned_short, "VEC3"};
constexpr Attribute normal_attribute{"NORMAL", gltf_byte, "VEC3"};
constexpr Attribute color_attribute{"COLOR_0", gltf_unsigned_byte, "VEC4"};

// The checked accessor of the attribute, where it is there at all; else null.
const json* accessor_of(const json& root, const Attribute& attribute, std::uint64_t count) {
    const json& attributes = only(only(root, "meshes"), "primitives").at("attributes");
    if (!attributes.contains(attribute.name)) return nullptr;
    const json& accessor = root.at("accessors").at(whole(attributes, attribute.name));
    require(whole(accessor, "count") == count &&
                whole(accessor, "componentType") == static_cast<std::uint64_t>(attribute.component_type) &&
                accessor.at("type") == attribute.type && !accessor.contains("sparse"),
            "an accessor of an unexpected kind");
    return &accessor;
}

// Of an interleaved point, at that offset.
bool has_attribute(const json& root, const Attribute& attribute, std::size_t offset, std::uint64_t count) {
    const json* accessor = accessor_of(root, attribute, count);
    if (accessor)
        require(whole(*accessor, "bufferView") == 0 && accessor->value("byteOffset", std::uint64_t{0}) == offset,
                "an attribute at an unexpected place");
    return accessor != nullptr;
}

PointLayout read_layout(const json& root, std::uint64_t count) {
    PointLayout layout;
    require(has_attribute(root, position_attribute, 0, count), "no positions");
    layout.has_normals = has_attribute(root, normal_attribute, PointLayout::normal_offset, count);
    layout.has_colors = has_attribute(root, color_attribute, layout.color_offset(), count);
    const json& view = only(root, "bufferViews");
    require(whole(view, "byteStride") == layout.stride() && whole(view, "byteLength") == count * layout.stride() &&
                !view.contains("byteOffset"),
            "points that do not fill their buffer view");
    return layout;
}

Vec3f unpacked_normal(const std::byte* bytes) {
    std::array<std::int8_t, 3> packed{};
    std::memcpy(packed.data(), bytes, packed.size());
    const Vec3f n = Vec3f(packed[0], packed[1], packed[2]) / 127.0f;
    require(std::abs(glm::length(n) - 1.0f) < 0.01f, "a normal is not of unit length");
    return n;
}

points::PointCloud read_cloud(std::span<const std::byte> bytes, const PointLayout& layout, double step) {
    points::PointCloud cloud;
    const std::size_t count = bytes.size() / layout.stride();
    for (std::size_t i = 0; i < count; ++i) {
        const std::byte* point = bytes.data() + i * layout.stride();
        std::array<std::uint16_t, 3> steps{};
        std::memcpy(steps.data(), point, sizeof steps);
        cloud.positions.emplace_back(Vec3d(steps[0], steps[1], steps[2]) * step);
        if (layout.has_normals) cloud.normals.push_back(unpacked_normal(point + PointLayout::normal_offset));
        if (layout.has_colors) {
            std::memcpy(&cloud.colors.emplace_back(), point + layout.color_offset(), sizeof(Rgba8));
        }
    }
    return cloud;
}

bool is_lean(const json& root) {
    return root.contains("bufferViews") && root.at("bufferViews").at(0).contains("extensions");
}

// The values of an attribute's own compressed stream; empty where the attribute is not there.
std::vector<std::byte> read_stream(const Glb& glb, const Attribute& attribute, std::uint64_t count,
                                   std::size_t stride) {
    const json* accessor = accessor_of(glb.json, attribute, count);
    if (!accessor) return {};
    require(accessor->value("byteOffset", std::uint64_t{0}) == 0, "an attribute at an unexpected place");
    const json& view = glb.json.at("bufferViews").at(whole(*accessor, "bufferView"));
    const json& stream = view.at("extensions").at(meshopt_extension);
    const std::uint64_t offset = stream.value("byteOffset", std::uint64_t{0}), bytes = whole(stream, "byteLength");
    require(whole(stream, "buffer") == 0 && stream.at("mode") == "ATTRIBUTES" && whole(stream, "count") == count &&
                whole(stream, "byteStride") == stride,
            "a compressed stream of an unexpected kind");
    require(offset <= glb.binary.size() && bytes <= glb.binary.size() - offset, "a compressed stream that ends early");
    Result<std::vector<std::byte>> values = decompressed(glb.binary.subspan(offset, bytes), count, stride);
    if (!values) throw Refusal{values.error().message};
    return *std::move(values);
}

points::PointCloud read_lean_cloud(const Glb& glb, std::uint64_t count, double step) {
    constexpr std::size_t position_stride = PointLayout{}.stride(), other_stride = 4;
    const std::vector<std::byte> positions = read_stream(glb, position_attribute, count, position_stride);
    require(!positions.empty(), "no positions");
    std::vector<std::byte> normals = read_stream(glb, normal_attribute, count, other_stride);
    undo_octahedral(normals);
    const std::vector<std::byte> colors = read_stream(glb, color_attribute, count, other_stride);
    points::PointCloud cloud = read_cloud(positions, PointLayout{}, step);
    for (std::size_t at = 0; at < normals.size(); at += other_stride)
        cloud.normals.push_back(unpacked_normal(&normals[at]));
    cloud.colors.resize(colors.size() / sizeof(Rgba8));
    if (!colors.empty()) std::memcpy(cloud.colors.data(), colors.data(), colors.size());
    return cloud;
}

DecodedPoints read(const Glb& glb) {
    constexpr double largest = std::numeric_limits<float>::max();
    constexpr double steps_of_grid = (1u << point_position_bits) - 1u;
    const json& root = glb.json;
    DecodedPoints decoded;
    decoded.content.levels = read_levels(root);
    if (!root.contains("nodes")) return decoded;
    const json& node = only(root, "nodes");
    const auto scale = vector_of<Vec3d>(node.at("scale"), 0.0, largest / 65536.0);
    require(scale.x == scale.y && scale.x == scale.z, "steps differ between the axes");
    decoded.content.grid = {Vec3f(0.0f), static_cast<float>(scale.x * steps_of_grid), point_position_bits};
    require(decoded.content.grid.range > 0.0f, "steps of no length");
    decoded.content.origin = vector_of<Vec3d>(node.at("translation"), std::numeric_limits<double>::lowest(),
                                              std::numeric_limits<double>::max());
    require(whole(only(only(root, "meshes"), "primitives"), "mode") == gltf_points, "not points");
    decoded.content.base_color =
        vector_of<Vec4f>(only(root, "materials").at("pbrMetallicRoughness").at("baseColorFactor"), 0.0, 1.0);
    decoded.points = whole(root.at("accessors").at(0), "count");
    require(decoded.points > 0 && decoded.points <= points::max_points, "too many points");
    if (is_lean(root)) {
        decoded.content.cloud = read_lean_cloud(glb, decoded.points, scale.x);
        return decoded;
    }
    const PointLayout layout = read_layout(root, decoded.points);
    const std::size_t whole_size = decoded.points * layout.stride();
    decoded.content.cloud = read_cloud(glb.binary.first(std::min(glb.binary.size(), whole_size)), layout, scale.x);
    return decoded;
}

}  // namespace

Result<DecodedPoints> decode_points(std::span<const std::byte> glb) {
    try {
        const Result<Glb> parts = split_glb_start(glb);
        if (!parts) return parts.error();
        return read(*parts);
    } catch (const Refusal& refusal) {
        return invalid_input("points GLB: " + refusal.what);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "points GLB: not enough memory to decode");
    } catch (const std::exception& error) {
        return invalid_input(std::string("points GLB: ") + error.what());
    }
}

}  // namespace lodestream::codec
