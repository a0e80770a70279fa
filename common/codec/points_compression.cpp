#include "common/codec/points_compression.h"

#include <meshoptimizer.h>

namespace lodestream::codec {

namespace {

constexpr std::size_t normal_bytes = 4;
constexpr int normal_bits = 8;

}  // namespace

std::vector<std::byte> compressed(std::span<const std::byte> values, std::size_t stride) {
    const std::size_t elements = values.size() / stride;
    std::vector<std::byte> stream(meshopt_encodeVertexBufferBound(elements, stride));
    stream.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(stream.data()), stream.size(),
                                             values.data(), elements, stride));
    return stream;
}

Result<std::vector<std::byte>> decompressed(std::span<const std::byte> stream, std::uint64_t elements,
                                            std::size_t stride) {
    if (elements > stream.size() * most_shrinking / stride) return invalid_input("too short a compressed stream");
    std::vector<std::byte> values(elements * stride);
    if (meshopt_decodeVertexBuffer(values.data(), elements, stride,
                                   reinterpret_cast<const unsigned char*>(stream.data()), stream.size()) != 0)
        return invalid_input("a damaged compressed stream");
    return values;
}

std::vector<std::byte> octahedral(std::span<const Vec3f> normals) {
    std::vector<float> padded;
    padded.reserve(normals.size() * 4);
    for (const Vec3f& n : normals) padded.insert(padded.end(), {n.x, n.y, n.z, 0.0f});
    std::vector<std::byte> values(normals.size() * normal_bytes);
    meshopt_encodeFilterOct(values.data(), normals.size(), normal_bytes, normal_bits, padded.data());
    return values;
}

void undo_octahedral(std::span<std::byte> values) {
    meshopt_decodeFilterOct(values.data(), values.size() / normal_bytes, normal_bytes);
}

}  // namespace lodestream::codec
