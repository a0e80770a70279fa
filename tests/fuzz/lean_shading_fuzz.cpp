// libFuzzer over what a lean level has beside its Draco stream. The input's first part makes shadings, which are
// encoded and must come back; the rest changes bytes of that code, so that most of what is read is nearly right. See
// run.sh.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/codec/lean_shading.h"
#include "tests/fuzz/input.h"

namespace {

using namespace lodestream;
using fuzz::Bytes, fuzz::require, fuzz::take;

// A bumpy sheet, some of whose triangles have no area.
struct Sheet {
    std::vector<Vec3f> positions;
    std::vector<mesh::Triangle> triangles;
};

Sheet sheet_of(Bytes& bytes) {
    const std::uint32_t side = 2 + take(bytes) % 7;
    Sheet sheet;
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) sheet.positions.emplace_back(x, take(bytes) / 64.0f, y);
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t a = y * side + x, b = a + side;
            sheet.triangles.push_back({a, b, a + 1});
            sheet.triangles.push_back(x == y ? mesh::Triangle{a, a, b} : mesh::Triangle{a + 1, b, b + 1});
        }
    return sheet;
}

codec::WantedShading shading_of(const Sheet& sheet, Bytes& bytes) {
    codec::WantedShading wanted;
    for (int n = 0; n < 16; ++n)
        wanted.normals.emplace_back(static_cast<std::int8_t>(take(bytes)), static_cast<std::int8_t>(take(bytes)),
                                    static_cast<std::int8_t>(take(bytes)));
    for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
        const std::uint8_t choice = take(bytes);
        wanted.gouraud.push_back(choice % 3 > 0 ? 1 : 0);
        for (std::uint32_t k = 0; k < 3; ++k) wanted.normal_of_corner.push_back(choice % 2 ? (choice >> k) % 16 : 0);
    }
    return wanted;
}

void check(const Sheet& sheet, const codec::LeanShading& read) {
    require(read.gouraud.size() == sheet.triangles.size() && read.normals.size() == sheet.positions.size());
    for (const std::vector<Vec3f>* normals : {&read.normals, &read.further_normals})
        for (const Vec3f& n : *normals) require(std::abs(glm::length(n) - 1.0f) < 0.01f);
    for (const codec::FurtherNormal& further : read.further)
        require(further.corner < 3 * sheet.triangles.size() && further.normal < read.further_normals.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Bytes bytes(data, size);
    const double tolerance = 0.1 + take(bytes) / 8.0;
    const Sheet sheet = sheet_of(bytes);
    const codec::WantedShading wanted = shading_of(sheet, bytes);
    std::vector<std::byte> code = codec::encode_lean_shading(sheet.positions, sheet.triangles, wanted, tolerance);
    const auto read = codec::decode_lean_shading(sheet.positions, sheet.triangles, code);
    require(read.ok() && read->gouraud == wanted.gouraud);
    check(sheet, *read);

    while (!bytes.empty()) code[take(bytes) % code.size()] ^= static_cast<std::byte>(take(bytes));
    if (const auto damaged = codec::decode_lean_shading(sheet.positions, sheet.triangles, code)) check(sheet, *damaged);
    return 0;
}
