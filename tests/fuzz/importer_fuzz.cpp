// libFuzzer over every format of the importer: the first byte picks the format, the rest is the file. See run.sh.
#include <cmath>
#include <cstdlib>

#include "server/importer/importer.h"

namespace {

using namespace lodestream;

void expect(bool holds) {
    if (!holds) std::abort();
}

void expect_sane(const mesh::Model& model) {
    const std::size_t n = model.mesh.positions.size();
    const bool is_cloud = model.kind == mesh::Kind::points;
    expect(n > 0 && is_cloud == model.mesh.triangles.empty());
    expect(is_cloud || (!model.materials.empty() && model.mesh.normals.size() == n));
    expect(all_finite(model.origin));
    for (const Vec3f& p : model.mesh.positions) expect(all_finite(p));
    for (const Vec3f& v : model.mesh.normals) expect(std::abs(glm::length(v) - 1.0f) < 1e-3f);
    for (const mesh::Triangle& t : model.mesh.triangles)
        for (const std::uint32_t v : t) expect(v < n);
    for (const std::uint32_t m : model.mesh.triangle_materials) expect(m < model.materials.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    constexpr int formats = static_cast<int>(importer::Format::terrain_asc) + 1;
    const auto format = static_cast<importer::Format>(data[0] % formats);
    importer::Limits limits;
    limits.vertices = 100'000;
    limits.triangles = 100'000;
    const auto* bytes = reinterpret_cast<const std::byte*>(data + 1);
    const auto model = importer::import_model({bytes, size - 1}, format, importer::no_side_files(), limits);
    if (model) expect_sane(*model);
    return 0;
}
