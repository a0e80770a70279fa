#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/codec/glb.h"
#include "common/codec/points_codec.h"
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

json normalized_accessor(int component_type, const char* type, std::size_t offset, std::size_t count) {
    return {{"bufferView", 0},    {"byteOffset", offset}, {"componentType", component_type},
            {"normalized", true}, {"count", count},       {"type", type}};
}

json document(const Points& points, const Vec4f& base_color, const std::vector<Steps>& steps,
              const PointLayout& layout) {
    const Vec3d translation = points.origin + Vec3d(points.grid.origin);
    const double step = points.grid.step();
    json root;
    root["asset"] = {{"version", "2.0"}, {"generator", "lodestream"}};
    root["asset"]["extras"]["lodestream"]["levels"] = level_objects(points.levels);
    root["scene"] = 0;
    root["scenes"] = json::array({json::object()});
    if (steps.empty()) return root;
    root["extensionsUsed"] = root["extensionsRequired"] = {quantization_extension};
    root["scenes"][0]["nodes"] = {0};
    root["nodes"] = json::array(
        {{{"mesh", 0}, {"translation", {translation.x, translation.y, translation.z}}, {"scale", {step, step, step}}}});
    json attributes = {{"POSITION", 0}};
    json accessors = json::array({position_accessor(steps)});
    if (layout.has_normals) {
        attributes["NORMAL"] = accessors.size();
        accessors.push_back(normalized_accessor(gltf_byte, "VEC3", PointLayout::normal_offset, steps.size()));
    }
    if (layout.has_colors) {
        attributes["COLOR_0"] = accessors.size();
        accessors.push_back(normalized_accessor(gltf_unsigned_byte, "VEC4", layout.color_offset(), steps.size()));
    }
    root["meshes"] = json::array(
        {{{"primitives", json::array({{{"mode", gltf_points}, {"material", 0}, {"attributes", attributes}}})}}});
    root["accessors"] = std::move(accessors);
    root["materials"] = json::array(
        {{{"pbrMetallicRoughness",
           {{"baseColorFactor", {base_color.r, base_color.g, base_color.b, base_color.a}}, {"metallicFactor", 0}}}}});
    const std::size_t bytes = steps.size() * layout.stride();
    root["buffers"] = json::array({{{"byteLength", bytes}}});
    root["bufferViews"] = json::array(
        {{{"buffer", 0}, {"byteLength", bytes}, {"byteStride", layout.stride()}, {"target", gltf_array_buffer}}});
    return root;
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

    const std::vector<Rgba8>& colors = points.cloud.colors;
    const bool is_constant = std::all_of(colors.begin(), colors.end(), [&](Rgba8 c) { return c == colors.front(); });
    Vec4f base_color = points.base_color;
    if (!colors.empty() && is_constant) base_color *= Vec4f(colors.front()) / 255.0f;
    for (int c = 0; c < 4; ++c)
        base_color[c] = std::isfinite(base_color[c]) ? std::clamp(base_color[c], 0.0f, 1.0f) : 1.0f;

    const PointLayout layout{!points.cloud.normals.empty(), !is_constant};
    Result<std::vector<std::byte>> glb =
        join_glb(document(points, base_color, *steps, layout), interleave(points.cloud, *steps, layout));
    if (!glb) return glb.error();
    const std::uint64_t size = glb->size();
    return EncodedPoints{*std::move(glb), size - steps->size() * layout.stride(), layout.stride()};
}

}  // namespace lodestream::codec
