// Prints what our own decoder makes of each GLB, one JSON object a line (null where it refuses one, the reason on
// stderr), for validate.mjs to compare with others'.
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"

namespace {

using namespace lodestream;

std::vector<std::byte> read(const char* file) {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    return {bytes, bytes + text.size()};
}

void inspect(const char* file) {
    const auto level = codec::decode_level(read(file));
    if (!level) {
        std::fprintf(stderr, "glb_inspect: %s: %s\n", file, level.error().message.c_str());
        std::puts("null");
        return;
    }
    std::size_t gouraud = 0, flat = 0;
    Box box;
    for (const codec::Primitive& primitive : level->primitives) {
        (primitive.shading == codec::Shading::gouraud ? gouraud : flat) += primitive.mesh.triangles.size();
        const Box bounds = mesh::bounds(primitive.mesh);
        if (bounds.empty()) continue;
        box.add(bounds.min + level->origin);
        box.add(bounds.max + level->origin);
    }
    std::printf(R"({"triangles":%zu,"gouraud":%zu,"flat":%zu,"bounds":[%.17g,%.17g,%.17g,%.17g,%.17g,%.17g]})"
                "\n",
                gouraud + flat, gouraud, flat, box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z);
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
