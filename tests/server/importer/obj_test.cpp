#include <gmock/gmock.h>

#include "tests/server/importer/inputs.h"
#include "tests/server/importer/sane.h"

namespace lodestream::importer {
namespace {

using testing::bytes_of;
using testing::expect_sane;
using testing::files_in_memory;
using testing::import_text;
using testing::mentions;

Result<mesh::Model> import_obj(std::string_view text, const SideFiles& files = no_side_files()) {
    return import_text(text, Format::obj, files);
}

TEST(ImportObj, ReadsNegativeIndicesAndMixedCorners) {
    const auto model =
        import_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf -3 -2 -1\nf 1/1 2/1 3/1\nf 1//1 3//-1 2//1\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 3u);
    expect_sane(*model, "obj");
}

TEST(ImportObj, ReadsLineEndsOfEverySystem) {
    for (const char* text : {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
                             "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\n 2 3\n"}) {
        const auto model = import_obj(text);
        ASSERT_TRUE(model.ok()) << model.error().message;
        EXPECT_EQ(model->mesh.triangles.size(), 1u);
    }
}

TEST(ImportObj, KeepsPolygonsOfMoreThan255Corners) {
    std::string text, face = "f";
    for (int i = 0; i < 1000; ++i) {
        const double angle = 2 * pi * i / 1000;
        text += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0\n";
        face.append(" ").append(std::to_string(i + 1));
    }
    const auto model = import_obj(text + face + "\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 998u);
}

TEST(ImportObj, DropsOutOfRangeAndUnreadableFacesAndCountsThem) {
    const auto model = import_obj(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 9\nf 0 1 2\nf 1 2 -4\nf 1 2\nf a b c\n"
        "f 1 2 99999999999999999999\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 1u);
    EXPECT_TRUE(mentions(model.warnings, "3 faces dropped: vertex index out of range"));
    EXPECT_TRUE(mentions(model.warnings, "3 faces dropped: fewer than three readable corners"));
}

TEST(ImportObj, DropsNonFiniteAndDegenerateFacesAndCountsThem) {
    const auto model = import_obj(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv inf 0 0\nv 1e300 0 0\nv x 0 0\nv 1 0 0\n"
        "f 1 2 3\nf 1 2 4\nf 1 2 5\nf 1 2 6\nf 1 2 7\nf 1 2 8\nf 1 1 2\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 1u);
    EXPECT_TRUE(mentions(model.warnings, "4 faces dropped: coordinates not finite"));
    EXPECT_TRUE(mentions(model.warnings, "2 faces dropped: fewer than three different positions"));
}

TEST(ImportObj, CountsObjectsThatHaveFaces) {
    const auto model = import_obj("o empty\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no b\nf 1 3 2\n");
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->objects, 2u);
    EXPECT_EQ(model->kind, mesh::Kind::scene);
}

TEST(ImportObj, ReadsVertexColorsAsSrgb) {
    const auto model = import_obj("v 0 0 0 1 0 0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 0 0 1\nf 1 2 3\n");
    ASSERT_TRUE(model.ok());
    ASSERT_EQ(model->mesh.colors.size(), 3u);
    EXPECT_EQ(model->mesh.colors[0], Rgba8(255, 0, 0, 255));
    EXPECT_EQ(model->mesh.colors[1], Rgba8(55, 55, 55, 255));  // 0.5 sRGB is 0.214 linear
}

TEST(ImportObj, TurnsTextureCoordinatesToTheUpperLeft) {
    const auto model = import_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.25\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->mesh.texture_coordinates[0], Vec2f(0.25f, 0.75f));
}

TEST(ImportObj, ReadsItsMaterialLibrary) {
    const auto files = files_in_memory(
        {{"a b.mtl",
          bytes_of("newmtl red one\r\nKd 1 0 0\r\nd 0.5\r\nKe 0 1 0\r\nNs 98\r\nmap_Kd dir\\my tex.png\r\n")},
         {"dir/my tex.png", testing::tiny_png()}});
    const auto model =
        import_obj("mtllib a b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl red one\nf 1/1 2/1 3/1\n", files);
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_THAT(model.warnings, ::testing::IsEmpty());
    ASSERT_EQ(model->materials.size(), 1u);
    const mesh::Material& m = model->materials[0];
    EXPECT_EQ(m.name, "red one");
    EXPECT_EQ(m.base_color, Vec4f(1, 0, 0, 0.5f));
    EXPECT_EQ(m.alpha_mode, mesh::AlphaMode::blend);
    EXPECT_EQ(m.emissive, Vec3f(0, 1, 0));
    EXPECT_NEAR(m.roughness, std::sqrt(2.0f / 100.0f), 1e-6f);
    ASSERT_EQ(m.base_color_texture.image, 0);
    EXPECT_EQ(model->images[0].media_type, "image/png");
    EXPECT_EQ(model->images[0].bytes, testing::tiny_png());
}

TEST(ImportObj, MissingLibraryAndUnreadableImageOnlyWarn) {
    const char* text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
    const auto without = import_obj(text);
    ASSERT_TRUE(without.ok()) << without.error().message;
    EXPECT_TRUE(mentions(without.warnings, "m.mtl"));
    const auto broken = import_obj(
        text, files_in_memory({{"m.mtl", bytes_of("newmtl a\nmap_Kd x.tga\n")}, {"x.tga", bytes_of("no image")}}));
    ASSERT_TRUE(broken.ok()) << broken.error().message;
    EXPECT_TRUE(mentions(broken.warnings, "x.tga"));
    EXPECT_EQ(broken->materials[0].base_color_texture.image, -1);
}

TEST(ImportObj, KeepsOnlyMaterialsThatTrianglesUse) {
    const auto files = files_in_memory({{"m.mtl", bytes_of("newmtl a\nnewmtl b\nKd 0 0 1\nnewmtl c\n")}});
    const auto model =
        import_obj("mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 4\n", files);
    ASSERT_TRUE(model.ok());
    ASSERT_EQ(model->materials.size(), 2u);
    EXPECT_EQ(model->materials[0].name, "b");
    EXPECT_EQ(model->mesh.triangle_materials, (std::vector<std::uint32_t>{0, 1}));
}

TEST(ImportObj, OneTriangleInManyMaterialsEnds) {
    std::string library, text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (int i = 0; i < 300; ++i) {
        library += "newmtl m" + std::to_string(i) + "\n";
        text += "usemtl m" + std::to_string(i) + "\nf 1 2 3\n";
    }
    const auto model = import_obj(text, files_in_memory({{"m.mtl", bytes_of(library)}}));
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->mesh.triangles.size(), 300u);
    EXPECT_EQ(model->materials.size(), 300u);
}

TEST(ImportObj, SaysWhatIsMissing) {
    EXPECT_THAT(import_obj("v 0 0 0\nv 1 0 0\n").error().message, ::testing::HasSubstr("2 points but no triangles"));
    EXPECT_THAT(import_obj("# nothing\n").error().message, ::testing::HasSubstr("no geometry"));
    EXPECT_THAT(import_obj("v 0 0 0\nf 1 1 1\n").error().message, ::testing::HasSubstr("1 face but none"));
}

TEST(ImportObj, MakesNormalsOnlyWhereTheyAreMissing) {
    // The first triangle brings a (false) normal along x, the second none.
    const auto model =
        import_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nvn 2 0 0\nf 1//1 2//1 3//1\nf 4 5 6\n");
    ASSERT_TRUE(model.ok());
    expect_sane(*model, "obj");
    for (std::size_t i = 0; i < model->mesh.positions.size(); ++i)
        EXPECT_EQ(model->mesh.normals[i], model->mesh.positions[i].x < 4 ? Vec3f(1, 0, 0) : Vec3f(0, 0, 1));
}

TEST(ImportObj, KeepsMillimetresTenMillionMetresAway) {
    const auto model = import_obj(
        "v 10000000.001 500000 -0.5\nv 10000000.002 500000 -0.5\nv 10000000.001 500000.003 -0.5\n"
        "v 10000100 500100 0\nf 1 2 3\nf 1 2 4\n");
    ASSERT_TRUE(model.ok());
    const mesh::Mesh& m = model->mesh;
    const mesh::Triangle t = m.triangles[0];
    const auto world = [&](std::uint32_t v) { return Vec3d(m.positions[v]) + model->origin; };
    EXPECT_NEAR(world(t[0]).x, 10000000.001, 1e-5);
    EXPECT_NEAR(world(t[1]).x - world(t[0]).x, 0.001, 1e-5);
    EXPECT_NEAR(world(t[2]).y - world(t[0]).y, 0.003, 1e-5);
    EXPECT_EQ(model->origin, Vec3d(10000100, 500100, 0));  // a short decimal near the middle
}

TEST(ImportObj, OrdinaryModelsKeepTheWorldsOrigin) {
    const auto model = import_obj("v 1 1 1\nv 2 1 1\nv 1 2 1\nf 1 2 3\n");
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->origin, Vec3d(0.0));
    EXPECT_EQ(model->mesh.positions[0], Vec3f(1, 1, 1));
}

}  // namespace
}  // namespace lodestream::importer
