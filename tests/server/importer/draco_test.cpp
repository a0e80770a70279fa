#include <gmock/gmock.h>

#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "tests/server/importer/gltf_builder.h"
#include "tests/server/importer/sane.h"
#include "tests/support/meshes.h"

namespace lodestream::importer {
namespace {

using ::testing::HasSubstr;

std::string encoded_sphere() {
    mesh::Model model;
    model.mesh = testing::sphere(12);
    model.materials.emplace_back().base_color = {1, 0, 0, 1};
    codec::EncodeOptions options;
    options.grid = codec::choose_grid(mesh::bounds(model.mesh), 1e-3, 0.3);
    std::vector<std::uint8_t> gouraud(model.mesh.triangles.size(), 1);
    for (std::size_t i = 0; i < gouraud.size() / 2; ++i) gouraud[i] = 0;
    const auto encoded = codec::encode_level(model, model.mesh, gouraud, options);
    EXPECT_TRUE(encoded.ok());
    return {reinterpret_cast<const char*>(encoded->glb.data()), encoded->glb.size()};
}

TEST(ImportDraco, ReadsWhatTheLevelCodecWrites) {
    const auto model = testing::import_glb(encoded_sphere());
    ASSERT_TRUE(model.ok()) << model.error().message;
    testing::expect_sane(*model, "sphere");
    EXPECT_EQ(model->mesh.triangles.size(), 2u * 12 * 11);
    EXPECT_EQ(model->materials[0].base_color, Vec4f(1, 0, 0, 1));
    for (const Vec3f& p : model->mesh.positions) EXPECT_NEAR(glm::length(p), 1.0f, 0.01f);
}

TEST(ImportDraco, DamagedStreamsAreRefusedOrSane) {
    const std::string good = encoded_sphere();
    for (std::size_t at = good.size() / 2; at < good.size(); at += 7) {
        std::string bad = good;
        bad[at] = static_cast<char>(bad[at] ^ 0x41);
        const auto model = testing::import_glb(bad);
        if (model.ok()) testing::expect_sane(*model, std::to_string(at));
    }
}

TEST(ImportDraco, RefusesPrimitivesWhoseStreamIsNotThere) {
    const auto b = testing::triangle_builder();
    const auto with = [&](const std::string& extension) {
        return testing::import_glb(
                   b.glb(testing::mesh_of(
                             "\"attributes\":{\"POSITION\":0},\"extensions\":{\"KHR_draco_mesh_compression\":" +
                             extension + "}") +
                         "," + testing::one_node))
            .error()
            .message;
    };
    EXPECT_THAT(with("{\"bufferView\":9,\"attributes\":{\"POSITION\":0}}"), HasSubstr("buffer view 9"));
    EXPECT_THAT(with("{\"attributes\":{\"POSITION\":0}}"), HasSubstr("buffer view -1"));
    EXPECT_THAT(with("{\"bufferView\":0,\"attributes\":{\"POSITION\":0}}"), HasSubstr("mesh 0 primitive 0"));
}

}  // namespace
}  // namespace lodestream::importer
