// Private to the codec: one primitive's geometry to a Draco stream that is known to decode to the same triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/codec/draco_mesh.h"
#include "common/codec/key_table.h"
#include "common/codec/lean_mesh.h"
#include "common/codec/level_codec.h"

namespace lodestream::codec {

// One vertex attribute of a level: its values, what quantization makes of them, and which one each vertex has.
// Positions are values of their own where their sources differ, though they fall on one grid point: triangles between
// them must survive. Other values are one where their decoded values are.
struct Channel {
    DracoAttribute::Semantic semantic = DracoAttribute::Semantic::position;
    int components = 3;
    int bits = 0;  // 0: bytes, not quantized further
    Vec3f origin{0.0f};
    float range = 1.0f;
    std::vector<float> values;                    // components a value
    std::vector<float> codes;                     // what Draco is given for them
    std::vector<Vec3d> grid_points;               // positions only: where they go on the grid
    std::vector<std::uint32_t> value_of_vertex;   // into values
    std::vector<std::uint32_t> decoded_of_value;  // into decoded
    KeyTable decoded{3};                          // bit patterns of the floats that a decoder yields

    float decoded_value(std::uint32_t decoded_index, int component) const;
};

// `grid_points`: where each goes, in steps from the origin, equal positions to equal ones.
Result<Channel> position_channel(const std::vector<Vec3f>& positions, const std::vector<Vec3d>& grid_points,
                                 const QuantizationGrid& grid);
// Normals that are not finite or have no length become +y.
Result<Channel> normal_channel(const std::vector<Vec3f>& normals, int bits);
// Coordinates that are not finite become 0. Beyond [0,1] each doubling of the range adds a bit.
Result<Channel> texture_coordinate_channel(const std::vector<Vec2f>& coordinates, int bits);
Result<Channel> color_channel(const std::vector<Rgba8>& colors);

struct EncodedPrimitive {
    std::vector<std::byte> stream;  // empty: it could not keep every triangle, `decoded` is to be stored plainly
    DracoMesh decoded;              // what a decoder yields; attribute ids are the channels' places
    // Lean only: of every corner 3 * t + k of `decoded`, the corner 3 * s + j that it was among the triangles given.
    std::vector<std::uint32_t> source_corners{};
};

// `triangles` index the level's vertices; the first of `channels` is the position.
Result<EncodedPrimitive> encode_primitive(std::span<const mesh::Triangle> triangles,
                                          std::span<const Channel* const> channels);
// Likewise to a stream of lean_mesh.h. None of the channels are normals.
Result<EncodedPrimitive> encode_lean_primitive(std::span<const mesh::Triangle> triangles,
                                               std::span<const Channel* const> channels);

// What a decoder makes of a lean stream's mesh: `values` hold three floats a point, or the attribute's components.
void read_positions(const LeanMesh& mesh, std::span<float> values);
void read_values(const LeanAttribute& attribute, std::span<float> values);
void read_values(const LeanAttribute& attribute, std::span<std::uint8_t> values);
// As of DracoMesh.
std::vector<std::uint32_t> first_points(const LeanMesh& mesh);

// Bytes of the stream alone: a Draco stream's, a lean one's.
std::uint64_t measure_primitive(std::span<const mesh::Triangle> triangles, std::span<const Channel* const> channels);
std::uint64_t measure_lean_primitive(std::span<const mesh::Triangle> triangles,
                                     std::span<const Channel* const> channels);

}  // namespace lodestream::codec
