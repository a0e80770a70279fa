// Prints what our own decoder makes of each GLB, one JSON object a line (null where it refuses one, the reason on
// stderr), for validate.mjs to compare with others'.
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/codec/level_codec.h"
#include "common/codec/points_codec.h"
#include "common/mesh/operations.h"

namespace {

using namespace lodestream;

std::vector<std::byte> read(const char* file) {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    return {bytes, bytes + text.size()};
}

struct Found {
    std::size_t gouraud = 0, flat = 0, points = 0;
    Box box;
};

Result<Found> inspect_level(const std::vector<std::byte>& glb) {
    const auto level = codec::decode_level(glb);
    if (!level) return level.error();
    Found found;
    for (const codec::Primitive& primitive : level->primitives) {
        (primitive.shading == codec::Shading::gouraud ? found.gouraud : found.flat) += primitive.mesh.triangles.size();
        const Box bounds = mesh::bounds(primitive.mesh);
        if (bounds.empty()) continue;
        found.box.add(bounds.min + level->origin);
        found.box.add(bounds.max + level->origin);
    }
    return found;
}

Result<Found> inspect_points(const std::vector<std::byte>& glb) {
    const auto decoded = codec::decode_points(glb);
    if (!decoded) return decoded.error();
    Found found;
    found.points = decoded->content.cloud.positions.size();
    for (const Vec3f& p : decoded->content.cloud.positions) found.box.add(Vec3d(p) + decoded->content.origin);
    return found;
}

void inspect(const char* file) {
    const std::vector<std::byte> glb = read(file);
    Result<Found> found = inspect_points(glb);
    if (!found) found = inspect_level(glb);
    if (!found) {
        std::fprintf(stderr, "glb_inspect: %s: %s\n", file, found.error().message.c_str());
        std::puts("null");
        return;
    }
    const Box& box = found->box;
    std::printf(
        R"({"triangles":%zu,"gouraud":%zu,"flat":%zu,"points":%zu,"bounds":[%.17g,%.17g,%.17g,%.17g,%.17g,%.17g]})"
        "\n",
        found->gouraud + found->flat, found->gouraud, found->flat, found->points, box.min.x, box.min.y, box.min.z,
        box.max.x, box.max.y, box.max.z);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fputs("usage: glb_inspect FILE.glb...\n", stderr);
        return 2;
    }
    for (int i = 1; i < argc; ++i) inspect(argv[i]);
    return 0;
}
