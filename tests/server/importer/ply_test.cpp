#include <gmock/gmock.h>

#include <algorithm>

#include "tests/server/importer/inputs.h"
#include "tests/server/importer/sane.h"

namespace lodestream::importer {
namespace {

using testing::BinaryWriter;
using testing::files_in_memory;
using ::testing::HasSubstr;
using testing::import_text;
using testing::mentions;

Result<mesh::Model> import_ply(std::string_view text, const SideFiles& files = no_side_files()) {
    return import_text(text, Format::ply, files);
}

const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
const std::string faces = "property list uchar int vertex_indices\n";

TEST(ImportPly, ReadsAsciiWithExtraPropertiesAndElements) {
    const auto model = import_ply(
        "ply\nformat ascii 1.0\ncomment x\nobj_info y\nelement camera 1\nproperty list int float path\n"
        "property float f\nelement vertex 4\n" +
        xyz + "property double confidence\nelement face 1\n" + "property uchar flags\n" + faces +
        "end_header\n3 1 2 3 0.5\n0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n7 4 0 1 2 3\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 2u);
}

std::string binary_triangle(bool big) {
    BinaryWriter out;
    const auto put = [&](auto value) {
        std::byte raw[sizeof value];
        std::memcpy(raw, &value, sizeof value);
        if (big) std::reverse(std::begin(raw), std::end(raw));
        for (const std::byte b : raw) out.put(b);
    };
    for (const double v : {0., 0., 0., 1., 0., 0., 0., 1., 0.}) put(v);
    put(std::uint16_t{3});
    for (const std::uint32_t i : {0u, 1u, 2u}) put(i);
    return out.data();
}

TEST(ImportPly, ReadsBinaryOfBothByteOrdersAfterAnyLineEnd) {
    for (const bool big : {false, true})
        for (const std::string end : {"\n", "\r\n", "\r"}) {
            std::string header =
                std::string("ply\nformat binary_") + (big ? "big" : "little") +
                "_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
                "element face 1\nproperty list ushort uint vertex_index\nend_header\n";
            for (std::size_t at = 0; (at = header.find('\n', at)) != std::string::npos; at += end.size())
                header.replace(at, 1, end);
            const auto model = import_ply(header + binary_triangle(big));
            ASSERT_TRUE(model.ok()) << model.error().message;
            EXPECT_EQ(model->mesh.positions[1], Vec3f(1, 0, 0));
        }
}

TEST(ImportPly, RefusesPlyThatDeclaresMoreThanItHas) {
    const std::string head = "ply\nformat ascii 1.0\nelement vertex ";
    EXPECT_THAT(import_ply(head + "2000000000\n" + xyz + "end_header\n0 0 0\n").error().message,
                HasSubstr("more than its size allows"));
    EXPECT_THAT(import_ply(head + "2\n" + xyz + "end_header\n0 0 0\n1 2\n").error().message,
                HasSubstr("vertex but holds 1"));
    EXPECT_THAT(import_ply("ply\nformat binary_little_endian 1.0\nelement vertex 1000000\n" + xyz + "end_header\nabc")
                    .error()
                    .message,
                HasSubstr("more than its size allows"));
    EXPECT_FALSE(
        import_ply(head + "3\n" + xyz + "element face 1\n" + faces + "end_header\n0 0 0\n1 0 0\n0 1 0\n4000000 0 1 2\n")
            .ok());
}

TEST(ImportPly, RefusesBrokenHeaders) {
    for (const char* text : {"ply\n", "plyx\nend_header\n", "ply\nformat ascii 1.0\nproperty float x\nend_header\n",
                             "ply\nformat weird 1.0\nend_header\n", "ply\nelement vertex -1\nend_header\n",
                             "ply\nelement vertex 1\nproperty quad x\nend_header\n",
                             "ply\nelement vertex 1\nproperty list float\nend_header\n"})
        EXPECT_FALSE(import_ply(text).ok()) << text;
}

TEST(ImportPly, CountOfAnElementWithoutPropertiesIsNoLoop) {
    const auto model = import_ply("ply\nformat ascii 1.0\nelement nothing 999999999999999\nelement vertex 3\n" + xyz +
                                  "element face 1\n" + faces + "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    EXPECT_TRUE(model.ok());
}

TEST(ImportPly, ReadsNormalsColorsAndCoordinates) {
    const auto model =
        import_ply("ply\nformat ascii 1.0\nelement vertex 3\n" + xyz +
                   "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n"
                   "property uchar blue\nproperty uchar alpha\nproperty float s\nproperty float t\nelement face 1\n" +
                   faces +
                   "end_header\n0 0 0 1 0 0 255 0 0 64 0.5 0.25\n1 0 0 1 0 0 0 128 0 255 0 0\n0 1 0 1 0 0 0 0 255 0 0 "
                   "1\n3 0 1 2\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.normals[0], Vec3f(1, 0, 0));
    EXPECT_EQ(model->mesh.colors[0], Rgba8(255, 0, 0, 64));
    EXPECT_EQ(model->mesh.colors[1], Rgba8(0, 55, 0, 255));
    EXPECT_EQ(model->mesh.texture_coordinates[0], Vec2f(0.5f, 0.75f));
}

TEST(ImportPly, FloatColorsWithoutAlphaAreOpaque) {
    const auto model = import_ply("ply\nformat ascii 1.0\nelement vertex 3\n" + xyz +
                                  "property float red\nproperty float green\nproperty float blue\nelement face 1\n" +
                                  faces + "end_header\n0 0 0 1 0 0\n1 0 0 1 1 1\n0 1 0 0 0 7\n3 0 1 2\n");
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->mesh.colors[0], Rgba8(255, 0, 0, 255));
    EXPECT_EQ(model->mesh.colors[2], Rgba8(0, 0, 255, 255));
}

TEST(ImportPly, FaceColorsAndFaceCoordinatesSplitVertices) {
    const auto model = import_ply(
        "ply\nformat ascii 1.0\nelement vertex 4\n" + xyz + "element face 2\n" + faces +
        "property list uchar float texcoord\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 6 0 0 1 0 0 1 255 0 0\n3 1 3 2 6 0 0 0 0 0 0 0 0 255\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.positions.size(), 6u);
    EXPECT_EQ(model->mesh.colors[model->mesh.triangles[1][0]], Rgba8(0, 0, 255, 255));
    EXPECT_EQ(model->mesh.texture_coordinates[model->mesh.triangles[0][1]], Vec2f(1, 1));
}

TEST(ImportPly, ReadsTriangleStripsWithRestarts) {
    const auto model = import_ply("ply\nformat ascii 1.0\nelement vertex 4\n" + xyz + "element tristrips 1\n" + faces +
                                  "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 3 1 0\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    ASSERT_EQ(model->mesh.triangles.size(), 3u);
    EXPECT_EQ(model->mesh.normals[model->mesh.triangles[1][0]], Vec3f(0, 0, 1));
}

TEST(ImportPly, UsesItsTextureFile) {
    const std::string text = "ply\nformat ascii 1.0\ncomment TextureFile my tex.png\nelement vertex 3\n" + xyz +
                             "property float u\nproperty float v\nelement face 1\n" + faces +
                             "end_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";
    const auto model = import_ply(text, files_in_memory({{"my tex.png", testing::tiny_png()}}));
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->materials[0].base_color_texture.image, 0);
    const auto without = import_ply(text);
    ASSERT_TRUE(without.ok());
    EXPECT_TRUE(mentions(without.warnings, "my tex.png"));
}

TEST(ImportPly, DropsFacesOutOfRange) {
    const auto model = import_ply("ply\nformat ascii 1.0\nelement vertex 3\n" + xyz + "element face 4\n" + faces +
                                  "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 3\n3 0 -1 2\n2 0 1\n");
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->mesh.triangles.size(), 1u);
    EXPECT_TRUE(mentions(model.warnings, "2 faces dropped: vertex index out of range"));
}

TEST(ImportPly, AFileWithoutFacesIsACloud) {
    const auto model = import_ply(
        "ply\nformat ascii 1.0\nelement vertex 3\n" + xyz +
        "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar "
        "green\nproperty uchar blue\nend_header\n0 0 0 0 0 2 255 0 0\nnan 0 0 0 0 1 0 255 0\n1 0 0 0 1 0 0 0 255\n");
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(model->kind, mesh::Kind::points);
    EXPECT_TRUE(model->mesh.triangles.empty());
    ASSERT_EQ(model->mesh.positions.size(), 2u);
    EXPECT_EQ(model->mesh.positions[1], Vec3f(1, 0, 0));
    EXPECT_EQ(model->mesh.normals[0], Vec3f(0, 0, 1));
    EXPECT_EQ(model->mesh.colors[1], Rgba8(0, 0, 255, 255));
    EXPECT_TRUE(mentions(model.warnings, "1 point dropped: coordinates not finite"));
}

TEST(ImportPly, ACloudWhereSomeNormalsAreMissingHasNone) {
    const auto model = import_ply("ply\nformat ascii 1.0\nelement vertex 2\n" + xyz +
                                  "property float nx\nproperty float ny\nproperty float nz\nend_header\n"
                                  "0 0 0 0 0 1\n1 0 0 0 0 0\n");
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_TRUE(model->mesh.normals.empty());
    EXPECT_TRUE(mentions(model.warnings, "normals left out: some points have none"));
}

TEST(ImportPly, ACloudFarAwayKeepsItsMillimetres) {
    const auto model = import_ply(
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
        "property double z\nend_header\n4500000.001 5300000 300\n4500001.002 5300000 300\n");
    ASSERT_TRUE(model) << model.error().message;
    const Vec3d apart = Vec3d(model->mesh.positions[1]) - Vec3d(model->mesh.positions[0]);
    EXPECT_NEAR(apart.x, 1.001, 1e-6);
}

TEST(ImportPly, AFileWhoseFacesAreAllWrongIsNoCloud) {
    EXPECT_FALSE(import_ply("ply\nformat ascii 1.0\nelement vertex 2\n" + xyz + "element face 1\n" + faces +
                            "end_header\n0 0 0\n1 0 0\n3 0 1 7\n"));
    EXPECT_FALSE(import_ply("ply\nformat ascii 1.0\nelement vertex 0\n" + xyz + "end_header\n"));
    EXPECT_FALSE(import_ply("ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\nnan 0 0\n"));
}

}  // namespace
}  // namespace lodestream::importer
