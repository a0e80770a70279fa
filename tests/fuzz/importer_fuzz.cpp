// libFuzzer over every format of the importer: the first byte picks the format, the rest is the file. See run.sh.
#include <cmath>
#include <cstdlib>

#include "server/importer/importer.h"

namespace {

using namespace lodestream;

void expect(bool holds) {
    if (!holds) std::abort();
}

void expect_sane(const mesh::Mesh& mesh, const mesh::Model& model) {
    const std::size_t n = mesh.positions.size();
    const bool is_cloud = model.kind == mesh::Kind::points;
    expect(n > 0 && is_cloud == mesh.triangles.empty());
    expect(is_cloud || (!model.materials.empty() && mesh.normals.size() == n));
    for (const Vec3f& p : mesh.positions) expect(all_finite(p));
    for (const Vec3f& v : mesh.normals) expect(std::abs(glm::length(v) - 1.0f) < 1e-3f);
    for (const mesh::Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) expect(v < n);
    for (const std::uint32_t m : mesh.triangle_materials) expect(m < model.materials.size());
}

void expect_sane(const mesh::Model& model) {
    expect(all_finite(model.origin));
    if (model.instances.empty() || !model.mesh.triangles.empty()) expect_sane(model.mesh, model);
    for (const mesh::Mesh& shape : model.shapes) expect_sane(shape, model);
    for (const mesh::Instance& instance : model.instances)
        expect(instance.shape < model.shapes.size() && instance.object < model.graph.object_nodes.size());
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
