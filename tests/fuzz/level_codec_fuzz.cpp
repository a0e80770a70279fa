// libFuzzer over the readers of encoded levels and points: bytes that do not begin as a GLB are read as a Draco stream.
// See run.sh.
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/codec/draco_mesh.h"
#include "common/codec/level_codec.h"
#include "common/codec/points_codec.h"
#include "tests/fuzz/input.h"

namespace {

using lodestream::fuzz::require;

constexpr std::uint64_t max_elements = 1'000'000;

void check(const lodestream::codec::Decoded& decoded) {
    for (const auto& primitive : decoded.primitives) {
        require(primitive.material < decoded.materials.size());
        for (const auto& triangle : primitive.mesh.triangles)
            for (const std::uint32_t vertex : triangle) require(vertex < primitive.mesh.positions.size());
        for (const auto& position : primitive.mesh.positions) require(lodestream::all_finite(position));
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto bytes = std::as_bytes(std::span(data, size));
    if (size > 4 && data[0] == 'g') {
        const auto decoded = lodestream::codec::decode_level(bytes);
        if (decoded) check(*decoded);
        const auto points = lodestream::codec::decode_points(bytes);
        if (points) lodestream::fuzz::check(*points);
        return 0;
    }
    const auto mesh = lodestream::codec::decode_draco(bytes, max_elements, max_elements);
    if (!mesh) return 0;
    for (const auto& triangle : mesh->triangles)
        for (const std::uint32_t vertex : triangle) require(vertex < mesh->points);
    return 0;
}
