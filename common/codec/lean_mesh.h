// Private to the codec: the geometry of a lean primitive, triangles between points on a grid, in fewer bytes than a
// Draco stream takes and as quickly read. Triangles are told along a border that grows over the surface (the cut-border
// machine, Gumhold and Straßer 1998), sharp corners of the border first. How sharp they are tells which are closed
// (Kälberer et al. 2005, "FreeLence"), so connectivity and positions go together. A new position is expected where a
// parallelogram has it, or several; what it is off by is told along the surface first, then how far it is from the
// last triangle's plane, which along a smooth surface is little. What is expected is reckoned so that every machine
// rounds it alike.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::codec {

using GridPoint = std::array<std::int32_t, 3>;
inline constexpr std::int32_t max_lean_coordinate = 1 << 21;  // of a position or an attribute, of either sign

// What whole numbers stand for: origin + step * number.
struct LeanGrid {
    std::array<float, 3> origin{};
    float step = 1.0f;
    float value(std::int32_t number, std::size_t axis) const {
        return origin[axis] + step * static_cast<float>(number);
    }
};

struct LeanAttribute {
    // By its components. A texture coordinate is expected where a triangle of the same shape has it on the image, a
    // colour where a parallelogram has it.
    enum class Kind : std::uint8_t { texture_coordinate = 2, color = 4 };
    Kind kind = Kind::color;
    LeanGrid grid;                     // of texture coordinates; colours are 0 … 255
    std::vector<std::int32_t> values;  // components() a point
    bool is_opaque = false;            // colours, of which the last component is 255 at every point
    std::size_t components() const { return static_cast<std::size_t>(kind); }
};

// A point is a position with its attributes, one a position where there are none.
struct LeanMesh {
    LeanGrid grid;  // of the positions
    std::vector<GridPoint> positions;
    std::vector<std::uint32_t> position_of_point;
    std::vector<LeanAttribute> attributes;
    std::vector<mesh::Triangle> triangles;  // between points
};

struct EncodedLeanMesh {
    std::vector<std::byte> bytes;
    // What it decodes to: the same triangles with positions, points and triangles in another order.
    LeanMesh decoded;
    std::vector<std::uint32_t> source_corners;  // of each of its corners, 3 * triangle + k, the one it was
};

// pre: every triangle has three different positions, every number is within its range. Positions and points that no
// triangle has are left out.
EncodedLeanMesh encode_lean_mesh(const LeanMesh& mesh);

// Hostile bytes. Errors: invalid_input (damaged, of another version), limit_exceeded (more than so many).
Result<LeanMesh> decode_lean_mesh(std::span<const std::byte> bytes, std::uint64_t max_points,
                                  std::uint64_t max_triangles);

}  // namespace lodestream::codec
