#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "common/base/z_order.h"
#include "common/codec/glb.h"
#include "common/codec/points_codec.h"
#include "common/codec/points_compression.h"
#include "common/codec/points_layout.h"

namespace lodestream::codec {
namespace {

using nlohmann::json;
using Steps = std::array<std::uint16_t, 3>;

Status check_points(const Points& points) {
    const points::PointCloud& cloud = points.cloud;
    const std::size_t count = cloud.positions.size();
    const auto complete = [&](std::size_t size) { return size == 0 || size == count; };
    if (count > points::max_points) return fail(ErrorCode::limit_exceeded, "encode: the cloud has too many points");
    if (!complete(cloud.normals.size()) || !complete(cloud.colors.size()))
        return invalid_input("encode: an attribute does not cover every point");
    if (!all_finite(points.origin)) return invalid_input("encode: the cloud's origin is not finite");
    if (points.levels.size() > max_point_levels)
        return fail(ErrorCode::limit_exceeded, "encode: the cloud has too many levels");
    return Nothing{};
}

Result<std::vector<Steps>> steps_of(const std::vector<Vec3f>& positions, const QuantizationGrid& grid) {
    if (!all_finite(grid.origin) || !std::isfinite(grid.range) || grid.range <= 0.0f ||
        grid.bits != point_position_bits)
        return invalid_input("encode: the quantization grid is not valid for points");
    std::vector<Steps> steps(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<int>(axis);
            const double place = std::round((static_cast<double>(positions[i][k]) - grid.origin[k]) / grid.step());
            if (!(place >= 0.0 && place <= 65535.0))  // NaN too
                return invalid_input("encode: point " + std::to_string(i) + " lies outside the quantization grid");
            steps[i][axis] = static_cast<std::uint16_t>(place);
        }
    return steps;
}

std::array<std::int8_t, 4> packed_normal(const Vec3f& normal) {
    std::array<std::int8_t, 4> packed{0, 127, 0, 0};
    constexpr double packing_error = 0.01;  // what was unpacked is packed alike
    Vec3d n(normal);
    const double size = glm::length(n);
    if (!std::isfinite(size) || size <= 0.0) return packed;
    if (std::abs(size - 1.0) > packing_error) n /= size;
    for (std::size_t k = 0; k < 3; ++k)
        packed[k] = static_cast<std::int8_t>(std::clamp(std::lround(n[static_cast<int>(k)] * 127.0), -127l, 127l));
    return packed;
}

std::vector<std::byte> interleave(const points::PointCloud& cloud, const std::vector<Steps>& steps,
                                  const PointLayout& layout) {
    std::vector<std::byte> bytes(steps.size() * layout.stride());
    for (std::size_t i = 0; i < steps.size(); ++i) {
        std::byte* point = bytes.data() + i * layout.stride();
        std::memcpy(point, steps[i].data(), sizeof(Steps));
        if (layout.has_normals) {
            const auto normal = packed_normal(cloud.normals[i]);
            std::memcpy(point + PointLayout::normal_offset, normal.data(), normal.size());
        }
        if (layout.has_colors) std::memcpy(point + layout.color_offset(), &cloud.colors[i], sizeof(Rgba8));
    }
    return bytes;
}

json level_objects(const std::vector<points::Level>& levels) {
    json array = json::array();
    for (const points::Level& level : levels)
        array.push_back({{"points", level.points},
                         {"rms_error", level.error.rms},
                         {"max_error", level.error.max},
                         {"radius", level.radius}});
    return array;
}

json position_accessor(const std::vector<Steps>& steps) {
    Steps low = steps.front(), high = low;
    for (const Steps& p : steps)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
        }
    return {{"bufferView", 0},
            {"componentType", gltf_unsigned_short},
            {"count", steps.size()},
            {"type", "VEC3"},
            {"min", low},
            {"max", high}};
}

json normalized_accessor(std::size_t view, std::size_t offset, int component_type, const char* type,
                         std::size_t count) {
    return {{"bufferView", view}, {"byteOffset", offset}, {"componentType", component_type},
            {"normalized", true}, {"count", count},       {"type", type}};
}

json buffer_view(std::size_t buffer, std::size_t offset, std::size_t bytes, std::size_t stride) {
    json view{{"buffer", buffer}, {"byteLength", bytes}, {"byteStride", stride}, {"target", gltf_array_buffer}};
    if (offset > 0) view["byteOffset"] = offset;
    return view;
}

// What differs between the forms.
struct Content {
    json attributes = json::object(), accessors = json::array(), views = json::array(), buffers = json::array();
    std::vector<const char*> extensions{quantization_extension};
    std::vector<std::byte> binary;

    void add(const char* name, json accessor) {
        attributes[name] = accessors.size();
        accessors.push_back(std::move(accessor));
    }
};

Content plain_content(const points::PointCloud& cloud, const std::vector<Steps>& steps, const PointLayout& layout) {
    Content content;
    content.binary = interleave(cloud, steps, layout);
    content.add("POSITION", position_accessor(steps));
    if (layout.has_normals)
        content.add("NORMAL", normalized_accessor(0, PointLayout::normal_offset, gltf_byte, "VEC3", steps.size()));
    if (layout.has_colors)
        content.add("COLOR_0", normalized_accessor(0, layout.color_offset(), gltf_unsigned_byte, "VEC4", steps.size()));
    content.buffers.push_back({{"byteLength", content.binary.size()}});
    content.views.push_back(buffer_view(0, 0, content.binary.size(), layout.stride()));
    return content;
}

// Adds a stream to the first buffer; the second one is what it stands for, and has no bytes.
void add_stream(Content& content, std::span<const std::byte> values, std::size_t stride, const char* filter) {
    constexpr std::size_t alignment = 4;
    const std::vector<std::byte> stream = compressed(values, stride);
    const std::size_t offset = content.binary.size();
    const std::size_t whole = content.views.empty() ? 0 : content.buffers[1]["byteLength"].get<std::size_t>();
    json view = buffer_view(1, whole, values.size(), stride);
    json& extension = view["extensions"][meshopt_extension];
    extension = {{"buffer", 0},          {"byteOffset", offset}, {"byteLength", stream.size()},
                 {"byteStride", stride}, {"mode", "ATTRIBUTES"}, {"count", values.size() / stride}};
    if (filter) extension["filter"] = filter;
    content.views.push_back(std::move(view));
    content.binary.insert(content.binary.end(), stream.begin(), stream.end());
    content.binary.resize((content.binary.size() + alignment - 1) / alignment * alignment);
    content.buffers = {
        {{"byteLength", content.binary.size()}},
        {{"byteLength", whole + values.size()}, {"extensions", {{meshopt_extension, {{"fallback", true}}}}}}};
}

std::vector<Vec3f> unit_normals(std::vector<Vec3f> normals) {
    for (Vec3f& n : normals) {
        const double size = glm::length(Vec3d(n));
        n = std::isfinite(size) && size > 0.0 ? Vec3f(Vec3d(n) / size) : Vec3f(0.0f, 1.0f, 0.0f);
    }
    return normals;
}

Content lean_content(const points::PointCloud& cloud, const std::vector<Steps>& steps, bool has_colors) {
    Content content;
    content.extensions.push_back(meshopt_extension);
    const PointLayout positions;
    add_stream(content, interleave({cloud.positions, {}, {}}, steps, positions), positions.stride(), nullptr);
    content.add("POSITION", position_accessor(steps));
    if (!cloud.normals.empty()) {
        add_stream(content, octahedral(unit_normals(cloud.normals)), sizeof(std::uint32_t), octahedral_filter);
        content.add("NORMAL", normalized_accessor(content.views.size() - 1, 0, gltf_byte, "VEC3", steps.size()));
    }
    if (has_colors) {
        add_stream(content, std::as_bytes(std::span(cloud.colors)), sizeof(Rgba8), nullptr);
        content.add("COLOR_0",
                    normalized_accessor(content.views.size() - 1, 0, gltf_unsigned_byte, "VEC4", steps.size()));
    }
    return content;
}

json empty_document(const std::vector<points::Level>& levels) {
    json root;
    root["asset"] = {{"version", "2.0"}, {"generator", "lodestream"}};
    root["asset"]["extras"]["lodestream"]["levels"] = level_objects(levels);
    root["scene"] = 0;
    root["scenes"] = json::array({json::object()});
    return root;
}

json document(const Points& points, const Vec4f& base_color, const Content& content) {
    const Vec3d translation = points.origin + Vec3d(points.grid.origin);
    const double step = points.grid.step();
    json root = empty_document(points.levels);
    root["extensionsUsed"] = root["extensionsRequired"] = content.extensions;
    root["scenes"][0]["nodes"] = {0};
    root["nodes"] = json::array(
        {{{"mesh", 0}, {"translation", {translation.x, translation.y, translation.z}}, {"scale", {step, step, step}}}});
    root["meshes"] =
        json::array({{{"primitives",
                       json::array({{{"mode", gltf_points}, {"material", 0}, {"attributes", content.attributes}}})}}});
    root["accessors"] = content.accessors;
    root["materials"] = json::array(
        {{{"pbrMetallicRoughness",
           {{"baseColorFactor", {base_color.r, base_color.g, base_color.b, base_color.a}}, {"metallicFactor", 0}}}}});
    root["buffers"] = content.buffers;
    root["bufferViews"] = content.views;
    return root;
}

bool is_constant(const std::vector<Rgba8>& colors) {
    return std::all_of(colors.begin(), colors.end(), [&](Rgba8 c) { return c == colors.front(); });
}

// Of the cloud, with its colour where that is constant.
Vec4f base_color_of(const Points& points) {
    const std::vector<Rgba8>& colors = points.cloud.colors;
    Vec4f base_color = points.base_color;
    if (!colors.empty() && is_constant(colors)) base_color *= Vec4f(colors.front()) / 255.0f;
    for (int c = 0; c < 4; ++c)
        base_color[c] = std::isfinite(base_color[c]) ? std::clamp(base_color[c], 0.0f, 1.0f) : 1.0f;
    return base_color;
}

// Steps a power of two times as long, as far as the discs of the whole level allow.
QuantizationGrid lean_grid(const Points& points) {
    QuantizationGrid grid = points.grid;
    if (points.levels.empty() || !(grid.range > 0.0f)) return grid;
    const double wanted = lean_step_share * points.levels.front().radius / grid.step();
    constexpr int most = point_position_bits - 1;
    if (wanted > 1.0)  // not NaN
        grid.range = std::ldexp(grid.range, std::min(std::ilogb(wanted), most));
    return std::isfinite(grid.range) ? grid : points.grid;
}

template <class Value>
std::vector<Value> in_order(const std::vector<Value>& values, const std::vector<std::uint32_t>& order) {
    std::vector<Value> moved;
    if (values.empty()) return moved;
    moved.reserve(order.size());
    for (const std::uint32_t i : order) moved.push_back(values[i]);
    return moved;
}

// Along the Z-order curve.
points::PointCloud along_curve(const points::PointCloud& cloud, std::vector<Steps>& steps) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> places;
    for (std::uint32_t i = 0; i < steps.size(); ++i)
        places.emplace_back(z_order(steps[i][0], steps[i][1], steps[i][2]), i);
    std::sort(places.begin(), places.end());
    std::vector<std::uint32_t> order;
    for (const auto& [place, i] : places) order.push_back(i);
    steps = in_order(steps, order);
    return {in_order(cloud.positions, order), in_order(cloud.normals, order), in_order(cloud.colors, order)};
}

}  // namespace

QuantizationGrid point_grid(const Box& bounds) {
    QuantizationGrid grid = choose_grid(bounds, 0.0, 0.0);
    grid.bits = point_position_bits;
    return grid;
}

Result<EncodedPoints> encode_points(const Points& points) {
    if (Status sound = check_points(points); !sound) return sound.error();
    Result<std::vector<Steps>> steps = steps_of(points.cloud.positions, points.grid);
    if (!steps) return steps.error();
    const PointLayout layout{!points.cloud.normals.empty(), !is_constant(points.cloud.colors)};
    const Content content = steps->empty() ? Content{} : plain_content(points.cloud, *steps, layout);
    Result<std::vector<std::byte>> glb =
        join_glb(steps->empty() ? empty_document(points.levels) : document(points, base_color_of(points), content),
                 content.binary);
    if (!glb) return glb.error();
    const std::uint64_t size = glb->size();
    return EncodedPoints{*std::move(glb), size - steps->size() * layout.stride(), layout.stride()};
}

Result<std::vector<std::byte>> encode_lean_points(const Points& points) {
    if (Status sound = check_points(points); !sound) return sound.error();
    Points level;
    level.grid = lean_grid(points);
    level.origin = points.origin;
    if (!points.levels.empty()) level.levels = {points.levels.front()};
    Result<std::vector<Steps>> steps = steps_of(points.cloud.positions, level.grid);
    if (!steps) return steps.error();
    if (steps->empty()) return join_glb(empty_document(level.levels), {});
    const points::PointCloud sorted = along_curve(points.cloud, *steps);
    Content content = lean_content(sorted, *steps, !is_constant(sorted.colors));
    const json root = document(level, base_color_of(points), content);
    return join_glb(root, std::move(content.binary));
}

}  // namespace lodestream::codec
