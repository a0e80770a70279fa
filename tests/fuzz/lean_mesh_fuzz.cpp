// libFuzzer over the geometry of lean levels. The input's first part makes a mesh, whose edges any number of triangles
// share, which is encoded and must come back; the rest changes bytes of that code, so that most of what is read is
// nearly right. See run.sh.
#include <cstddef>
#include <cstdint>

#include "common/codec/lean_mesh.h"
#include "tests/fuzz/input.h"

namespace {

using namespace lodestream;
using fuzz::Bytes, fuzz::require, fuzz::take;

constexpr std::uint64_t max_elements = 100'000;

std::int32_t take_coordinate(Bytes& bytes) {
    const auto value = static_cast<std::int8_t>(take(bytes));
    return value == 127 ? codec::max_lean_coordinate : value == -128 ? -codec::max_lean_coordinate : value;
}

codec::LeanMesh mesh_of(Bytes& bytes) {
    codec::LeanMesh mesh;
    const std::uint32_t positions = 3 + take(bytes) % 60, points = positions + take(bytes) % 20;
    const std::uint8_t attributes = take(bytes);
    if (attributes & 1) mesh.attributes.push_back({codec::LeanAttribute::Kind::texture_coordinate, {}, {}});
    if (attributes & 2) mesh.attributes.push_back({codec::LeanAttribute::Kind::color, {}, {}});
    for (std::uint32_t p = 0; p < positions; ++p)
        mesh.positions.push_back({take_coordinate(bytes), take_coordinate(bytes), take_coordinate(bytes)});
    for (std::uint32_t p = 0; p < points; ++p) {
        mesh.position_of_point.push_back(mesh.attributes.empty() || p < positions ? p % positions
                                                                                  : take(bytes) % positions);
        for (codec::LeanAttribute& attribute : mesh.attributes)
            for (std::size_t c = 0; c < attribute.components(); ++c) attribute.values.push_back(take(bytes));
    }
    if (mesh.attributes.empty()) mesh.position_of_point.resize(positions);
    const auto count = static_cast<std::uint32_t>(mesh.position_of_point.size());
    for (std::uint32_t t = 0, triangles = take(bytes); t < triangles; ++t) {
        const std::uint32_t a = take(bytes) % count, b = (a + 1 + take(bytes) % 5) % count;
        const std::uint32_t c = (a + 6 + take(bytes) % 5) % count;
        const std::uint32_t at = mesh.position_of_point[a], bt = mesh.position_of_point[b],
                            ct = mesh.position_of_point[c];
        if (at != bt && bt != ct && ct != at) mesh.triangles.push_back({a, b, c});
    }
    return mesh;
}

void check(const codec::LeanMesh& mesh) {
    for (const std::uint32_t position : mesh.position_of_point) require(position < mesh.positions.size());
    for (const codec::LeanAttribute& attribute : mesh.attributes)
        require(attribute.values.size() == attribute.components() * mesh.position_of_point.size());
    for (const mesh::Triangle& triangle : mesh.triangles)
        for (const std::uint32_t point : triangle) require(point < mesh.position_of_point.size());
}

void check_came_back(const codec::LeanMesh& source, const codec::LeanMesh& read,
                     const std::vector<std::uint32_t>& source_corners) {
    require(read.triangles.size() == source.triangles.size() && source_corners.size() == 3 * source.triangles.size());
    for (std::size_t corner = 0; corner < source_corners.size(); ++corner) {
        const std::uint32_t from = source_corners[corner];
        const std::uint32_t was = source.triangles[from / 3][from % 3], is = read.triangles[corner / 3][corner % 3];
        require(source.positions[source.position_of_point[was]] == read.positions[read.position_of_point[is]]);
        for (std::size_t a = 0; a < source.attributes.size(); ++a)
            for (std::size_t c = 0, n = source.attributes[a].components(); c < n; ++c)
                require(source.attributes[a].values[n * was + c] == read.attributes[a].values[n * is + c]);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Bytes bytes(data, size);
    const codec::LeanMesh source = mesh_of(bytes);
    codec::EncodedLeanMesh encoded = codec::encode_lean_mesh(source);
    const auto read = codec::decode_lean_mesh(encoded.bytes, max_elements, max_elements);
    require(read.ok());
    check(*read);
    check_came_back(source, *read, encoded.source_corners);

    while (!bytes.empty()) encoded.bytes[take(bytes) % encoded.bytes.size()] ^= static_cast<std::byte>(take(bytes));
    if (const auto damaged = codec::decode_lean_mesh(encoded.bytes, max_elements, max_elements)) check(*damaged);
    return 0;
}
