#include "common/codec/primitive_codec.h"

#include <draco/attributes/attribute_octahedron_transform.h>
#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/expert_encode.h>
#include <draco/core/encoder_buffer.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "common/codec/rounding.h"

namespace lodestream::codec {
namespace {

using Semantic = DracoAttribute::Semantic;

constexpr std::size_t max_components = 4;
constexpr int max_texture_coordinate_bits = 20;

// Draco's trade of time for bytes, 0 … 10: 4 costs 5 to 13 % more bytes than 3. 5, with other predictors, is for what
// 3 fails on.
constexpr int usual_speed = 3;
constexpr int second_speed = 5;
// Positions and colours predicted from several parallelograms at once, as Draco does below speed 2, take half as long
// again to decode. They are where they save so much of a stream: on terrain, on CAD, near a model's own triangles.
constexpr double least_saving_of_several = 0.04;

using Key = std::array<std::uint32_t, max_components>;

Key key_of(const float* value, int components) {
    Key key{};
    for (int c = 0; c < components; ++c) key[c] = std::bit_cast<std::uint32_t>(value[c] == 0.0f ? 0.0f : value[c]);
    return key;
}

draco::GeometryAttribute::Type draco_type(Semantic semantic) {
    switch (semantic) {
        case Semantic::position:
            return draco::GeometryAttribute::POSITION;
        case Semantic::normal:
            return draco::GeometryAttribute::NORMAL;
        case Semantic::color:
            return draco::GeometryAttribute::COLOR;
        case Semantic::texture_coordinate:
            return draco::GeometryAttribute::TEX_COORD;
        case Semantic::generic:
            break;
    }
    return draco::GeometryAttribute::GENERIC;
}

// Draco's encoder keeps the origin and range of a quantization as text of six digits, which no grid survives. So it is
// given whole grid steps on a stand-in grid of step 1, and the stream's record of that grid is then overwritten.
struct GridRecord {
    std::array<float, max_components> origin{};
    float range = 0.0f;
    int bits = 0;
    int components = 0;

    std::vector<std::byte> bytes() const {
        std::vector<std::byte> result(sizeof(float) * (components + 1) + 1);
        std::memcpy(result.data(), origin.data(), sizeof(float) * components);
        std::memcpy(result.data() + sizeof(float) * components, &range, sizeof range);
        result.back() = static_cast<std::byte>(bits);
        return result;
    }
};

float largest_code(int bits) {
    return static_cast<float>((1u << bits) - 1u);
}

// Origins that differ by attribute and axis, so that the records cannot be taken for one another.
GridRecord stand_in_grid(const Channel& channel) {
    GridRecord grid{{}, largest_code(channel.bits), channel.bits, channel.components};
    for (int c = 0; c < channel.components; ++c) grid.origin[c] = static_cast<float>(-1 - c - 4 * channel.components);
    return grid;
}

GridRecord true_grid(const Channel& channel) {
    GridRecord grid{{}, channel.range, channel.bits, channel.components};
    for (int c = 0; c < channel.components; ++c) grid.origin[c] = channel.origin[c];
    return grid;
}

bool is_on_grid(const Channel& channel) {
    return channel.bits > 0 && channel.semantic != Semantic::normal;
}

draco::PointAttribute float_attribute(Semantic semantic, int components, std::size_t count) {
    draco::PointAttribute attribute;
    attribute.Init(draco_type(semantic), static_cast<std::int8_t>(components), draco::DT_FLOAT32, false, count);
    return attribute;
}

std::vector<float> inverse(draco::AttributeTransform& transform, const draco::PointAttribute& portable,
                           const Channel& channel) {
    const std::size_t count = channel.values.size() / channel.components;
    draco::PointAttribute target = float_attribute(channel.semantic, channel.components, count);
    if (!transform.InverseTransformAttribute(portable, &target)) return {};
    std::vector<float> result(channel.values.size());
    target.buffer()->Read(0, result.data(), result.size() * sizeof(float));
    return result;
}

std::vector<float> snapped_to_grid(Channel& channel) {
    std::vector<std::int32_t> steps;
    const GridRecord stand_in = stand_in_grid(channel);
    for (std::size_t i = 0; i < channel.values.size(); ++i) {
        const std::size_t axis = i % channel.components;
        const double step = channel.grid_points.empty()
                                ? nearest_step(channel.values[i], channel.origin[axis], channel.range, channel.bits)
                                : channel.grid_points[i / 3][static_cast<int>(axis)];
        steps.push_back(static_cast<std::int32_t>(step));
        channel.codes.push_back(static_cast<float>(step + stand_in.origin[axis]));
    }
    draco::AttributeQuantizationTransform transform;
    if (!transform.SetParameters(channel.bits, &channel.origin[0], channel.components, channel.range)) return {};
    draco::PointAttribute portable;
    portable.Init(draco_type(channel.semantic), static_cast<std::int8_t>(channel.components), draco::DT_INT32, false,
                  steps.size() / channel.components);
    portable.buffer()->Write(0, steps.data(), steps.size() * sizeof(std::int32_t));
    return inverse(transform, portable, channel);
}

std::vector<float> snapped_to_octahedron(Channel& channel) {
    channel.codes = channel.values;
    draco::AttributeOctahedronTransform transform;
    transform.SetParameters(channel.bits);
    const std::size_t count = channel.values.size() / channel.components;
    draco::PointAttribute source = float_attribute(channel.semantic, channel.components, count);
    source.buffer()->Write(0, channel.values.data(), channel.values.size() * sizeof(float));
    const auto portable = transform.InitTransformedAttribute(source, static_cast<int>(count));
    if (!transform.TransformAttribute(source, {}, portable.get())) return {};
    return inverse(transform, *portable, channel);
}

// Sets the codes and returns, by Draco's own arithmetic, what a decoder will make of them, bit for bit.
std::vector<float> quantize(Channel& channel) {
    if (is_on_grid(channel)) return snapped_to_grid(channel);
    if (channel.semantic == Semantic::normal) return snapped_to_octahedron(channel);
    channel.codes = channel.values;
    return channel.values;
}

// `source`: one value a vertex; `grid_points`: likewise, or empty.
Result<Channel> finish_channel(Channel channel, const std::vector<float>& source,
                               const std::vector<Vec3d>& grid_points = {}) {
    const std::size_t components = static_cast<std::size_t>(channel.components);
    KeyTable distinct(components);
    for (std::size_t v = 0; v < source.size(); v += components) {
        const std::uint32_t value = distinct.find_or_add(key_of(&source[v], channel.components).data());
        if (std::size_t{value} * components == channel.values.size()) {
            channel.values.insert(channel.values.end(), &source[v], &source[v] + components);
            if (!grid_points.empty()) channel.grid_points.push_back(grid_points[v / components]);
        }
        channel.value_of_vertex.push_back(value);
    }
    const std::vector<float> decoded = quantize(channel);
    if (decoded.size() != channel.values.size())
        return fail(ErrorCode::internal, "Draco refused to quantize an attribute");
    channel.decoded = KeyTable(components);
    for (std::size_t i = 0; i < decoded.size(); i += components)
        channel.decoded_of_value.push_back(channel.decoded.find_or_add(key_of(&decoded[i], channel.components).data()));
    return channel;
}

// The first of the values that decode alike stands for all of them.
std::vector<float> one_each(const Channel& channel, const std::vector<float>& numbers) {
    const std::size_t components = static_cast<std::size_t>(channel.components);
    std::vector<float> result(channel.decoded.size() * components);
    for (std::size_t value = channel.decoded_of_value.size(); value-- > 0;)
        std::copy_n(&numbers[value * components], components, &result[channel.decoded_of_value[value] * components]);
    return result;
}

void merge_values_that_decode_alike(Channel& channel) {
    channel.values = one_each(channel, channel.values);
    channel.codes = one_each(channel, channel.codes);
    for (std::uint32_t& value : channel.value_of_vertex) value = channel.decoded_of_value[value];
    channel.decoded_of_value.resize(channel.decoded.size());
    std::iota(channel.decoded_of_value.begin(), channel.decoded_of_value.end(), 0u);
}

Result<Channel> finish_merged_channel(Channel channel, const std::vector<float>& source) {
    Result<Channel> finished = finish_channel(std::move(channel), source);
    if (finished) merge_values_that_decode_alike(*finished);
    return finished;
}

// The level's vertices of one primitive under numbers of their own.
struct LocalMesh {
    explicit LocalMesh(std::size_t channels) : points(channels) {}
    KeyTable points;  // key: a value a channel
    std::vector<mesh::Triangle> triangles;
};

LocalMesh local_mesh(std::span<const mesh::Triangle> triangles, std::span<const Channel* const> channels) {
    LocalMesh local(channels.size());
    local.triangles.reserve(triangles.size());
    const auto point_of = [&](std::uint32_t vertex) {
        Key key{};
        for (std::size_t c = 0; c < channels.size(); ++c) key[c] = channels[c]->value_of_vertex[vertex];
        return local.points.find_or_add(key.data());
    };
    for (const mesh::Triangle& t : triangles) {
        const std::uint32_t a = point_of(t[0]), b = point_of(t[1]), c = point_of(t[2]);
        local.triangles.push_back({a, b, c});
    }
    return local;
}

// Adds one channel's values that `local` uses, and which of them each point has.
void add_attribute(draco::Mesh& target, const LocalMesh& local, const Channel& channel, std::size_t place) {
    KeyTable used(1);
    std::vector<std::uint32_t> value_of_point(local.points.size());
    for (std::uint32_t p = 0; p < local.points.size(); ++p)
        value_of_point[p] = used.find_or_add(local.points.key(p) + place);

    const bool as_bytes = channel.bits == 0;
    draco::GeometryAttribute description;
    description.Init(draco_type(channel.semantic), nullptr, static_cast<std::uint8_t>(channel.components),
                     as_bytes ? draco::DT_UINT8 : draco::DT_FLOAT32, as_bytes,
                     channel.components * static_cast<std::int64_t>(as_bytes ? 1 : sizeof(float)), 0);
    const int id = target.AddAttribute(description, false, used.size());
    draco::PointAttribute& attribute = *target.attribute(id);
    for (std::uint32_t i = 0; i < used.size(); ++i) {
        const float* value = &channel.codes[std::size_t{*used.key(i)} * channel.components];
        std::array<std::uint8_t, max_components> bytes{};
        for (int c = 0; as_bytes && c < channel.components; ++c)
            bytes[c] = static_cast<std::uint8_t>(std::lround(value[c] * 255.0f));
        attribute.SetAttributeValue(draco::AttributeValueIndex(i), as_bytes ? static_cast<const void*>(bytes.data())
                                                                            : static_cast<const void*>(value));
    }
    for (std::uint32_t p = 0; p < local.points.size(); ++p)
        attribute.SetPointMapEntry(draco::PointIndex(p), draco::AttributeValueIndex(value_of_point[p]));
}

std::unique_ptr<draco::Mesh> draco_mesh(const LocalMesh& local, std::span<const Channel* const> channels) {
    auto result = std::make_unique<draco::Mesh>();
    result->SetNumFaces(local.triangles.size());
    result->set_num_points(local.points.size());
    for (std::uint32_t f = 0; f < local.triangles.size(); ++f) {
        const mesh::Triangle& t = local.triangles[f];
        result->SetFace(draco::FaceIndex(f),
                        {{draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])}});
    }
    for (std::size_t c = 0; c < channels.size(); ++c) add_attribute(*result, local, *channels[c], c);
    return result;
}

bool overwrite(std::vector<std::byte>& stream, const GridRecord& from, const GridRecord& to) {
    const std::vector<std::byte> old_record = from.bytes(), new_record = to.bytes();
    const auto found = std::search(stream.begin(), stream.end(), old_record.begin(), old_record.end());
    if (found == stream.end()) return false;
    std::copy(new_record.begin(), new_record.end(), found);
    return true;
}

// What values are expected from.
enum class Prediction { by_speed, several_parallelograms };

// Empty where Draco fails.
std::vector<std::byte> compress(const draco::Mesh& source, std::span<const Channel* const> channels, int speed,
                                Prediction prediction = Prediction::by_speed) {
    draco::ExpertEncoder encoder(source);
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const Channel& channel = *channels[c];
        const int id = static_cast<int>(c);
        const bool is_spread = channel.semantic == Semantic::position || channel.semantic == Semantic::color;
        if (prediction == Prediction::several_parallelograms && is_spread)
            (void)encoder.SetAttributePredictionScheme(id, draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM);
        const GridRecord grid = stand_in_grid(channel);
        if (is_on_grid(channel))
            encoder.SetAttributeExplicitQuantization(id, grid.bits, grid.components, grid.origin.data(), grid.range);
        else if (channel.bits > 0)
            encoder.SetAttributeQuantization(id, channel.bits);
    }
    draco::EncoderBuffer buffer;
    if (!encoder.EncodeToBuffer(&buffer).ok()) return {};
    const auto* bytes = reinterpret_cast<const std::byte*>(buffer.data());
    std::vector<std::byte> stream(bytes, bytes + buffer.size());
    for (const Channel* channel : channels)
        if (is_on_grid(*channel) && !overwrite(stream, stand_in_grid(*channel), true_grid(*channel))) return {};
    return stream;
}

// The smaller one, unless it saves too little to be worth its decoding.
std::vector<std::byte> compress_usual(const draco::Mesh& source, std::span<const Channel* const> channels) {
    std::vector<std::byte> stream = compress(source, channels, usual_speed);
    std::vector<std::byte> other = compress(source, channels, usual_speed, Prediction::several_parallelograms);
    const bool saves = !other.empty() && static_cast<double>(other.size()) <=
                                             (1.0 - least_saving_of_several) * static_cast<double>(stream.size());
    return saves || stream.empty() ? other : stream;
}

mesh::Triangle rotated_to_least(const mesh::Triangle& t) {
    const mesh::Triangle b{t[1], t[2], t[0]}, c{t[2], t[0], t[1]};
    return std::min({t, b, c});
}

std::vector<mesh::Triangle> as_set(std::vector<mesh::Triangle> triangles) {
    for (mesh::Triangle& t : triangles) t = rotated_to_least(t);
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

// The points of `local` that decode alike are one; key: a decoded value a channel.
struct DecodedPoints {
    KeyTable points;
    std::vector<mesh::Triangle> triangles;
};

DecodedPoints expected_points(const LocalMesh& local, std::span<const Channel* const> channels) {
    DecodedPoints expected{KeyTable(channels.size()), local.triangles};
    std::vector<std::uint32_t> point_of(local.points.size());
    for (std::uint32_t p = 0; p < local.points.size(); ++p) {
        Key key{};
        for (std::size_t c = 0; c < channels.size(); ++c)
            key[c] = channels[c]->decoded_of_value[local.points.key(p)[c]];
        point_of[p] = expected.points.find_or_add(key.data());
    }
    for (mesh::Triangle& t : expected.triangles)
        for (std::uint32_t& corner : t) corner = point_of[corner];
    return expected;
}

// The triangles of `mesh` with the expected points' numbers for its own; empty where it has other attributes or values.
std::vector<mesh::Triangle> renumbered(const DecodedPoints& expected, const DracoMesh& mesh,
                                       std::span<const Channel* const> channels) {
    if (mesh.attributes.size() != channels.size()) return {};
    std::vector<Key> keys(mesh.points, Key{});
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const auto found = mesh.attributes.find(static_cast<std::uint32_t>(c));
        if (found == mesh.attributes.end() || found->second.components != channels[c]->components) return {};
        const float* value = found->second.values.data();
        for (std::uint32_t p = 0; p < mesh.points; ++p, value += channels[c]->components) {
            keys[p][c] = channels[c]->decoded.find(key_of(value, channels[c]->components).data());
            if (keys[p][c] == KeyTable::none) return {};
        }
    }
    std::vector<mesh::Triangle> triangles = mesh.triangles;
    for (mesh::Triangle& t : triangles)
        for (std::uint32_t& corner : t) {
            corner = expected.points.find(keys[corner].data());
            if (corner == KeyTable::none) return {};
        }
    return triangles;
}

// Whether `mesh` has exactly the expected triangles, every corner with the expected value of every attribute.
bool decodes_to(const DecodedPoints& expected, const DracoMesh& mesh, std::span<const Channel* const> channels) {
    return mesh.triangles.size() == expected.triangles.size() &&
           as_set(renumbered(expected, mesh, channels)) == as_set(expected.triangles);
}

DracoMesh plain_mesh(const DecodedPoints& expected, std::span<const Channel* const> channels) {
    DracoMesh result;
    result.points = expected.points.size();
    result.triangles = expected.triangles;
    for (std::size_t c = 0; c < channels.size(); ++c) {
        DracoAttribute& attribute = result.attributes[static_cast<std::uint32_t>(c)];
        attribute.semantic = channels[c]->semantic;
        attribute.components = channels[c]->components;
        attribute.normalized = channels[c]->bits == 0;
        for (std::uint32_t p = 0; p < result.points; ++p)
            for (int k = 0; k < attribute.components; ++k)
                attribute.values.push_back(channels[c]->decoded_value(expected.points.key(p)[c], k));
    }
    return result;
}

LeanGrid lean_grid(const Channel& channel) {
    LeanGrid grid;
    for (std::size_t axis = 0; axis < 3; ++axis) grid.origin[axis] = channel.origin[static_cast<int>(axis)];
    grid.step = channel.range / largest_code(channel.bits);
    return grid;
}

// Values as whole numbers: grid steps, or bytes.
std::vector<std::int32_t> whole_numbers(const Channel& channel) {
    std::vector<std::int32_t> numbers;
    numbers.reserve(channel.codes.size());
    const GridRecord stand_in = stand_in_grid(channel);
    for (std::size_t i = 0; i < channel.codes.size(); ++i)
        numbers.push_back(static_cast<std::int32_t>(
            std::lround(channel.bits == 0 ? channel.codes[i] * 255.0f
                                          : channel.codes[i] - stand_in.origin[i % channel.components])));
    return numbers;
}

LeanMesh lean_mesh(const LocalMesh& local, std::span<const Channel* const> channels) {
    LeanMesh result;
    result.grid = lean_grid(*channels[0]);
    result.triangles = local.triangles;
    const std::vector<std::int32_t> steps = whole_numbers(*channels[0]);
    KeyTable used(1);
    for (std::uint32_t p = 0; p < local.points.size(); ++p) {
        const std::uint32_t value = local.points.key(p)[0];
        result.position_of_point.push_back(used.find_or_add(&value));
        if (used.size() == result.positions.size()) continue;
        const std::int32_t* at = &steps[3 * std::size_t{value}];
        result.positions.push_back({at[0], at[1], at[2]});
    }
    for (std::size_t c = 1; c < channels.size(); ++c) {
        const bool is_color = channels[c]->semantic == Semantic::color;
        LeanAttribute& attribute = result.attributes.emplace_back();
        attribute.kind = is_color ? LeanAttribute::Kind::color : LeanAttribute::Kind::texture_coordinate;
        if (!is_color) attribute.grid = lean_grid(*channels[c]);
        const std::vector<std::int32_t> numbers = whole_numbers(*channels[c]);
        for (std::uint32_t p = 0; p < local.points.size(); ++p) {
            const auto first =
                numbers.begin() + static_cast<std::ptrdiff_t>(attribute.components() * local.points.key(p)[c]);
            attribute.values.insert(attribute.values.end(), first,
                                    first + static_cast<std::ptrdiff_t>(attribute.components()));
        }
    }
    return result;
}

// With the ids of encode_lean_primitive.
DracoMesh points_of(LeanMesh mesh) {
    DracoMesh result;
    result.points = static_cast<std::uint32_t>(mesh.position_of_point.size());
    result.first_at_position = first_points(mesh);
    result.triangles = std::move(mesh.triangles);
    const auto add = [&](Semantic semantic, int components) -> DracoAttribute& {
        const std::size_t values = static_cast<std::size_t>(components) * result.points;
        DracoAttribute& attribute = result.attributes[static_cast<std::uint32_t>(result.attributes.size())];
        return attribute = {semantic, components, semantic == Semantic::color, std::vector<float>(values)};
    };
    read_positions(mesh, add(Semantic::position, 3).values);
    for (const LeanAttribute& source : mesh.attributes) {
        const bool is_color = source.kind == LeanAttribute::Kind::color;
        std::vector<float>& values =
            add(is_color ? Semantic::color : Semantic::texture_coordinate, static_cast<int>(source.components()))
                .values;
        if (!is_color) read_values(source, values);
        for (std::size_t i = 0; is_color && i < values.size(); ++i)
            values[i] = static_cast<float>(source.values[i] / 255.0);
    }
    return result;
}

auto has_three_positions(const LeanMesh& mesh) {
    return [&mesh](const mesh::Triangle& t) {
        const std::uint32_t a = mesh.position_of_point[t[0]], b = mesh.position_of_point[t[1]],
                            c = mesh.position_of_point[t[2]];
        return a != b && b != c && c != a;
    };
}

// Whether every corner has the decoded values of the one that it was.
bool has_values(const DracoMesh& mesh, const std::vector<std::uint32_t>& source_corners, const LocalMesh& local,
                std::span<const Channel* const> channels) {
    if (mesh.triangles.size() != local.triangles.size() || mesh.attributes.size() != channels.size()) return false;
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const auto components = static_cast<std::size_t>(channels[c]->components);
        const std::vector<float>& values = mesh.attributes.at(static_cast<std::uint32_t>(c)).values;
        for (std::size_t corner = 0; corner < source_corners.size(); ++corner) {
            const std::uint32_t source = source_corners[corner], point = mesh.triangles[corner / 3][corner % 3];
            const std::uint32_t wanted = local.points.key(local.triangles[source / 3][source % 3])[c];
            const std::uint32_t* decoded = channels[c]->decoded.key(channels[c]->decoded_of_value[wanted]);
            const Key key = key_of(&values[point * components], channels[c]->components);
            if (!std::equal(decoded, decoded + components, key.begin())) return false;
        }
    }
    return true;
}

}  // namespace

float Channel::decoded_value(std::uint32_t decoded_index, int component) const {
    return std::bit_cast<float>(decoded.key(decoded_index)[component]);
}

Result<Channel> position_channel(const std::vector<Vec3f>& positions, const std::vector<Vec3d>& grid_points,
                                 const QuantizationGrid& grid) {
    Channel channel;
    channel.bits = grid.bits;
    channel.origin = grid.origin;
    channel.range = grid.range;
    std::vector<float> source;
    source.reserve(positions.size() * 3);
    for (const Vec3f& p : positions) source.insert(source.end(), {p.x, p.y, p.z});
    return finish_channel(std::move(channel), source, grid_points);
}

Result<Channel> normal_channel(const std::vector<Vec3f>& normals, int bits) {
    Channel channel;
    channel.semantic = Semantic::normal;
    channel.bits = bits;
    std::vector<float> source;
    source.reserve(normals.size() * 3);
    for (const Vec3f& n : normals) {
        const double length = glm::length(Vec3d(n));
        const Vec3d unit = std::isfinite(length) && length > 0.0 ? Vec3d(n) / length : Vec3d(0, 1, 0);
        source.insert(source.end(),
                      {static_cast<float>(unit.x), static_cast<float>(unit.y), static_cast<float>(unit.z)});
    }
    return finish_merged_channel(std::move(channel), source);
}

Result<Channel> texture_coordinate_channel(const std::vector<Vec2f>& coordinates, int bits) {
    Channel channel;
    channel.semantic = Semantic::texture_coordinate;
    channel.components = 2;
    std::vector<float> source;
    source.reserve(coordinates.size() * 2);
    for (const Vec2f& uv : coordinates)
        for (int axis = 0; axis < 2; ++axis) source.push_back(std::isfinite(uv[axis]) ? uv[axis] : 0.0f);
    Vec2f low{0.0f}, high{0.0f};
    for (std::size_t i = 0; i < source.size(); ++i) {
        const int axis = static_cast<int>(i % 2);
        low[axis] = i < 2 ? source[i] : std::min(low[axis], source[i]);
        high[axis] = i < 2 ? source[i] : std::max(high[axis], source[i]);
    }
    channel.origin = Vec3f(low, 0.0f);
    channel.range = std::max({high.x - low.x, high.y - low.y, 1e-6f});
    if (!std::isfinite(channel.range)) return invalid_input("texture coordinates span more than a float can hold");
    channel.bits = std::min(bits + std::max(0, static_cast<int>(std::ceil(std::log2(channel.range)))),
                            max_texture_coordinate_bits);
    return finish_merged_channel(std::move(channel), source);
}

Result<Channel> color_channel(const std::vector<Rgba8>& colors) {
    Channel channel;
    channel.semantic = Semantic::color;
    channel.components = 4;
    std::vector<float> source;
    source.reserve(colors.size() * 4);
    for (const Rgba8& color : colors)
        for (int c = 0; c < 4; ++c) source.push_back(static_cast<float>(color[c] / 255.0));
    return finish_merged_channel(std::move(channel), source);
}

Result<EncodedPrimitive> encode_primitive(std::span<const mesh::Triangle> triangles,
                                          std::span<const Channel* const> channels) {
    const LocalMesh local = local_mesh(triangles, channels);
    const std::unique_ptr<draco::Mesh> source = draco_mesh(local, channels);
    const DecodedPoints expected = expected_points(local, channels);
    for (const bool usual : {true, false}) {
        std::vector<std::byte> stream =
            usual ? compress_usual(*source, channels) : compress(*source, channels, second_speed);
        Result<DracoMesh> decoded = decode_draco(stream, max_decoded_vertices, max_decoded_triangles);
        if (decoded && decodes_to(expected, *decoded, channels))
            return EncodedPrimitive{std::move(stream), std::move(*decoded)};
    }
    return EncodedPrimitive{{}, plain_mesh(expected, channels)};
}

Result<EncodedPrimitive> encode_lean_primitive(std::span<const mesh::Triangle> triangles,
                                               std::span<const Channel* const> channels) {
    const LocalMesh local = local_mesh(triangles, channels);
    const LeanMesh source = lean_mesh(local, channels);
    EncodedPrimitive result;
    if (!std::all_of(source.triangles.begin(), source.triangles.end(), has_three_positions(source))) {
        result.decoded = plain_mesh(expected_points(local, channels), channels);
        result.source_corners.resize(3 * triangles.size());
        std::iota(result.source_corners.begin(), result.source_corners.end(), 0u);
        return result;
    }
    EncodedLeanMesh encoded = encode_lean_mesh(source);
    Result<LeanMesh> decoded = decode_lean_mesh(encoded.bytes, max_decoded_vertices, max_decoded_triangles);
    if (!decoded) return decoded.error();
    result.stream = std::move(encoded.bytes);
    result.source_corners = std::move(encoded.source_corners);
    result.decoded = points_of(*std::move(decoded));
    if (!has_values(result.decoded, result.source_corners, local, channels))
        return fail(ErrorCode::internal, "encode: a lean stream does not decode to what was encoded");
    return result;
}

void read_positions(const LeanMesh& mesh, std::span<float> values) {
    float* value = values.data();
    for (const std::uint32_t position : mesh.position_of_point)
        for (std::size_t axis = 0; axis < 3; ++axis) *value++ = mesh.grid.value(mesh.positions[position][axis], axis);
}

void read_values(const LeanAttribute& attribute, std::span<float> values) {
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = attribute.grid.value(attribute.values[i], i % attribute.components());
}

void read_values(const LeanAttribute& attribute, std::span<std::uint8_t> values) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint8_t>(attribute.values[i]);
}

std::vector<std::uint32_t> first_points(const LeanMesh& mesh) {
    std::vector<std::uint32_t> result;
    if (mesh.position_of_point.size() == mesh.positions.size()) return result;
    constexpr std::uint32_t none = 0xffffffffu;
    std::vector<std::uint32_t> first(mesh.positions.size(), none);
    result.reserve(mesh.position_of_point.size());
    for (std::uint32_t p = 0; p < mesh.position_of_point.size(); ++p) {
        std::uint32_t& of_position = first[mesh.position_of_point[p]];
        result.push_back(of_position = std::min(of_position, p));
    }
    return result;
}

std::uint64_t measure_primitive(std::span<const mesh::Triangle> triangles, std::span<const Channel* const> channels) {
    return compress(*draco_mesh(local_mesh(triangles, channels), channels), channels, usual_speed).size();
}

std::uint64_t measure_lean_primitive(std::span<const mesh::Triangle> triangles,
                                     std::span<const Channel* const> channels) {
    return encode_lean_mesh(lean_mesh(local_mesh(triangles, channels), channels)).bytes.size();
}

}  // namespace lodestream::codec
