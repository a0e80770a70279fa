// Private to the codec: streams of EXT_meshopt_compression, mode ATTRIBUTES, by meshoptimizer's codec.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/math.h"
#include "common/base/result.h"

namespace lodestream::codec {

inline constexpr const char* meshopt_extension = "EXT_meshopt_compression";
inline constexpr const char* octahedral_filter = "OCTAHEDRAL";
inline constexpr std::uint64_t most_shrinking = 64;  // of a stream: two bits for sixteen bytes are the least

// `values`: whole elements of `stride` bytes, a multiple of 4 in [4, 256].
std::vector<std::byte> compressed(std::span<const std::byte> values, std::size_t stride);

// The bytes are hostile. Errors: invalid_input (damaged, or too short for so many elements; nothing is allocated then).
Result<std::vector<std::byte>> decompressed(std::span<const std::byte> stream, std::uint64_t elements,
                                            std::size_t stride);

// Unit vectors as the octahedral filter has them, four bytes each, and back: x, y, z in steps of 1/127 and a byte.
std::vector<std::byte> octahedral(std::span<const Vec3f> normals);
void undo_octahedral(std::span<std::byte> values);

}  // namespace lodestream::codec
