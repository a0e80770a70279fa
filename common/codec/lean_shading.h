// Private to the codec: what a lean primitive has beside its one Draco stream of positions. Which triangles are Gouraud
// is told as runs in the order in which Draco decodes them. Their corners at a position form groups of one normal each;
// it is derived from the group's triangles, and only what the derived one is off by is sent, in steps as coarse as the
// level's own error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::codec {

// A derived normal is good enough where it is off by no more than the tolerance or than the face itself, up to so many
// tolerances: worse than flat shading it never is by more.
inline constexpr double lean_tolerances_where_flat_is_worse = 3.0;

struct WantedShading {
    std::vector<std::uint8_t> gouraud;            // one a triangle
    std::vector<Vec3f> normals;                   // of any length
    std::vector<std::uint32_t> normal_of_corner;  // three a triangle, into `normals`; of flat ones without a meaning
};

// `positions` and `triangles` between them as Draco decodes them, `wanted` in their order. Corners with one wanted
// normal are told apart by its number. tolerance_degrees: > 0
std::vector<std::byte> encode_lean_shading(const std::vector<Vec3f>& positions,
                                           const std::vector<mesh::Triangle>& triangles, const WantedShading& wanted,
                                           double tolerance_degrees);

// A Gouraud corner with another normal than its position's.
struct FurtherNormal {
    std::uint32_t corner = 0;  // 3 * triangle + k
    std::uint32_t normal = 0;  // into LeanShading::further_normals
};

struct LeanShading {
    std::vector<std::uint8_t> gouraud;  // one a triangle
    std::vector<Vec3f> normals;         // one a position, unit length
    std::vector<Vec3f> further_normals;
    std::vector<FurtherNormal> further;  // those of one position side by side
};

// One normal for each group: the derived one where that is good enough, else the mean of those wanted. Beyond so large
// a tolerance the reader's rounding is not counted, and what is told goes in steps from the derived one, as of a lean
// level: it repeats more, and a picture shows no difference.
inline constexpr double most_degrees_of_exact = 1.0;
struct SentNormals {
    std::vector<Vec3f> normals;
    std::vector<std::uint32_t> normal_of_corner;  // three a triangle, into `normals`; of flat ones without a meaning
};

using AsDerived = std::function<Vec3f(const Vec3f& mean_of_faces)>;
// Of faces weighted by their area, as Draco predicts normals too. `as_derived`: what the reader makes of their mean.
SentNormals sent_normals(const std::vector<Vec3f>& positions, const std::vector<mesh::Triangle>& triangles,
                         const WantedShading& wanted, double tolerance_degrees, const AsDerived& as_derived);

// Errors: invalid_input where the bytes are not those of so many positions and triangles.
Result<LeanShading> decode_lean_shading(const std::vector<Vec3f>& positions,
                                        const std::vector<mesh::Triangle>& triangles, std::span<const std::byte> bytes);

}  // namespace lodestream::codec
