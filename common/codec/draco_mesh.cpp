#include "common/codec/draco_mesh.h"

// The second declares nothing without the first.
// clang-format off
#include <draco/draco_features.h>
#include <draco/compression/attributes/prediction_schemes/mesh_prediction_scheme_tex_coords_decoder.h>
// clang-format on
#include <draco/attributes/attribute_octahedron_transform.h>
#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/attributes/normal_compression_utils.h>
#include <draco/compression/attributes/prediction_schemes/mesh_prediction_scheme_tex_coords_portable_decoder.h>
#include <draco/compression/attributes/prediction_schemes/prediction_scheme_wrap_decoding_transform.h>
#include <draco/compression/bit_coders/rans_bit_decoder.h>
#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/quantization_utils.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh_attribute_corner_table.h>
#include <draco/metadata/metadata_decoder.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

namespace lodestream::codec {
namespace {

// Draco allocates for the counts that a stream declares before it reads what they count. A flat grid, the most regular
// mesh there is, codes 330 of its 2 million triangles in a byte; a stream that claims far more than this is damaged.
constexpr std::uint64_t max_elements_per_byte = 4096;
constexpr std::size_t max_attributes = 64;

// Draco makes floats value by value with a copy of each; where it can keep what the stream holds, that is done when
// they are read to where they are wanted. Older streams undo their transforms while they are read.
constexpr std::uint16_t first_version_that_keeps_steps = DRACO_BITSTREAM_VERSION(2, 0);

struct DeclaredCounts {
    std::uint16_t version = 0;
    bool is_mesh = false;
    std::uint64_t points = 0;  // of a mesh: at least this many
    std::uint64_t triangles = 0;
};

draco::DecoderBuffer buffer_of(std::span<const std::byte> bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return buffer;
}

// Counts are varints since version 2.0 of the bit stream (sequential meshes: 2.2), and 32 bits wide before.
bool read_count(draco::DecoderBuffer& buffer, bool varint, std::uint64_t& count) {
    std::uint32_t value = 0;
    if (!(varint ? draco::DecodeVarint(&value, &buffer) : buffer.Decode(&value))) return false;
    count = value;
    return true;
}

bool read_mesh_counts(draco::DecoderBuffer& buffer, std::uint8_t method, std::uint16_t version,
                      DeclaredCounts& counts) {
    if (method == draco::MESH_SEQUENTIAL_ENCODING) {
        const bool varint = version >= DRACO_BITSTREAM_VERSION(2, 2);
        return read_count(buffer, varint, counts.triangles) && read_count(buffer, varint, counts.points);
    }
    const bool varint = version >= DRACO_BITSTREAM_VERSION(2, 0);
    std::uint8_t traversal = 0;
    std::uint64_t new_vertices = 0;
    return buffer.Decode(&traversal) &&
           (version >= DRACO_BITSTREAM_VERSION(2, 2) || read_count(buffer, varint, new_vertices)) &&
           read_count(buffer, varint, counts.points) && read_count(buffer, varint, counts.triangles);
}

std::optional<DeclaredCounts> read_declared_counts(std::span<const std::byte> bytes) {
    draco::DecoderBuffer buffer = buffer_of(bytes);
    draco::DracoHeader header;
    if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) return std::nullopt;
    const auto version =
        static_cast<std::uint16_t>(DRACO_BITSTREAM_VERSION(header.version_major, header.version_minor));
    buffer.set_bitstream_version(version);
    if (version >= DRACO_BITSTREAM_VERSION(1, 3) && (header.flags & METADATA_FLAG_MASK)) {
        draco::GeometryMetadata metadata;
        if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata)) return std::nullopt;
    }
    DeclaredCounts counts;
    counts.version = version;
    counts.is_mesh = header.encoder_type == draco::TRIANGULAR_MESH;
    const bool read = counts.is_mesh ? read_mesh_counts(buffer, header.encoder_method, version, counts)
                                     : read_count(buffer, false, counts.points);
    return read ? std::optional(counts) : std::nullopt;
}

DracoAttribute::Semantic semantic_of(draco::GeometryAttribute::Type type) {
    switch (type) {
        case draco::GeometryAttribute::POSITION:
            return DracoAttribute::Semantic::position;
        case draco::GeometryAttribute::NORMAL:
            return DracoAttribute::Semantic::normal;
        case draco::GeometryAttribute::COLOR:
            return DracoAttribute::Semantic::color;
        case draco::GeometryAttribute::TEX_COORD:
            return DracoAttribute::Semantic::texture_coordinate;
        default:
            return DracoAttribute::Semantic::generic;
    }
}

template <class Number>
float to_float(const std::uint8_t* address, bool normalized) {
    Number number;
    std::memcpy(&number, address, sizeof number);
    if constexpr (std::is_floating_point_v<Number>) {
        constexpr double largest = std::numeric_limits<float>::max();
        if (std::isfinite(number)) return static_cast<float>(std::clamp<double>(number, -largest, largest));
        return std::isnan(number) ? std::numeric_limits<float>::quiet_NaN()
                                  : std::copysign(std::numeric_limits<float>::infinity(), number > 0 ? 1.0f : -1.0f);
    } else {
        if (!normalized) return static_cast<float>(number);
        const double scaled = static_cast<double>(number) / static_cast<double>(std::numeric_limits<Number>::max());
        return static_cast<float>(std::max(scaled, -1.0));
    }
}

using Conversion = float (*)(const std::uint8_t*, bool);

Conversion conversion_from(draco::DataType type) {
    switch (type) {
        case draco::DT_INT8:
            return to_float<std::int8_t>;
        case draco::DT_UINT8:
        case draco::DT_BOOL:
            return to_float<std::uint8_t>;
        case draco::DT_INT16:
            return to_float<std::int16_t>;
        case draco::DT_UINT16:
            return to_float<std::uint16_t>;
        case draco::DT_INT32:
            return to_float<std::int32_t>;
        case draco::DT_UINT32:
            return to_float<std::uint32_t>;
        case draco::DT_INT64:
            return to_float<std::int64_t>;
        case draco::DT_UINT64:
            return to_float<std::uint64_t>;
        case draco::DT_FLOAT32:
            return to_float<float>;
        case draco::DT_FLOAT64:
            return to_float<double>;
        default:
            return nullptr;
    }
}

Status check_cover(const draco::PointAttribute& source, std::uint32_t points) {
    if (!source.is_mapping_identity() && source.indices_map_size() < points)
        return invalid_input("Draco: attribute does not cover every point");
    return Nothing{};
}

std::uint32_t value_of_point(const draco::PointAttribute& source, std::uint32_t point) {
    return source.mapped_index(draco::PointIndex(point)).value();
}

// Numbers of so many bytes, side by side, one value for each point. Errors: invalid_input where one is out of range.
Status check_stored(const draco::PointAttribute& source, std::uint32_t points, std::size_t number_bytes) {
    if (const Status covers = check_cover(source, points); !covers) return covers.error();
    std::uint64_t used = source.is_mapping_identity() ? points : 0;
    if (!source.is_mapping_identity())
        for (std::uint32_t p = 0; p < points; ++p)
            used = std::max<std::uint64_t>(used, std::uint64_t{value_of_point(source, p)} + 1);
    const std::size_t size = static_cast<std::size_t>(source.num_components()) * number_bytes;
    if (source.byte_offset() != 0 || source.byte_stride() != static_cast<std::int64_t>(size) || used > source.size() ||
        used * size > source.buffer()->data_size())
        return invalid_input("Draco: attribute value out of range");
    return Nothing{};
}

// Calls read(point, its numbers) for each. pre: check_stored()
template <class Number, std::size_t Components, class Read>
void read_each(const draco::PointAttribute& source, std::uint32_t points, const Read& read) {
    std::array<Number, Components> numbers;
    const std::uint8_t* stored = source.buffer()->data();
    for (std::uint32_t p = 0; p < points; ++p) {
        std::memcpy(&numbers, stored + std::size_t{value_of_point(source, p)} * sizeof numbers, sizeof numbers);
        read(std::size_t{p}, numbers);
    }
}

// The same for a number of components, 1 … 4, that is known when it runs.
template <class Number, class Read>
void read_each(const draco::PointAttribute& source, std::uint32_t points, const Read& read) {
    switch (source.num_components()) {
        case 1:
            return read_each<Number, 1>(source, points, read);
        case 2:
            return read_each<Number, 2>(source, points, read);
        case 3:
            return read_each<Number, 3>(source, points, read);
        default:
            return read_each<Number, 4>(source, points, read);
    }
}

// Of the type that the attribute has. Errors: invalid_input where one is out of range.
template <class Number>
Status copy_values(const draco::PointAttribute& source, std::uint32_t points, std::span<Number> values) {
    if (const Status sound = check_stored(source, points, sizeof(Number)); !sound) return sound.error();
    read_each<Number>(source, points, [&](std::size_t p, const auto& numbers) {
        std::copy(numbers.begin(), numbers.end(), values.data() + p * numbers.size());
    });
    return Nothing{};
}

// What an attribute is kept as where Draco was told not to make floats of it (see decode()): steps of a grid, or of
// the square that an octahedron unfolds to.
draco::AttributeTransformType kept_as(const draco::PointAttribute& source) {
    const draco::AttributeTransformData* transform = source.GetAttributeTransformData();
    return transform ? transform->transform_type() : draco::ATTRIBUTE_INVALID_TRANSFORM;
}

// As floats are made of it.
int components_of(const draco::PointAttribute& source) {
    return kept_as(source) == draco::ATTRIBUTE_OCTAHEDRON_TRANSFORM ? 3 : source.num_components();
}

draco::DataType type_of(const draco::PointAttribute& source) {
    return kept_as(source) == draco::ATTRIBUTE_INVALID_TRANSFORM ? source.data_type() : draco::DT_FLOAT32;
}

// By Draco's arithmetic, bit for bit, as every viewer makes them.
Status unfold_grid(const draco::PointAttribute& source, std::uint32_t points, std::span<float> values) {
    draco::AttributeQuantizationTransform grid;
    draco::Dequantizer to_float;
    if (!grid.InitFromAttribute(source) || grid.quantization_bits() < 1 || grid.quantization_bits() > 30 ||
        !to_float.Init(grid.range(), (1 << grid.quantization_bits()) - 1))
        return invalid_input("Draco: damaged quantization");
    read_each<std::int32_t>(source, points, [&](std::size_t p, const auto& steps) {
        for (std::size_t c = 0; c < steps.size(); ++c)
            values[p * steps.size() + c] = to_float(steps[c]) + grid.min_value(static_cast<int>(c));
    });
    return Nothing{};
}

Status unfold_octahedron(const draco::PointAttribute& source, std::uint32_t points, std::span<float> values) {
    draco::AttributeOctahedronTransform transform;
    draco::OctahedronToolBox octahedron;
    if (source.num_components() != 2 || !transform.InitFromAttribute(source) ||
        !octahedron.SetQuantizationBits(transform.quantization_bits()))
        return invalid_input("Draco: damaged normals");
    read_each<std::int32_t, 2>(source, points, [&](std::size_t p, const auto& steps) {
        octahedron.QuantizedOctahedralCoordsToUnitVector(steps[0], steps[1], &values[3 * p]);
    });
    return Nothing{};
}

// pre: type_of() is a float
Status read_floats(const draco::PointAttribute& source, std::uint32_t points, std::span<float> values) {
    if (kept_as(source) == draco::ATTRIBUTE_INVALID_TRANSFORM) return copy_values(source, points, values);
    if (const Status sound = check_stored(source, points, sizeof(std::int32_t)); !sound) return sound.error();
    if (source.data_type() != draco::DT_INT32) return invalid_input("Draco: attribute of an unexpected data type");
    return kept_as(source) == draco::ATTRIBUTE_OCTAHEDRON_TRANSFORM ? unfold_octahedron(source, points, values)
                                                                    : unfold_grid(source, points, values);
}

Status convert_values(const draco::PointAttribute& source, std::uint32_t points, std::vector<float>& values) {
    const Conversion convert = conversion_from(source.data_type());
    if (!convert) return invalid_input("Draco: attribute of an unknown data type");
    if (const Status covers = check_cover(source, points); !covers) return covers.error();
    const int size = draco::DataTypeLength(source.data_type());
    const std::uint64_t stored = source.buffer()->data_size();
    float* target = values.data();
    for (std::uint32_t p = 0; p < points; ++p) {
        const std::uint32_t value = value_of_point(source, p);
        const std::uint64_t start =
            static_cast<std::uint64_t>(source.byte_offset()) + static_cast<std::uint64_t>(source.byte_stride()) * value;
        const std::uint64_t length = static_cast<std::uint64_t>(size) * source.num_components();
        if (value >= source.size() || start > stored || length > stored - start)
            return invalid_input("Draco: attribute value out of range");
        for (int c = 0; c < source.num_components(); ++c)
            *target++ = convert(source.buffer()->data() + start + c * size, source.normalized());
    }
    return Nothing{};
}

bool has_components(const draco::PointAttribute& source) {
    return components_of(source) >= 1 && components_of(source) <= 4;
}

Result<DracoAttribute> read_attribute(const draco::PointAttribute& source, std::uint32_t points) {
    DracoAttribute attribute;
    attribute.semantic = semantic_of(source.attribute_type());
    attribute.components = components_of(source);
    attribute.normalized = source.normalized();
    attribute.values.resize(std::size_t{points} * static_cast<std::size_t>(attribute.components));
    if (type_of(source) == draco::DT_FLOAT32 && read_floats(source, points, attribute.values)) return attribute;
    if (const Status read = convert_values(source, points, attribute.values); !read) return read.error();
    return attribute;
}

Result<std::vector<std::uint32_t>> first_points(const draco::PointAttribute& positions, std::uint32_t points) {
    std::vector<std::uint32_t> result;
    if (const Status covers = check_cover(positions, points); !covers) return covers.error();
    if (positions.is_mapping_identity() || positions.size() >= points) return result;
    constexpr std::uint32_t none = 0xffffffffu;
    std::vector<std::uint32_t> first(positions.size(), none);
    result.reserve(points);
    for (std::uint32_t p = 0; p < points; ++p) {
        const std::uint32_t value = value_of_point(positions, p);
        if (value >= first.size()) return invalid_input("Draco: attribute value out of range");
        result.push_back(first[value] = std::min(first[value], p));
    }
    return result;
}

}  // namespace

struct DracoStream::Impl {
    std::unique_ptr<draco::PointCloud> cloud;
    const draco::Mesh* mesh = nullptr;  // null: a point cloud

    const draco::PointAttribute* attribute(std::uint32_t id) const {
        const draco::PointAttribute* found = nullptr;
        for (int a = 0; a < cloud->num_attributes() && !found; ++a)
            if (cloud->attribute(a)->unique_id() == id && has_components(*cloud->attribute(a)))
                found = cloud->attribute(a);
        return found;
    }
    template <class Number>
    Status read(std::uint32_t id, int components, draco::DataType type, std::span<Number> values) const {
        const draco::PointAttribute* found = attribute(id);
        if (!found || components_of(*found) != components || type_of(*found) != type ||
            found->normalized() != (type == draco::DT_UINT8))
            return invalid_input("Draco: an attribute is missing or of an unexpected kind");
        if constexpr (std::is_same_v<Number, float>) return read_floats(*found, cloud->num_points(), values);
        return copy_values(*found, cloud->num_points(), values);
    }
};

DracoStream::DracoStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DracoStream::DracoStream(DracoStream&&) noexcept = default;
DracoStream::~DracoStream() = default;

std::uint32_t DracoStream::points() const {
    return impl_->cloud->num_points();
}

Result<std::vector<mesh::Triangle>> DracoStream::triangles() const {
    std::vector<mesh::Triangle> result;
    if (!impl_->mesh || impl_->mesh->num_faces() == 0) return result;
    result.resize(impl_->mesh->num_faces());
    std::uint32_t last = 0;
    for (std::uint32_t f = 0; f < result.size(); ++f) {
        const draco::Mesh::Face& face = impl_->mesh->face(draco::FaceIndex(f));
        for (std::size_t k = 0; k < 3; ++k) last = std::max(last, result[f][k] = face[k].value());
    }
    if (last >= points()) return invalid_input("Draco: a triangle refers to a missing point");
    return result;
}

Result<std::vector<std::uint32_t>> DracoStream::first_at_position() const {
    const draco::PointAttribute* positions = impl_->cloud->GetNamedAttribute(draco::GeometryAttribute::POSITION);
    if (!impl_->mesh || !positions) return std::vector<std::uint32_t>{};
    return first_points(*positions, points());
}

Result<DracoAttribute> DracoStream::attribute(std::uint32_t id) const {
    const draco::PointAttribute* found = impl_->attribute(id);
    if (!found) return invalid_input("Draco: no attribute has the id " + std::to_string(id));
    return read_attribute(*found, points());
}

Status DracoStream::read(std::uint32_t id, int components, std::span<float> values) const {
    return impl_->read(id, components, draco::DT_FLOAT32, values);
}

Status DracoStream::read(std::uint32_t id, int components, std::span<std::uint8_t> values) const {
    return impl_->read(id, components, draco::DT_UINT8, values);
}

std::vector<std::uint32_t> DracoStream::ids() const {
    std::vector<std::uint32_t> result;
    for (int a = 0; a < impl_->cloud->num_attributes(); ++a)
        if (has_components(*impl_->cloud->attribute(a))) result.push_back(impl_->cloud->attribute(a)->unique_id());
    return result;
}

namespace {

struct DecodedCloud {
    std::unique_ptr<draco::PointCloud> cloud;
    const draco::Mesh* mesh = nullptr;
};

Result<DecodedCloud> decode(std::span<const std::byte> bytes, std::uint64_t max_points, std::uint64_t max_triangles) {
    const std::optional<DeclaredCounts> declared = read_declared_counts(bytes);
    if (!declared) return invalid_input("Draco: damaged header");
    const auto too_many = [&](std::uint64_t points, std::uint64_t triangles) {
        return points > max_points || triangles > max_triangles;
    };
    const Error limit =
        fail(ErrorCode::limit_exceeded, "Draco: more than " + std::to_string(max_points) + " points or " +
                                            std::to_string(max_triangles) + " triangles");
    if (too_many(declared->points, declared->triangles)) return limit;
    if (std::max(declared->points, declared->triangles) / max_elements_per_byte > bytes.size())
        return invalid_input("Draco: the header declares more than the stream can hold");

    draco::Decoder decoder;
    if (declared->version >= first_version_that_keeps_steps)
        for (const auto type : {draco::GeometryAttribute::POSITION, draco::GeometryAttribute::NORMAL,
                                draco::GeometryAttribute::TEX_COORD})
            decoder.SetSkipAttributeTransform(type);
    draco::DecoderBuffer buffer = buffer_of(bytes);
    DecodedCloud result;
    auto& [cloud, mesh] = result;
    draco::Status status;
    if (declared->is_mesh) {
        auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
        status = decoded.status();
        if (status.ok()) {
            auto owned = std::move(decoded).value();
            mesh = owned.get();
            cloud = std::move(owned);
        }
    } else {
        auto decoded = decoder.DecodePointCloudFromBuffer(&buffer);
        status = decoded.status();
        if (status.ok()) cloud = std::move(decoded).value();
    }
    if (!cloud) return invalid_input("Draco: damaged stream (" + status.error_msg_string() + ")");
    if (too_many(cloud->num_points(), mesh ? mesh->num_faces() : 0)) return limit;
    if (static_cast<std::size_t>(cloud->num_attributes()) > max_attributes)
        return fail(ErrorCode::limit_exceeded, "Draco: more than " + std::to_string(max_attributes) + " attributes");
    return result;
}

Result<DracoMesh> mesh_of(const DracoStream& stream) {
    DracoMesh result;
    result.points = stream.points();
    auto triangles = stream.triangles();
    if (!triangles) return triangles.error();
    result.triangles = *std::move(triangles);
    for (const std::uint32_t id : stream.ids()) {
        Result<DracoAttribute> attribute = stream.attribute(id);
        if (!attribute) return attribute.error();
        if (!result.attributes.emplace(id, *std::move(attribute)).second)
            return invalid_input("Draco: two attributes have the id " + std::to_string(id));
    }
    auto first = stream.first_at_position();
    if (!first) return first.error();
    result.first_at_position = *std::move(first);
    return result;
}

}  // namespace

std::vector<mesh::Triangle> between_positions(std::vector<mesh::Triangle> triangles,
                                              const std::vector<std::uint32_t>& first_at_position) {
    for (mesh::Triangle& t : triangles)
        for (std::uint32_t& corner : t) corner = first_at_position.empty() ? corner : first_at_position[corner];
    return triangles;
}

Result<DracoStream> DracoStream::decode(std::span<const std::byte> bytes, std::uint64_t max_points,
                                        std::uint64_t max_triangles) {
    try {
        Result<DecodedCloud> decoded = codec::decode(bytes, max_points, max_triangles);
        if (!decoded) return decoded.error();
        auto impl = std::make_unique<Impl>();
        impl->cloud = std::move(decoded->cloud);
        impl->mesh = decoded->mesh;
        return DracoStream(std::move(impl));
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "Draco: not enough memory to decode");
    } catch (const std::exception& error) {
        return invalid_input(std::string("Draco: damaged stream (") + error.what() + ")");
    }
}

Result<DracoMesh> decode_draco(std::span<const std::byte> bytes, std::uint64_t max_points,
                               std::uint64_t max_triangles) {
    try {
        const Result<DracoStream> stream = DracoStream::decode(bytes, max_points, max_triangles);
        if (!stream) return stream.error();
        return mesh_of(*stream);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "Draco: not enough memory to decode");
    }
}

}  // namespace lodestream::codec

// Draco 1.5.5 believes whatever count of texture orientations a stream states and works through it bit by bit: 1 KB can
// cost ten seconds and 256 MB. No look at the stream beforehand finds that count, since it stands behind entropy-coded
// data. So the functions that read it, templates which Draco's library instantiates as weak symbols, are specialized
// here with the missing bound: the strong symbol is the one that Draco's tables of virtual functions get.
namespace draco {
namespace {

using Wrap = PredictionSchemeWrapDecodingTransform<int, int>;
using FullTable = MeshPredictionSchemeData<CornerTable>;
using AttributeTable = MeshPredictionSchemeData<MeshAttributeCornerTable>;

// Reads `count` delta coded flags; a mesh has at most one for each of its corners.
bool read_orientations(std::uint32_t count, int corners, DecoderBuffer& buffer, std::vector<bool>& orientations) {
    RAnsBitDecoder decoder;
    if (corners < 0 || count > static_cast<std::uint32_t>(corners) || !decoder.StartDecoding(&buffer)) return false;
    bool orientation = true;
    for (std::uint32_t i = 0; i < count; ++i) {
        orientation = orientation == decoder.DecodeNextBit();
        orientations.push_back(orientation);
    }
    decoder.EndDecoding();
    return true;
}

template <class Predictor>
bool read_portable(Predictor& predictor, int corners, DecoderBuffer& buffer) {
    std::int32_t count = 0;
    std::vector<bool> orientations;
    if (!buffer.Decode(&count) || count < 0) return false;
    if (!read_orientations(static_cast<std::uint32_t>(count), corners, buffer, orientations)) return false;
    predictor.ResizeOrientations(count);
    for (int i = 0; i < count; ++i) predictor.set_orientation(i, orientations[static_cast<std::size_t>(i)]);
    return true;
}

bool read_deprecated(std::vector<bool>& orientations, int corners, DecoderBuffer& buffer) {
    std::uint32_t count = 0;
    const bool varint = buffer.bitstream_version() >= DRACO_BITSTREAM_VERSION(2, 2);
    orientations.clear();
    return (varint ? DecodeVarint(&count, &buffer) : buffer.Decode(&count)) && count > 0 &&
           read_orientations(count, corners, buffer, orientations);
}

}  // namespace

// NOLINTBEGIN(readability-identifier-naming): Draco's names
template <>
bool MeshPredictionSchemeTexCoordsPortableDecoder<int, Wrap, FullTable>::DecodePredictionData(DecoderBuffer* buffer) {
    return read_portable(predictor_, mesh_data().corner_table()->num_corners(), *buffer) &&
           MeshPredictionSchemeDecoder<int, Wrap, FullTable>::DecodePredictionData(buffer);
}
template <>
bool MeshPredictionSchemeTexCoordsPortableDecoder<int, Wrap, AttributeTable>::DecodePredictionData(
    DecoderBuffer* buffer) {
    return read_portable(predictor_, mesh_data().corner_table()->num_corners(), *buffer) &&
           MeshPredictionSchemeDecoder<int, Wrap, AttributeTable>::DecodePredictionData(buffer);
}
template <>
bool MeshPredictionSchemeTexCoordsDecoder<int, Wrap, FullTable>::DecodePredictionData(DecoderBuffer* buffer) {
    return read_deprecated(orientations_, mesh_data().corner_table()->num_corners(), *buffer) &&
           MeshPredictionSchemeDecoder<int, Wrap, FullTable>::DecodePredictionData(buffer);
}
template <>
bool MeshPredictionSchemeTexCoordsDecoder<int, Wrap, AttributeTable>::DecodePredictionData(DecoderBuffer* buffer) {
    return read_deprecated(orientations_, mesh_data().corner_table()->num_corners(), *buffer) &&
           MeshPredictionSchemeDecoder<int, Wrap, AttributeTable>::DecodePredictionData(buffer);
}
// NOLINTEND(readability-identifier-naming)

}  // namespace draco
