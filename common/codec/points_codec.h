// A point cloud as plain glTF 2.0 binary: one primitive of mode POINTS, its attributes interleaved point by point
// (KHR_mesh_quantization), in the cloud's order. So a prefix of the bytes is a prefix of the cloud, which is a level:
// streaming is appending, and a file cut at any byte behind its header still draws what came.
// This is the plain form.
//
//   point:  position 3 x u16, 2 bytes of 0 | normal 3 x i8, 1 byte of 0, where it has normals | colour 4 x u8, likewise
//
// Positions count steps of the asset's grid, whose step and origin are the node's scale and translation. What is known
// of the levels stands in the glTF asset's `extras.lodestream.levels`.
//
// The lean form is for a level that is fetched and drawn whole: about half of the bytes, for what it gives up. Its
// points lie along the Z-order curve, in steps as fine as their discs need, in streams of EXT_meshopt_compression, one
// an attribute (normals with its octahedral filter), which any viewer with meshoptimizer's decoder reads. Draco's k-d
// tree is as small, but no glTF viewer takes it for points; to keep the order costs either two bytes a point.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/codec/level_codec.h"
#include "common/points/level.h"
#include "common/points/point_cloud.h"

namespace lodestream::codec {

inline constexpr int point_position_bits = 16;
inline constexpr std::size_t max_point_levels = 64;

struct Points {
    points::PointCloud cloud;
    QuantizationGrid grid;              // the asset's, with point_position_bits
    std::vector<points::Level> levels;  // finest first: points fall, errors and radii do not
    Vec4f base_color{1.0f};             // linear, of every point
    Vec3d origin{0.0};                  // world position of the cloud's (0,0,0)
};

// The asset's grid as points use it: the same place and range, with steps of point_position_bits.
QuantizationGrid point_grid(const Box& bounds);

struct EncodedPoints {
    std::vector<std::byte> glb;
    std::uint64_t first_point_byte = 0;  // of the file
    std::uint64_t bytes_per_point = 0;
};

// Positions are moved by at most half a step of the grid, normals by less than half a degree and 1 % of their length.
// Constant colours become part of the base colour. Errors: invalid_input (an attribute that does not cover every point,
// numbers that are not finite, a point outside the grid), limit_exceeded (points::max_points).
Result<EncodedPoints> encode_points(const Points& points);

// A lean level's steps are at most this share of its discs' radius, down to those of the grid.
inline constexpr double lean_step_share = 1.0 / 16.0;

// The same in the lean form, in another order; of the levels, the first alone is told. Positions are moved by at most
// half a step, normals by less than two degrees. Errors as encode_points().
Result<std::vector<std::byte>> encode_lean_points(const Points& points);

struct DecodedPoints {
    Points content;  // of the plain form encodes to the same bytes; the grid's origin has become part of its own
    std::uint64_t points = 0;  // of the whole file; the content has fewer where the bytes end early
};

// Reads what encode_points wrote, or its beginning, if that holds the whole header, or what encode_lean_points wrote.
// The bytes are hostile: any damage is an error, never a crash or an allocation beyond what the bytes can hold.
Result<DecodedPoints> decode_points(std::span<const std::byte> glb);

}  // namespace lodestream::codec
