#include "tests/bench/peer_codecs.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/core/encoder_buffer.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <stdexcept>

#include "common/mesh/operations.h"
#include "tests/bench/stopwatch.h"

namespace lodestream::bench {
namespace {

using Bytes = std::vector<std::byte>;

// ---- Draco ----

template <class Value>
void add_attribute(draco::Mesh& target, draco::GeometryAttribute::Type type, int components, draco::DataType data_type,
                   const std::vector<Value>& values) {
    if (values.empty()) return;
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, static_cast<std::int8_t>(components), data_type, data_type == draco::DT_UINT8,
                   sizeof(Value), 0);
    const int id = target.AddAttribute(attribute, true, static_cast<unsigned>(values.size()));
    for (std::uint32_t v = 0; v < values.size(); ++v)
        target.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &values[v]);
}

std::unique_ptr<draco::Mesh> draco_mesh(const mesh::Mesh& part) {
    auto result = std::make_unique<draco::Mesh>();
    result->set_num_points(static_cast<unsigned>(part.positions.size()));
    result->SetNumFaces(part.triangles.size());
    for (std::uint32_t f = 0; f < part.triangles.size(); ++f) {
        const mesh::Triangle& t = part.triangles[f];
        result->SetFace(draco::FaceIndex(f),
                        {{draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])}});
    }
    add_attribute(*result, draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32, part.positions);
    add_attribute(*result, draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32, part.normals);
    add_attribute(*result, draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32, part.texture_coordinates);
    add_attribute(*result, draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8, part.colors);
    result->DeduplicateAttributeValues();
    result->DeduplicatePointIds();
    return result;
}

Bytes draco_stream(const mesh::Mesh& part, const Box& bounds, const DracoSettings& settings) {
    const std::unique_ptr<draco::Mesh> source = draco_mesh(part);
    draco::ExpertEncoder encoder(*source);
    encoder.SetSpeedOptions(settings.speed, settings.speed);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    const Vec3f origin(bounds.min);
    const Vec3d extent = bounds.extent();
    const auto range = static_cast<float>(std::max({extent.x, extent.y, extent.z}));
    for (int a = 0; a < source->num_attributes(); ++a) switch (source->attribute(a)->attribute_type()) {
            case draco::GeometryAttribute::POSITION:
                encoder.SetAttributeExplicitQuantization(a, settings.position_bits, 3, &origin[0], range);
                break;
            case draco::GeometryAttribute::NORMAL:
                encoder.SetAttributeQuantization(a, settings.normal_bits);
                break;
            case draco::GeometryAttribute::TEX_COORD:
                encoder.SetAttributeQuantization(a, settings.texture_coordinate_bits);
                break;
            default:
                break;
        }
    draco::EncoderBuffer buffer;
    if (!encoder.EncodeToBuffer(&buffer).ok()) throw std::runtime_error("Draco refuses the level");
    const auto* bytes = reinterpret_cast<const std::byte*>(buffer.data());
    return {bytes, bytes + buffer.size()};
}

std::unique_ptr<draco::Mesh> decoded_by_draco(std::span<const std::byte> stream) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) throw std::runtime_error("Draco does not decode what it encoded");
    return std::move(decoded).value();
}

template <class Value, int Components>
std::vector<Value> values_of(const draco::Mesh& from, draco::GeometryAttribute::Type type) {
    std::vector<Value> result;
    const draco::PointAttribute* attribute = from.GetNamedAttribute(type);
    if (!attribute) return result;
    result.resize(from.num_points());
    for (std::uint32_t p = 0; p < from.num_points(); ++p)
        attribute->ConvertValue(attribute->mapped_index(draco::PointIndex(p)), Components, &result[p][0]);
    return result;
}

mesh::Mesh mesh_of(const draco::Mesh& from, std::uint32_t material) {
    mesh::Mesh to;
    to.positions = values_of<Vec3f, 3>(from, draco::GeometryAttribute::POSITION);
    to.normals = values_of<Vec3f, 3>(from, draco::GeometryAttribute::NORMAL);
    to.texture_coordinates = values_of<Vec2f, 2>(from, draco::GeometryAttribute::TEX_COORD);
    to.colors = values_of<Rgba8, 4>(from, draco::GeometryAttribute::COLOR);
    for (std::uint32_t f = 0; f < from.num_faces(); ++f) {
        const draco::Mesh::Face& face = from.face(draco::FaceIndex(f));
        to.triangles.push_back({face[0].value(), face[1].value(), face[2].value()});
    }
    to.triangle_materials.assign(to.triangles.size(), material);
    return to;
}

// ---- meshoptimizer ----

// Attribute values as integers, `size` bytes a vertex.
struct Stream {
    std::size_t size = 0;
    bool is_octahedral = false;
    std::vector<unsigned char> values;
};

struct PackedPart {
    std::vector<Stream> streams;  // positions, then normals, texture coordinates and colours where there are any
    std::vector<std::uint32_t> indices;
    std::size_t vertices = 0;
    std::uint32_t material = 0;
    // Encoded.
    std::vector<std::vector<unsigned char>> bytes;
    std::vector<unsigned char> index_bytes;
};

// Two or three of `Values`' components as whole steps of `range` / (2^bits - 1), in four shorts or two.
template <class Values>
Stream as_shorts(const Values& values, int components, const Vec3d& origin, double range, int bits) {
    const std::size_t shorts = components == 3 ? 4 : 2;  // a multiple of four bytes
    Stream stream{2 * shorts, false, std::vector<unsigned char>(2 * shorts * values.size())};
    const double steps = std::ldexp(1.0, bits) - 1.0;
    for (std::size_t v = 0; v < values.size(); ++v)
        for (int c = 0; c < components; ++c) {
            const double share = range > 0.0 ? (double(values[v][c]) - origin[c]) / range : 0.0;
            const auto code = static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * steps));
            std::memcpy(&stream.values[2 * (shorts * v + static_cast<std::size_t>(c))], &code, sizeof code);
        }
    return stream;
}

Stream as_octahedral(const std::vector<Vec3f>& normals, int bits) {
    std::vector<glm::vec4> four;
    for (const Vec3f& n : normals) four.emplace_back(n, 0.0f);
    Stream stream{bits > 8 ? std::size_t{8} : std::size_t{4}, true, {}};
    stream.values.resize(stream.size * normals.size());
    meshopt_encodeFilterOct(stream.values.data(), normals.size(), stream.size, bits, &four[0][0]);
    return stream;
}

// A cube around the texture coordinates, which may lie outside of [0, 1].
std::pair<Vec3d, double> range_of(const std::vector<Vec2f>& values) {
    Box box;
    for (const Vec2f& v : values) box.add(Vec3d(v.x, v.y, 0.0));
    const Vec3d extent = box.extent();
    return {box.min, std::max(extent.x, extent.y)};
}

PackedPart packed(mesh::Mesh part, const Box& bounds, const MeshoptSettings& settings) {
    PackedPart result;
    result.material = mesh::material_of(part, 0);
    for (const mesh::Triangle& t : part.triangles) result.indices.insert(result.indices.end(), t.begin(), t.end());
    meshopt_optimizeVertexCacheStrip(result.indices.data(), result.indices.data(), result.indices.size(),
                                     part.positions.size());
    std::vector<std::uint32_t> places(part.positions.size());
    result.vertices = meshopt_optimizeVertexFetchRemap(places.data(), result.indices.data(), result.indices.size(),
                                                       part.positions.size());
    meshopt_remapIndexBuffer(result.indices.data(), result.indices.data(), result.indices.size(), places.data());
    const auto reorder = [&](auto& values) {
        if (values.empty()) return;
        auto moved = values;
        meshopt_remapVertexBuffer(moved.data(), values.data(), values.size(), sizeof values[0], places.data());
        moved.resize(result.vertices);
        values = std::move(moved);
    };
    reorder(part.positions);
    reorder(part.normals);
    reorder(part.texture_coordinates);
    reorder(part.colors);
    const Vec3d extent = bounds.extent();
    result.streams.push_back(
        as_shorts(part.positions, 3, bounds.min, std::max({extent.x, extent.y, extent.z}), settings.position_bits));
    if (!part.normals.empty()) result.streams.push_back(as_octahedral(part.normals, settings.normal_bits));
    if (!part.texture_coordinates.empty()) {
        const auto [origin, range] = range_of(part.texture_coordinates);
        result.streams.push_back(
            as_shorts(part.texture_coordinates, 2, origin, range, settings.texture_coordinate_bits));
    }
    if (!part.colors.empty()) {
        Stream colors{4, false, std::vector<unsigned char>(4 * part.colors.size())};
        std::memcpy(colors.values.data(), part.colors.data(), colors.values.size());
        result.streams.push_back(std::move(colors));
    }
    return result;
}

void encode(PackedPart& part) {
    for (const Stream& stream : part.streams) {
        auto& bytes = part.bytes.emplace_back(meshopt_encodeVertexBufferBound(part.vertices, stream.size));
        bytes.resize(
            meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), stream.values.data(), part.vertices, stream.size));
    }
    part.index_bytes.resize(meshopt_encodeIndexBufferBound(part.indices.size(), part.vertices));
    part.index_bytes.resize(meshopt_encodeIndexBuffer(part.index_bytes.data(), part.index_bytes.size(),
                                                      part.indices.data(), part.indices.size()));
}

// Into new memory, as a loader does.
PackedPart decoded(const PackedPart& part) {
    PackedPart result;
    result.material = part.material;
    result.vertices = part.vertices;
    result.indices.resize(part.indices.size());
    int failures = meshopt_decodeIndexBuffer(result.indices.data(), result.indices.size(), sizeof(std::uint32_t),
                                             part.index_bytes.data(), part.index_bytes.size());
    for (std::size_t s = 0; s < part.streams.size(); ++s) {
        Stream stream{part.streams[s].size, part.streams[s].is_octahedral,
                      std::vector<unsigned char>(part.vertices * part.streams[s].size)};
        failures += meshopt_decodeVertexBuffer(stream.values.data(), part.vertices, stream.size, part.bytes[s].data(),
                                               part.bytes[s].size());
        if (stream.is_octahedral) meshopt_decodeFilterOct(stream.values.data(), part.vertices, stream.size);
        result.streams.push_back(std::move(stream));
    }
    if (failures != 0) throw std::runtime_error("meshoptimizer does not decode what it encoded");
    return result;
}

// Two or three components back from whole steps.
template <class Value>
std::vector<Value> from_shorts(const Stream& stream, std::size_t vertices, int components, const Vec3d& origin,
                               double range, int bits) {
    std::vector<Value> values(vertices);
    const double step = range / (std::ldexp(1.0, bits) - 1.0);
    for (std::size_t v = 0; v < vertices; ++v)
        for (int c = 0; c < components; ++c) {
            std::uint16_t code = 0;
            std::memcpy(&code, &stream.values[stream.size * v + 2 * static_cast<std::size_t>(c)], sizeof code);
            values[v][c] = static_cast<float>(origin[c] + code * step);
        }
    return values;
}

std::vector<Vec3f> from_octahedral(const Stream& stream, std::size_t vertices) {
    std::vector<Vec3f> normals(vertices);
    for (std::size_t v = 0; v < vertices; ++v) {
        for (int c = 0; c < 3; ++c) {
            const unsigned char* at = &stream.values[stream.size * v];
            std::int16_t code = 0;
            if (stream.size == 8)
                std::memcpy(&code, at + 2 * c, sizeof code);
            else
                code = static_cast<std::int8_t>(at[c]);
            normals[v][c] = code;
        }
        normals[v] = normalize(normals[v]);
    }
    return normals;
}

mesh::Mesh mesh_of(const PackedPart& part, const mesh::Mesh& source, const Box& bounds,
                   const MeshoptSettings& settings) {
    mesh::Mesh mesh;
    const Vec3d extent = bounds.extent();
    std::size_t next = 0;
    mesh.positions = from_shorts<Vec3f>(part.streams[next++], part.vertices, 3, bounds.min,
                                        std::max({extent.x, extent.y, extent.z}), settings.position_bits);
    if (!source.normals.empty()) mesh.normals = from_octahedral(part.streams[next++], part.vertices);
    if (!source.texture_coordinates.empty()) {
        const auto [origin, range] = range_of(source.texture_coordinates);
        mesh.texture_coordinates =
            from_shorts<Vec2f>(part.streams[next++], part.vertices, 2, origin, range, settings.texture_coordinate_bits);
    }
    if (!source.colors.empty()) {
        mesh.colors.resize(part.vertices);
        std::memcpy(mesh.colors.data(), part.streams[next].values.data(), part.streams[next].values.size());
    }
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3)
        mesh.triangles.push_back({part.indices[i], part.indices[i + 1], part.indices[i + 2]});
    mesh.triangle_materials.assign(mesh.triangles.size(), part.material);
    return mesh;
}

}  // namespace

std::vector<mesh::Mesh> by_material(const mesh::Mesh& level) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> groups;
    for (std::uint32_t t = 0; t < level.triangles.size(); ++t) groups[mesh::material_of(level, t)].push_back(t);
    std::vector<mesh::Mesh> parts;
    for (const auto& [material, triangles] : groups) parts.push_back(mesh::part(level, triangles));
    return parts;
}

double draco_ms(const std::vector<std::span<const std::byte>>& streams, int turns) {
    return least_ms(turns, [&] {
        for (const auto& stream : streams) decoded_by_draco(stream);
    });
}

double draco_arrays_ms(const std::vector<std::span<const std::byte>>& streams, int turns) {
    return least_ms(turns, [&] {
        for (const auto& stream : streams) (void)mesh_of(*decoded_by_draco(stream), 0);
    });
}

Compressed by_draco(const mesh::Mesh& level, const DracoSettings& settings, int turns) {
    Compressed made;
    const std::vector<mesh::Mesh> parts = by_material(level);
    std::vector<Bytes> streams;
    const Stopwatch watch;
    for (const mesh::Mesh& part : parts) streams.push_back(draco_stream(part, mesh::bounds(level), settings));
    made.encode_ms = watch.elapsed().cpu_ms;
    std::vector<std::span<const std::byte>> spans;
    for (std::size_t i = 0; i < streams.size(); ++i) {
        made.bytes += streams[i].size();
        spans.emplace_back(streams[i]);
        mesh::append(made.decoded, mesh_of(*decoded_by_draco(streams[i]), mesh::material_of(parts[i], 0)));
    }
    made.decode_ms = draco_ms(spans, turns);
    made.arrays_ms = draco_arrays_ms(spans, turns);
    return made;
}

Compressed by_meshopt(const mesh::Mesh& level, const MeshoptSettings& settings, int turns) {
    Compressed made;
    const Box bounds = mesh::bounds(level);
    const std::vector<mesh::Mesh> sources = by_material(level);
    std::vector<PackedPart> parts;
    const Stopwatch watch;
    for (const mesh::Mesh& source : sources) encode(parts.emplace_back(packed(source, bounds, settings)));
    made.encode_ms = watch.elapsed().cpu_ms;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        made.bytes += parts[i].index_bytes.size();
        for (const auto& bytes : parts[i].bytes) made.bytes += bytes.size();
        mesh::append(made.decoded, mesh_of(decoded(parts[i]), sources[i], bounds, settings));
    }
    made.decode_ms = least_ms(turns, [&] {
        for (const PackedPart& part : parts) (void)decoded(part);
    });
    return made;
}

}  // namespace lodestream::bench
