// Private to the codec: what a lean primitive has beside its one Draco stream of positions. Which triangles are Gouraud
// is told as runs in the order in which Draco decodes them; normals are derived from the triangles, and only those are
// sent that the derived ones would be off from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::codec {

// A derived normal is good enough where it is off by no more than the first angle, or than the face itself, up to the
// second: worse than flat shading it never is by more. Measured on a noisy scan: the picture's error is that of 8-bit
// normals within 3 %.
inline constexpr double lean_always_good_degrees = 8.0;
inline constexpr double lean_normal_tolerance_degrees = 24.0;
// Faces that meet at a larger angle are not smoothed into each other when normals are derived.
inline constexpr double lean_crease_degrees = 60.0;

struct LeanShading {
    std::vector<std::uint8_t> gouraud;  // one a triangle
    std::vector<Vec3f> normals;         // three a triangle, unit length; those of flat triangles mean nothing
};

// The normal of every corner: the mean over the faces around its position that are within the crease of its own,
// weighted by area. +y where there is no area.
std::vector<Vec3f> derive_normals(const std::vector<Vec3f>& positions, const std::vector<mesh::Triangle>& triangles);

// `positions` and `triangles` as Draco decodes them; `wanted` in their order.
std::vector<std::byte> encode_lean_shading(const std::vector<Vec3f>& positions,
                                           const std::vector<mesh::Triangle>& triangles, const LeanShading& wanted);

// Errors: invalid_input where the bytes are not those of so many positions and triangles.
Result<LeanShading> decode_lean_shading(const std::vector<Vec3f>& positions,
                                        const std::vector<mesh::Triangle>& triangles, std::span<const std::byte> bytes);

}  // namespace lodestream::codec
