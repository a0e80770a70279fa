#include <gmock/gmock.h>
#include <meshoptimizer.h>

#include "tests/server/importer/gltf_builder.h"
#include "tests/server/importer/sane.h"

namespace lodestream::importer {
namespace {

using ::testing::HasSubstr;
using namespace lodestream::testing;

std::string encoded_vertices(const std::string& data, std::size_t count, std::size_t stride) {
    std::string out(meshopt_encodeVertexBufferBound(count, stride), '\0');
    out.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(out.data()), out.size(), data.data(), count,
                                          stride));
    return out;
}

std::string encoded_indices(const std::vector<unsigned>& indices, std::size_t vertices, bool sequence) {
    std::string out(meshopt_encodeIndexBufferBound(indices.size(), vertices) +
                        meshopt_encodeIndexSequenceBound(indices.size(), vertices),
                    '\0');
    auto* to = reinterpret_cast<unsigned char*>(out.data());
    out.resize(sequence ? meshopt_encodeIndexSequence(to, out.size(), indices.data(), indices.size())
                        : meshopt_encodeIndexBuffer(to, out.size(), indices.data(), indices.size()));
    return out;
}

// A view over the placeholder buffer 1 whose bytes are `encoded` in buffer 0.
int compressed_view(GltfBuilder& b, const std::string& encoded, std::size_t count, std::size_t stride,
                    const std::string& mode, const std::string& filter = "NONE") {
    b.view(encoded);
    const std::size_t offset = b.binary_size() - encoded.size();
    std::string json = "{\"buffer\":1,\"byteLength\":" + std::to_string(count * stride);
    if (mode == "ATTRIBUTES") json += ",\"byteStride\":" + std::to_string(stride);
    json += ",\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":0,\"byteOffset\":" + std::to_string(offset);
    json += ",\"byteLength\":" + std::to_string(encoded.size()) + ",\"byteStride\":" + std::to_string(stride);
    json += ",\"count\":" + std::to_string(count) + ",\"mode\":\"" + mode + "\",\"filter\":\"" + filter + "\"}}}";
    return b.raw_view(json);
}

std::string document(const GltfBuilder& b, const std::string& primitive) {
    return b.glb("\"extensionsRequired\":[\"EXT_meshopt_compression\",\"KHR_mesh_quantization\"]," +
                     mesh_of(primitive) + "," + one_node,
                 ",{\"byteLength\":1000,\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":true}}}");
}

const std::string quad = floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});

TEST(ImportMeshopt, ReadsVerticesTrianglesAndSequences) {
    for (const bool sequence : {false, true}) {
        GltfBuilder b;
        b.accessor(compressed_view(b, encoded_vertices(quad, 4, 12), 4, 12, "ATTRIBUTES"), gl_float, 4, "VEC3");
        b.accessor(compressed_view(b, encoded_indices({0, 1, 2, 0, 2, 3}, 4, sequence), 6, 2,
                                   sequence ? "INDICES" : "TRIANGLES"),
                   gl_unsigned_short, 6, "SCALAR");
        const auto model = import_glb(document(b, "\"indices\":1,\"attributes\":{\"POSITION\":0}"));
        ASSERT_TRUE(model.ok()) << model.error().message;
        EXPECT_EQ(model->mesh.triangles.size(), 2u);
        expect_sane(*model, "meshopt");
        EXPECT_EQ(mesh::Kind::mesh, model->kind);
    }
}

TEST(ImportMeshopt, AppliesOctahedralAndExponentialFilters) {
    GltfBuilder b;
    const std::vector<float> normals = {0, 0, 1, 0, 1, 0, 0, 0, 0, 0.6f, 0.8f, 0};
    std::string oct(3 * 4, '\0');
    meshopt_encodeFilterOct(oct.data(), 3, 4, 8, normals.data());
    const std::vector<float> positions = {0, 0, 0, 1.5f, 0, 0, 0, -2.25f, 0};
    std::string exponential(3 * 12, '\0');
    meshopt_encodeFilterExp(exponential.data(), 3, 12, 15, positions.data());
    b.accessor(compressed_view(b, encoded_vertices(exponential, 3, 12), 3, 12, "ATTRIBUTES", "EXPONENTIAL"), gl_float,
               3, "VEC3");
    b.accessor(compressed_view(b, encoded_vertices(oct, 3, 4), 3, 4, "ATTRIBUTES", "OCTAHEDRAL"), gl_byte, 3, "VEC3",
               ",\"normalized\":true");
    const auto model = import_glb(document(b, "\"attributes\":{\"POSITION\":0,\"NORMAL\":1}"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.positions[1], Vec3f(1.5f, 0, 0));
    EXPECT_EQ(model->mesh.positions[2], Vec3f(0, -2.25f, 0));
    EXPECT_LT(glm::distance(model->mesh.normals[1], Vec3f(1, 0, 0)), 0.02f);
    EXPECT_LT(glm::distance(model->mesh.normals[2], Vec3f(0, 0.6f, 0.8f)), 0.02f);
}

TEST(ImportMeshopt, AppliesTheQuaternionFilter) {
    auto b = triangle_builder();
    const std::vector<float> half_turn = {0, 0, 1, 0};
    std::string quaternion(8, '\0');
    meshopt_encodeFilterQuat(quaternion.data(), 1, 8, 16, half_turn.data());
    b.accessor(compressed_view(b, encoded_vertices(quaternion, 1, 8), 1, 8, "ATTRIBUTES", "QUATERNION"), gl_short, 1,
               "VEC4", ",\"normalized\":true");
    const auto model = import_glb(b.glb(
        "\"extensionsUsed\":[\"EXT_meshopt_compression\"]," + one_mesh +
            ",\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"ROTATION\":1}}}}]",
        ",{\"byteLength\":8,\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":true}}}"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_LT(glm::distance(model->mesh.positions[1], Vec3f(-1, 0, 0)), 1e-3f);
}

TEST(ImportMeshopt, RefusesDamageAndImpossibleCounts) {
    const std::string good = encoded_vertices(quad, 4, 12);
    const auto error = [](const std::string& encoded, std::size_t count, std::size_t stride, const std::string& mode,
                          const std::string& filter) {
        GltfBuilder b;
        b.accessor(compressed_view(b, encoded, count, stride, mode, filter), gl_float, 3, "VEC3");
        const auto model = import_glb(document(b, "\"attributes\":{\"POSITION\":0}"));
        return model.ok() ? std::string("accepted") : model.error().message;
    };
    EXPECT_THAT(error(good.substr(0, good.size() / 2), 4, 12, "ATTRIBUTES", "NONE"), HasSubstr("damaged"));
    EXPECT_THAT(error("x" + good.substr(1), 4, 12, "ATTRIBUTES", "NONE"), HasSubstr("damaged"));
    EXPECT_THAT(error(good, 400'000'000, 12, "ATTRIBUTES", "NONE"), HasSubstr("more than it can hold"));
    EXPECT_THAT(error(good, 4, 0, "ATTRIBUTES", "NONE"), HasSubstr("no valid mode"));
    EXPECT_THAT(error(good, 4, 260, "ATTRIBUTES", "NONE"), HasSubstr("byteStride"));
    EXPECT_THAT(error(good, 4, 12, "WHAT", "NONE"), HasSubstr("no valid mode"));
    EXPECT_THAT(error(good, 4, 2, "TRIANGLES", "NONE"), HasSubstr("no valid mode"));
    EXPECT_THAT(error(good, 4, 12, "ATTRIBUTES", "OCTAHEDRAL"), HasSubstr("filter"));
    EXPECT_THAT(error(good, 4, 12, "ATTRIBUTES", "UNKNOWN"), HasSubstr("filter"));
}

TEST(ImportMeshopt, PlaceholderBuffersHoldNoData) {
    GltfBuilder b;
    b.view(quad);
    b.accessor(b.raw_view("{\"buffer\":1,\"byteLength\":48}"), gl_float, 4, "VEC3");
    EXPECT_THAT(import_glb(document(b, "\"attributes\":{\"POSITION\":0}")).error().message,
                HasSubstr("outside its buffer"));
}

}  // namespace
}  // namespace lodestream::importer
