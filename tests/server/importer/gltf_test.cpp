#include <gmock/gmock.h>

#include "common/codec/points_codec.h"
#include "tests/server/importer/gltf_builder.h"
#include "tests/server/importer/sane.h"

namespace lodestream::importer {
namespace {

using ::testing::HasSubstr;
using namespace lodestream::testing;

// Positions by triangle corner, in world space.
std::vector<Vec3d> corners(const mesh::Model& model) {
    std::vector<Vec3d> out;
    for (const mesh::Triangle& t : model.mesh.triangles)
        for (const std::uint32_t v : t) out.push_back(Vec3d(model.mesh.positions[v]) + model.origin);
    return out;
}

TEST(ImportGltf, ReadsNonIndexedTriangles) {
    const auto model = import_glb(triangle_builder().glb(one_mesh + "," + one_node));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(corners(*model), (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(model->mesh.normals[0], Vec3f(0, 0, 1));
    EXPECT_EQ(model->kind, mesh::Kind::mesh);
    EXPECT_THAT(model.warnings, ::testing::IsEmpty());
}

TEST(ImportGltf, ReadsStripsAndFansInTheirDirection) {
    for (const auto& [mode, positions] : {std::pair{5, floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0})},
                                          std::pair{6, floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0})}}) {
        GltfBuilder b;
        b.accessor(b.view(positions), gl_float, 4, "VEC3");
        b.accessor(b.view(std::string("\0\1\2\3", 4)), gl_unsigned_byte, 4, "SCALAR");
        for (const std::string indices : {"", ",\"indices\":1"}) {
            const auto model = import_glb(
                b.glb(mesh_of("\"mode\":" + std::to_string(mode) + indices + ",\"attributes\":{\"POSITION\":0}") + "," +
                      one_node));
            ASSERT_TRUE(model.ok()) << model.error().message;
            ASSERT_EQ(model->mesh.triangles.size(), 2u);
            for (const Vec3f& n : model->mesh.normals) EXPECT_EQ(n, Vec3f(0, 0, 1));
        }
    }
}

const std::string points_primitive = "\"mode\":0,\"attributes\":{\"POSITION\":0}";

TEST(ImportGltf, PointsWithoutTrianglesAreACloudInWorldCoordinates) {
    const auto model = import_glb(triangle_builder().glb(
        "\"meshes\":[{\"primitives\":[{" + points_primitive + "},{\"mode\":1,\"attributes\":{\"POSITION\":0}}]}]," +
        "\"nodes\":[{\"mesh\":0,\"scale\":[2,2,2]}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0"));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(model->kind, mesh::Kind::points);
    EXPECT_TRUE(model->mesh.triangles.empty());
    ASSERT_EQ(model->mesh.positions.size(), 3u);
    EXPECT_EQ(Vec3d(model->mesh.positions[1]) + model->origin, Vec3d(2, 0, 0));
    EXPECT_TRUE(model->mesh.colors.empty());
    EXPECT_TRUE(mentions(model.warnings, "1 point or line left out"));
}

TEST(ImportGltf, PointsHaveTheirMaterialsColour) {
    GltfBuilder b = triangle_builder();
    b.accessor(b.view(floats({1, 1, 1, 0, 1, 0, 1, 1, 1})), gl_float, 3, "VEC3");
    const auto model =
        import_glb(b.glb(mesh_of("\"mode\":0,\"material\":0,\"attributes\":{\"POSITION\":0,\"COLOR_0\":1}") + "," +
                         one_node + ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.2,0,1]}}]"));
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_EQ(model->mesh.colors.size(), 3u);
    EXPECT_EQ(model->mesh.colors[0], Rgba8(255, 51, 0, 255));
    EXPECT_EQ(model->mesh.colors[1], Rgba8(0, 51, 0, 255));
}

TEST(ImportGltf, PointsThatOurOwnEncodersWroteComeBack) {
    codec::Points points;
    points.cloud.positions = {{0.25f, 0, 0}, {1, 0.5f, 0}, {0, 1, 0.75f}};  // as they lie along the Z-order curve
    points.cloud.normals = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
    points.origin = {1000, -2, 3};
    Box box;
    for (const Vec3f& p : points.cloud.positions) box.add(Vec3d(p));
    points.grid = codec::point_grid(box);
    points.levels = {{3, {}, 1e-3}};
    const auto plain = codec::encode_points(points);
    const auto lean = codec::encode_lean_points(points);
    ASSERT_TRUE(plain && lean);
    for (const std::vector<std::byte>& glb : {plain->glb, *lean}) {
        const auto model = import_glb(std::string(reinterpret_cast<const char*>(glb.data()), glb.size()));
        ASSERT_TRUE(model) << model.error().message;
        EXPECT_EQ(model->kind, mesh::Kind::points);
        ASSERT_EQ(model->mesh.positions.size(), 3u);
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3d there = Vec3d(points.cloud.positions[i]) + points.origin;
            EXPECT_LT(length(Vec3d(model->mesh.positions[i]) + model->origin - there), 1e-4) << i;
            EXPECT_GT(dot(model->mesh.normals[i], points.cloud.normals[i]), 0.999f);
        }
    }
}

TEST(ImportGltf, LinesAloneAreRefused) {
    const auto alone = import_glb(triangle_builder().glb(
        "\"meshes\":[{\"primitives\":[{\"mode\":1,\"attributes\":{\"POSITION\":0}}]}]," + one_node));
    EXPECT_THAT(alone.error().message, HasSubstr("but no triangles"));
}

TEST(ImportGltf, PointsBesideTrianglesAreLeftOut) {
    const std::string points = "{" + points_primitive + "}";
    const auto beside = import_glb(triangle_builder().glb("\"meshes\":[{\"primitives\":[" + points +
                                                          ",{\"attributes\":{\"POSITION\":0}}]}]," + one_node));
    ASSERT_TRUE(beside.ok());
    EXPECT_TRUE(mentions(beside.warnings, "left out"));
}

TEST(ImportGltf, ReadsInterleavedAndOffsetAttributes) {
    GltfBuilder b;
    const int view = b.view(floats({9, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0}), ",\"byteStride\":24");
    b.raw_accessor("{\"bufferView\":" + std::to_string(view) +
                   ",\"byteOffset\":4,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}");
    b.raw_accessor("{\"bufferView\":" + std::to_string(view) +
                   ",\"byteOffset\":16,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}");
    const auto model = import_glb(b.glb(mesh_of("\"attributes\":{\"POSITION\":0}") + "," + one_node));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(corners(*model), (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    // The second accessor's last element would end beyond its view.
    EXPECT_THAT(
        import_glb(b.glb(mesh_of("\"attributes\":{\"POSITION\":0,\"NORMAL\":1}") + "," + one_node)).error().message,
        HasSubstr("beyond its buffer view"));
}

TEST(ImportGltf, ReadsEveryQuantizedType) {
    const auto check = [](const std::string& data, int type, bool normalized, const Vec3d& second) {
        GltfBuilder b;
        b.accessor(b.view(data), type, 3, "VEC3", normalized ? ",\"normalized\":true" : "");
        const auto model = import_glb(b.glb("\"extensionsRequired\":[\"KHR_mesh_quantization\"]," +
                                            mesh_of("\"attributes\":{\"POSITION\":0}") + "," + one_node));
        ASSERT_TRUE(model.ok()) << model.error().message;
        EXPECT_LT(glm::distance(corners(*model)[1], second), 1e-6) << type << normalized;
    };
    const auto pack = [](auto low, auto high) {
        using T = decltype(low);
        return BinaryWriter().put_all<T>({0, 0, 0, high, low, 0, 0, high, 0}).data();
    };
    check(pack(std::int8_t{-127}, std::int8_t{127}), gl_byte, true, {1, -1, 0});
    check(pack(std::int8_t{-128}, std::int8_t{127}), gl_byte, true, {1, -1, 0});
    check(pack(std::int8_t{-128}, std::int8_t{127}), gl_byte, false, {127, -128, 0});
    check(pack(std::uint8_t{51}, std::uint8_t{255}), gl_unsigned_byte, true, {1, 0.2, 0});
    check(pack(std::uint8_t{51}, std::uint8_t{255}), gl_unsigned_byte, false, {255, 51, 0});
    check(pack(std::int16_t{-32767}, std::int16_t{32767}), gl_short, true, {1, -1, 0});
    check(pack(std::int16_t{-5}, std::int16_t{7}), gl_short, false, {7, -5, 0});
    check(pack(std::uint16_t{13107}, std::uint16_t{65535}), gl_unsigned_short, true, {1, 0.2, 0});
    check(pack(std::uint16_t{3}, std::uint16_t{4}), gl_unsigned_short, false, {4, 3, 0});
}

TEST(ImportGltf, AppliesSparseValuesOverDataAndOverZeros) {
    for (const bool over_zeros : {false, true}) {
        GltfBuilder b;
        const int base = over_zeros ? -1 : b.view(floats({0, 0, 0, 1, 0, 0, 0, 1, 0}));
        const int indices = b.view(shorts({1, 2}));
        const int values = b.view(floats({5, 0, 0, 0, 6, 0}));
        const auto sparse = [&](int first) {
            (void)first;
            return ",\"sparse\":{\"count\":2,\"indices\":{\"bufferView\":" + std::to_string(indices) +
                   ",\"componentType\":5123},\"values\":{\"bufferView\":" + std::to_string(values) + "}}";
        };
        b.accessor(base, gl_float, 3, "VEC3", sparse(0));
        const auto model = import_glb(b.glb(one_mesh + "," + one_node));
        ASSERT_TRUE(model.ok()) << model.error().message;
        EXPECT_EQ(corners(*model), (std::vector<Vec3d>{{0, 0, 0}, {5, 0, 0}, {0, 6, 0}}));
    }
}

TEST(ImportGltf, RefusesSparseOutOfRange) {
    for (const std::string& part : std::vector<std::string>{
             "\"count\":4,\"indices\":{\"bufferView\":1,\"componentType\":5123},\"values\":{\"bufferView\":0}",
             "\"count\":1,\"indices\":{\"bufferView\":1,\"componentType\":5123},\"values\":{\"bufferView\":0}",
             "\"count\":2,\"indices\":{\"bufferView\":1,\"componentType\":5123},\"values\":{\"bufferView\":0}",
             "\"count\":-1,\"indices\":{\"bufferView\":1,\"componentType\":5123},\"values\":{\"bufferView\":0}",
             "\"count\":1,\"indices\":{\"bufferView\":1,\"componentType\":5126},\"values\":{\"bufferView\":0}",
             "\"count\":1,\"indices\":{\"bufferView\":7,\"componentType\":5123},\"values\":{\"bufferView\":0}"}) {
        GltfBuilder b;
        const int view = b.view(floats({0, 0, 0, 1, 0, 0, 0, 1, 0}));
        b.view(shorts({9}));
        b.accessor(view, gl_float, 3, "VEC3", ",\"sparse\":{" + part + "}");
        const auto model = import_glb(b.glb(one_mesh + "," + one_node));
        ASSERT_FALSE(model.ok()) << part;
        EXPECT_EQ(model.error().code, ErrorCode::invalid_input);
    }
}

TEST(ImportGltf, RefusesIndicesOutOfRange) {
    auto b = triangle_builder();
    b.accessor(b.view(shorts({0, 1, 3})), gl_unsigned_short, 3, "SCALAR");
    const auto model = import_glb(b.glb(mesh_of("\"indices\":1,\"attributes\":{\"POSITION\":0}") + "," + one_node));
    EXPECT_THAT(model.error().message, HasSubstr("mesh 0 primitive 0: has the index 3 but only 3 vertices"));
}

TEST(ImportGltf, RefusesRangesThatOverflow) {
    const std::string huge = "18446744073709551615";
    for (const std::string& accessor :
         std::vector<std::string>{"\"byteOffset\":" + huge + ",\"count\":3", "\"byteOffset\":0,\"count\":" + huge,
                                  "\"byteOffset\":4,\"count\":3", "\"count\":4", "\"count\":6148914691236517206"}) {
        GltfBuilder b;
        b.view(floats({0, 0, 0, 1, 0, 0, 0, 1, 0}));
        b.raw_accessor("{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\"," + accessor + "}");
        EXPECT_FALSE(import_glb(b.glb(one_mesh + "," + one_node)).ok()) << accessor;
    }
    for (const std::string& view :
         std::vector<std::string>{"\"byteOffset\":" + huge + ",\"byteLength\":36",
                                  "\"byteOffset\":0,\"byteLength\":" + huge, "\"byteOffset\":8,\"byteLength\":36"}) {
        GltfBuilder b;
        b.view(floats({0, 0, 0, 1, 0, 0, 0, 1, 0}));
        b.accessor(b.raw_view("{\"buffer\":0," + view + "}"), gl_float, 3, "VEC3");
        EXPECT_FALSE(import_glb(b.glb(one_mesh + "," + one_node)).ok()) << view;
    }
}

TEST(ImportGltf, RefusesAttributesOfTheWrongKind) {
    for (const auto& [type, component] : {std::pair{"VEC2", gl_float}, std::pair{"SCALAR", gl_float},
                                          std::pair{"MAT4", gl_float}, std::pair{"VEC3", 5130}}) {
        GltfBuilder b;
        b.accessor(b.view(std::string(256, '\0')), component, 3, type);
        EXPECT_EQ(import_glb(b.glb(one_mesh + "," + one_node)).error().code, ErrorCode::invalid_input) << type;
    }
    auto b = triangle_builder();
    b.accessor(b.view(floats({0, 0, 1})), gl_float, 1, "VEC3");
    EXPECT_THAT(
        import_glb(b.glb(mesh_of("\"attributes\":{\"POSITION\":0,\"NORMAL\":1}") + "," + one_node)).error().message,
        HasSubstr("1 elements where 3"));
}

TEST(ImportGltf, AcceptsZeroLengthViewsBesideRealOnes) {
    auto b = triangle_builder();
    b.raw_view("{\"buffer\":0,\"byteLength\":0}");
    EXPECT_TRUE(import_glb(b.glb(one_mesh + "," + one_node)).ok());
}

TEST(ImportGltf, ComposesTransformsThroughTheHierarchy) {
    const auto model =
        import_glb(triangle_builder().glb(
            one_mesh + ",\"nodes\":[{\"children\":[1],\"translation\":[10,0,0],\"rotation\":[0,0,0.7071067811865476,0."
                       "7071067811865476]},"
                       "{\"mesh\":0,\"matrix\":[2,0,0,0,0,2,0,0,0,0,2,0,0,0,3,1]}],\"scenes\":[{\"nodes\":[0]}]"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    const std::vector<Vec3d> expected = {{10, 0, 3}, {10, 2, 3}, {8, 0, 3}};
    for (std::size_t i = 0; i < 3; ++i) EXPECT_LT(glm::distance(corners(*model)[i], expected[i]), 1e-5);
}

TEST(ImportGltf, MirroringTurnsTrianglesAndKeepsNormalsOutside) {
    auto b = triangle_builder();
    b.accessor(b.view(floats({0, 0, 1, 0, 0, 1, 0, 0, 1})), gl_float, 3, "VEC3");
    const auto model = import_glb(b.glb(mesh_of("\"attributes\":{\"POSITION\":0,\"NORMAL\":1}") +
                                        ",\"nodes\":[{\"mesh\":0,\"scale\":[-1,1,1]}]"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(corners(*model), (std::vector<Vec3d>{{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}}));
    EXPECT_EQ(model->mesh.normals[0], Vec3f(0, 0, 1));
}

TEST(ImportGltf, UnevenScaleTiltsNormalsByTheInverseTranspose) {
    auto b = triangle_builder();
    b.accessor(b.view(floats({1, 1, 0, 1, 1, 0, 1, 1, 0})), gl_float, 3, "VEC3");
    const auto model = import_glb(b.glb(mesh_of("\"attributes\":{\"POSITION\":0,\"NORMAL\":1}") +
                                        ",\"nodes\":[{\"mesh\":0,\"scale\":[2,1,1e-30]}]"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    expect_sane(*model, "scaled");
    EXPECT_NEAR(model->mesh.normals[0].y / model->mesh.normals[0].x, 2.0f, 1e-5f);
}

TEST(ImportGltf, NodesFarAwayKeepMillimetres) {
    const auto model = import_glb(
        triangle_builder().glb(one_mesh + ",\"nodes\":[{\"mesh\":0,\"translation\":[10000000.001,0,-5000000.002]}]"));
    ASSERT_TRUE(model.ok());
    EXPECT_NEAR(corners(*model)[0].x, 10000000.001, 1e-6);
    EXPECT_NEAR(corners(*model)[0].z, -5000000.002, 1e-6);
}

TEST(ImportGltf, ChoosesTheDefaultSceneElseAllRoots) {
    const std::string nodes =
        "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[5,0,0]},{\"mesh\":0,\"translation\":[9,0,0]}]";
    const std::string scenes = ",\"scenes\":[{\"nodes\":[0,2]},{\"nodes\":[1]}]";
    const auto named = import_glb(triangle_builder().glb(one_mesh + "," + nodes + scenes + ",\"scene\":1"));
    ASSERT_TRUE(named.ok());
    EXPECT_EQ(corners(*named)[0].x, 5);
    EXPECT_EQ(named->objects, 1u);
    const auto all = import_glb(triangle_builder().glb(one_mesh + "," + nodes + scenes));
    ASSERT_TRUE(all.ok());
    EXPECT_EQ(all->objects, 3u);
    EXPECT_EQ(all->kind, mesh::Kind::scene);
    EXPECT_EQ(all->mesh.triangles.size(), 3u);
}

TEST(ImportGltf, RefusesCyclesTwoParentsAndMissingNodes) {
    for (const std::string& nodes : std::vector<std::string>{
             "[{\"mesh\":0,\"children\":[0]}],\"scenes\":[{\"nodes\":[0]}]",
             "[{\"children\":[1]},{\"mesh\":0,\"children\":[0]}]",
             "[{\"children\":[1]},{\"mesh\":0,\"children\":[2]},{\"children\":[1]}],\"scenes\":[{\"nodes\":[0]}]",
             "[{\"children\":[1,1]},{\"mesh\":0}]", "[{\"mesh\":0,\"children\":[7]}]",
             "[{\"mesh\":0,\"children\":[-2]}]", "[{\"mesh\":4}]", "[{\"mesh\":0,\"matrix\":[1,2,3]}]",
             "[{\"mesh\":0}],\"scenes\":[{\"nodes\":[3]}],\"scene\":0"}) {
        const auto model = import_glb(triangle_builder().glb(one_mesh + ",\"nodes\":" + nodes));
        ASSERT_FALSE(model.ok()) << nodes;
        EXPECT_EQ(model.error().code, ErrorCode::invalid_input) << nodes;
    }
}

TEST(ImportGltf, DeepChainsEndAtTheLimit) {
    std::string nodes;
    for (int i = 1; i < 10'000; ++i) nodes += "{\"children\":[" + std::to_string(i) + "]},";
    const auto model = import_glb(
        triangle_builder().glb(one_mesh + ",\"nodes\":[" + nodes + "{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}]"));
    EXPECT_EQ(model.error().code, ErrorCode::limit_exceeded);
}

TEST(ImportGltf, DeepJsonEndsAtTheLimit) {
    const auto model = import_text(
        "{\"asset\":{\"version\":\"2.0\"},\"extras\":" + std::string(200'000, '[') + std::string(200'000, ']') + "}",
        Format::gltf);
    EXPECT_EQ(model.error().code, ErrorCode::limit_exceeded);
}

TEST(ImportGltf, InstancesCountAgainstTheLimits) {
    std::string nodes = "{\"mesh\":0}";
    for (int i = 0; i < 99; ++i) nodes += ",{\"mesh\":0}";
    Limits limits;
    limits.triangles = 99;
    EXPECT_EQ(import_glb(triangle_builder().glb(one_mesh + ",\"nodes\":[" + nodes + "]"), no_side_files(), limits)
                  .error()
                  .code,
              ErrorCode::limit_exceeded);
    limits.triangles = 100;
    EXPECT_TRUE(
        import_glb(triangle_builder().glb(one_mesh + ",\"nodes\":[" + nodes + "]"), no_side_files(), limits).ok());
    limits.nodes = 99;
    EXPECT_EQ(import_glb(triangle_builder().glb(one_mesh + ",\"nodes\":[" + nodes + "]"), no_side_files(), limits)
                  .error()
                  .code,
              ErrorCode::limit_exceeded);
}

TEST(ImportGltf, ExpandsGpuInstances) {
    auto b = triangle_builder();
    b.accessor(b.view(floats({0, 0, 0, 5, 0, 0})), gl_float, 2, "VEC3");
    b.accessor(b.view(BinaryWriter().put_all<std::int8_t>({0, 0, 0, 127, 0, 0, 127, 0}).data()), gl_byte, 2, "VEC4",
               ",\"normalized\":true");
    const auto model = import_glb(b.glb("\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"]," + one_mesh +
                                        ",\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{"
                                        "\"attributes\":{\"TRANSLATION\":1,\"ROTATION\":2}}}}]"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->objects, 2u);
    EXPECT_LT(glm::distance(corners(*model)[4], Vec3d(4, 0, 0)), 1e-6);  // half a turn around z
}

TEST(ImportGltf, NamesRequiredExtensionsThatItDoesNotHandle) {
    const auto unknown =
        import_glb(triangle_builder().glb("\"extensionsRequired\":[\"VENDOR_magic\"]," + one_mesh + "," + one_node));
    EXPECT_EQ(unknown.error().code, ErrorCode::unsupported);
    EXPECT_THAT(unknown.error().message, HasSubstr("VENDOR_magic"));
    const auto used =
        import_glb(triangle_builder().glb("\"extensionsUsed\":[\"KHR_materials_unlit\"]," + one_mesh + "," + one_node));
    ASSERT_TRUE(used.ok());
    EXPECT_TRUE(mentions(used.warnings, "KHR_materials_unlit"));
}

TEST(ImportGltf, ReadsMaterialsColorsAndTextures) {
    auto b = triangle_builder();
    b.accessor(b.view(shorts({0, 0, 65535, 0, 0, 65535})), gl_unsigned_short, 3, "VEC2", ",\"normalized\":true");
    b.accessor(b.view(std::string("\xff\0\0\xff\0\xff\0\x80\0\0\xff\0", 12)), gl_unsigned_byte, 3, "VEC4",
               ",\"normalized\":true");
    const std::vector<std::byte> png = tiny_png();
    b.view(std::string(reinterpret_cast<const char*>(png.data()), png.size()));
    const auto model = import_glb(b.glb(
        mesh_of("\"material\":0,\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"COLOR_0\":2}") + "," + one_node +
        ",\"materials\":[{\"name\":\"m\",\"doubleSided\":true,\"alphaMode\":\"MASK\",\"alphaCutoff\":0.25,"
        "\"emissiveFactor\":[0,0.5,0],"
        "\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,0.25,1],\"roughnessFactor\":0.3,\"baseColorTexture\":{"
        "\"index\":0}}}],"
        "\"textures\":[{\"source\":0,\"sampler\":0}],\"samplers\":[{\"wrapS\":33071,\"wrapT\":33648}],\"images\":[{"
        "\"bufferView\":3,\"mimeType\":\"image/png\"}]"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    const mesh::Material& m = model->materials.at(0);
    EXPECT_EQ(m.name, "m");
    EXPECT_TRUE(m.double_sided);
    EXPECT_EQ(m.alpha_mode, mesh::AlphaMode::mask);
    EXPECT_EQ(m.alpha_cutoff, 0.25f);
    EXPECT_EQ(m.base_color, Vec4f(1, 0.5f, 0.25f, 1));
    EXPECT_EQ(m.emissive, Vec3f(0, 0.5f, 0));
    EXPECT_EQ(m.metallic, 1.0f);  // glTF's default
    EXPECT_EQ(m.roughness, 0.3f);
    EXPECT_EQ(m.base_color_texture.wrap_s, mesh::Wrap::clamp_to_edge);
    EXPECT_EQ(m.base_color_texture.wrap_t, mesh::Wrap::mirrored_repeat);
    ASSERT_EQ(model->images.size(), 1u);
    EXPECT_EQ(model->images[0].bytes, png);
    EXPECT_EQ(model->images[0].width, 1u);
    EXPECT_EQ(model->mesh.texture_coordinates[1], Vec2f(1, 0));
    EXPECT_EQ(model->mesh.colors[1], Rgba8(0, 255, 0, 128));
}

std::string transformed(const std::string& base, const std::string& emissive) {
    auto b = triangle_builder();
    b.accessor(b.view(floats({0, 0, 1, 0, 0, 1})), gl_float, 3, "VEC2");
    const std::vector<std::byte> png = tiny_png();
    b.view(std::string(reinterpret_cast<const char*>(png.data()), png.size()));
    const auto slot = [](const std::string& transform) {
        return "{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{" + transform + "}}}";
    };
    return b.glb("\"extensionsRequired\":[\"KHR_texture_transform\"]," +
                 mesh_of("\"material\":0,\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1}") + "," + one_node +
                 ",\"materials\":[{\"emissiveTexture\":" + slot(emissive) +
                 ",\"pbrMetallicRoughness\":{\"baseColorTexture\":" + slot(base) +
                 "}}],\"textures\":[{\"source\":0}],\"images\":[{\"bufferView\":2}]");
}

TEST(ImportGltf, BakesTextureTransforms) {
    const std::string turn = "\"offset\":[0.5,0.25],\"scale\":[2,3],\"rotation\":1.5707963267948966";
    const auto model = import_glb(transformed(turn, turn));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_LT(glm::distance(model->mesh.texture_coordinates[1], Vec2f(0.5f, -1.75f)), 1e-6f);  // u turns towards -v
    EXPECT_LT(glm::distance(model->mesh.texture_coordinates[2], Vec2f(3.5f, 0.25f)), 1e-6f);
    EXPECT_EQ(model->materials[0].emissive_texture.image, 0);
    EXPECT_THAT(model.warnings, ::testing::IsEmpty());
}

TEST(ImportGltf, DropsTexturesWhoseTransformsDisagree) {
    const auto model = import_glb(transformed("\"offset\":[0.5,0]", "\"offset\":[0,0]"));
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->materials[0].base_color_texture.image, 0);
    EXPECT_EQ(model->materials[0].emissive_texture.image, -1);
    EXPECT_TRUE(mentions(model.warnings, "its own coordinates"));
}

TEST(ImportGltf, UnreadableAndMissingImagesOnlyWarn) {
    for (const std::string& image :
         std::vector<std::string>{"{\"uri\":\"none.png\"}", "{\"uri\":\"data:image/png;base64,AAAA\"}",
                                  "{\"bufferView\":0}", "{\"bufferView\":77}", "{}"}) {
        auto b = triangle_builder();
        b.accessor(b.view(floats({0, 0, 1, 0, 0, 1})), gl_float, 3, "VEC2");
        const auto model = import_glb(b.glb(mesh_of("\"material\":0,\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1}") +
                                            "," + one_node +
                                            ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{"
                                            "\"index\":0}}}],\"textures\":[{\"source\":0}],\"images\":[" +
                                            image + "]"));
        ASSERT_TRUE(model.ok()) << image << model.error().message;
        EXPECT_TRUE(model->images.empty());
        EXPECT_TRUE(mentions(model.warnings, "dropped")) << image;
    }
}

TEST(ImportGltf, ReadsDataUrisAndSideFiles) {
    const std::string rest =
        ",\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC3\"}]," +
        one_mesh + "," + one_node + "}";
    const std::string head = "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"";
    const std::string base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    EXPECT_TRUE(
        import_text(head + "data:application/octet-stream;base64," + base64 + "\"}]" + rest, Format::gltf).ok());
    EXPECT_TRUE(import_text(head + "data:;base64," + base64 + "\"}]" + rest, Format::gltf).ok());
    const auto files =
        files_in_memory({{"a b+c.bin", bytes_of(floats({0, 0, 0, 1, 0, 0, 0, 1, 0}) + "longer than stated")}});
    EXPECT_TRUE(import_text(head + "a%20b+c.bin\"}]" + rest, Format::gltf, files).ok());
    EXPECT_EQ(import_text(head + "other.bin\"}]" + rest, Format::gltf, files).error().code, ErrorCode::not_found);
    EXPECT_THAT(import_text(head + "data:;base64,AA!AAA\"}]" + rest, Format::gltf).error().message,
                HasSubstr("states 36 bytes"));
    EXPECT_FALSE(import_text(head + "data:text/plain,AAAA\"}]" + rest, Format::gltf).ok());
}

TEST(ImportGltf, TakesSkinsInTheirRestPose) {
    auto b = triangle_builder();
    b.accessor(b.view(std::string("\1\0\0\0\1\0\0\0\1\0\0\0", 12)), gl_unsigned_byte, 3, "VEC4");
    b.accessor(b.view(floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0})), gl_float, 3, "VEC4");
    b.accessor(b.view(floats(
                   {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1})),
               gl_float, 2, "MAT4");
    const auto model =
        import_glb(b.glb(mesh_of("\"attributes\":{\"POSITION\":0,\"JOINTS_0\":1,\"WEIGHTS_0\":2}") +
                         ",\"nodes\":[{\"mesh\":0,\"skin\":0,\"translation\":[99,0,0]},{},{\"translation\":[4,0,0]}],"
                         "\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":3}]"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(corners(*model)[0], Vec3d(3, 0, 0));  // the joint's place after the inverse bind matrix, not the node's
    EXPECT_TRUE(mentions(model.warnings, "rest pose"));
}

TEST(ImportGltf, TakesMorphTargetsAtTheirDefaultWeights) {
    auto b = triangle_builder();
    b.accessor(b.view(floats({0, 0, 2, 0, 0, 2, 0, 0, 2})), gl_float, 3, "VEC3");
    const auto model =
        import_glb(b.glb("\"meshes\":[{\"weights\":[0.5,0],\"primitives\":[{\"attributes\":{\"POSITION\":0},"
                         "\"targets\":[{\"POSITION\":1},{\"POSITION\":1}]}]}]," +
                         one_node));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(corners(*model)[0], Vec3d(0, 0, 1));
    EXPECT_TRUE(mentions(model.warnings, "morph targets"));
}

TEST(ImportGltf, RefusesCountsThatNoBytesStandFor) {
    GltfBuilder b;
    b.view(floats({0, 0, 0}));
    b.accessor(-1, gl_float, 40'000'000, "VEC3");
    EXPECT_THAT(import_glb(b.glb(one_mesh + "," + one_node)).error().message, HasSubstr("more elements than the file"));
}

TEST(ImportGltf, ManyAppliedMorphTargetsEndAtTheLimit) {
    std::string weights = "1", targets = "{\"POSITION\":0}";
    for (int i = 0; i < 200; ++i) {
        weights += ",1";
        targets += ",{\"POSITION\":0}";
    }
    const auto model = import_glb(triangle_builder().glb(
        "\"meshes\":[{\"weights\":[" + weights + "],\"primitives\":[{\"attributes\":{\"POSITION\":0},\"targets\":[" +
        targets + "]}]}]," + one_node));
    EXPECT_EQ(model.error().code, ErrorCode::limit_exceeded);
}

TEST(ImportGltf, DropsNonFiniteVerticesWithAWarning) {
    GltfBuilder b;
    const float bad = std::numeric_limits<float>::quiet_NaN();
    b.accessor(b.view(floats({0, 0, 0, 1, 0, 0, 0, 1, 0, bad, 0, 0, 1, 0, 0, 0, 1, 0})), gl_float, 6, "VEC3");
    const auto model = import_glb(b.glb(one_mesh + "," + one_node));
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->mesh.triangles.size(), 1u);
    EXPECT_TRUE(mentions(model.warnings, "1 face dropped: coordinates not finite"));
}

TEST(ImportGltf, RefusesBrokenContainers) {
    const std::string good = triangle_builder().glb(one_mesh + "," + one_node);
    EXPECT_TRUE(import_glb(good).ok());
    for (const std::size_t size : {0u, 4u, 11u, 12u, 19u, 20u, 100u})
        EXPECT_FALSE(import_glb(good.substr(0, size)).ok()) << size;
    std::string version_1 = good;
    version_1[4] = 1;
    EXPECT_EQ(import_glb(version_1).error().code, ErrorCode::unsupported);
    std::string long_chunk = good;
    long_chunk[15] = '\x7f';
    EXPECT_FALSE(import_glb(long_chunk).ok());
}

TEST(ImportGltf, SurvivesJsonOfTheWrongTypes) {
    for (const char* text :
         {"{\"asset\":{\"version\":2.0}}", "{\"asset\":[]}", "[]", "{\"asset\":{\"version\":\"2.0\"},\"meshes\":{}}",
          "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[1]}", "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[[]]}",
          "{\"asset\":{\"version\":\"2.0\"},\"buffers\":\"x\"}",
          "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":[]}]}],\"nodes\":[{\"mesh\":0}"
          "]}",
          "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":-5}]}",
          "{\"asset\":{\"version\":\"2.0\"},\"scene\":\"a\",\"scenes\":[[]]}", "{\"asset\":{\"version\":\"1.0\"}}",
          "{\"asset\":{\"version\":\"2.0\"},\"x\":1e999}", "{\"asset\":{\"version\":\"2.0\"},\"x\":\"\xff\"}"})
        EXPECT_FALSE(import_text(text, Format::gltf).ok()) << text;
}

}  // namespace
}  // namespace lodestream::importer
