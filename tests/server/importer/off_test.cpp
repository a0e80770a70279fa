#include <gmock/gmock.h>

#include "tests/server/importer/inputs.h"
#include "tests/server/importer/sane.h"

namespace lodestream::importer {
namespace {

using ::testing::HasSubstr;
using testing::import_text;
using testing::mentions;

Result<mesh::Model> import_off(std::string_view text) {
    return import_text(text, Format::off);
}

TEST(ImportOff, ReadsCommentsPolygonsAndCountsOnTheFirstLine) {
    const auto model = import_off("OFF 4 1 0 # counts\n# a comment\n0 0 0\n\n1 0 0 # x\n1 1 0\n0 1 0\n4 0 1 2 3\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 2u);
}

TEST(ImportOff, ReadsAFileWithoutTheWord) {
    const auto model = import_off("3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
}

TEST(ImportOff, ReadsVertexColorsAndNormals) {
    const auto model =
        import_off("CNOFF\n3 1 0\n0 0 0 1 0 0 255 0 0 255\n1 0 0 1 0 0 0 255 0 128\n0 1 0 1 0 0 0 0 255\n3 0 1 2\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.normals[0], Vec3f(1, 0, 0));
    EXPECT_EQ(model->mesh.colors[0], Rgba8(255, 0, 0, 255));
    EXPECT_EQ(model->mesh.colors[1], Rgba8(0, 255, 0, 128));
    EXPECT_EQ(model->mesh.colors[2], Rgba8(0, 0, 255, 255));
}

TEST(ImportOff, FaceColorsSplitVertices) {
    const auto model = import_off("OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 1.0 0.0 0.0\n3 1 3 2 0 0 255\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    ASSERT_EQ(model->mesh.positions.size(), 6u);
    EXPECT_EQ(model->mesh.colors[model->mesh.triangles[0][0]], Rgba8(255, 0, 0, 255));
    EXPECT_EQ(model->mesh.colors[model->mesh.triangles[1][0]], Rgba8(0, 0, 255, 255));
}

TEST(ImportOff, RefusesCountsThatItsSizeCannotHold) {
    EXPECT_THAT(import_off("OFF\n3 99999999999 0\n0 0 0\n").error().message, HasSubstr("faces than its size allows"));
    EXPECT_THAT(import_off("OFF\n1e30 1 0\n").error().message, HasSubstr("vertices than its size allows"));
    EXPECT_THAT(import_off("OFF\n-3 1 0\n").error().message, HasSubstr("no count of vertices"));
    EXPECT_THAT(import_off("OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n").error().message, HasSubstr("4 vertices but holds 3"));
    EXPECT_THAT(import_off("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").error().message,
                HasSubstr("2 faces but holds 1"));
}

TEST(ImportOff, DropsFacesOutOfRangeAndShortLines) {
    const auto model = import_off("OFF\n3 4 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 3\n4294967297 0 1 2\n3 0 -1 2\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 1u);
    EXPECT_TRUE(mentions(model.warnings, "2 faces dropped: vertex index out of range"));
    EXPECT_TRUE(mentions(model.warnings, "1 face dropped: fewer than three readable corners"));
}

TEST(ImportOff, RefusesOtherDimensionsAndBinary) {
    EXPECT_EQ(import_off("4OFF\n3 1 0\n").error().code, ErrorCode::unsupported);
    EXPECT_EQ(import_off("OFF BINARY\n").error().code, ErrorCode::unsupported);
}

}  // namespace
}  // namespace lodestream::importer
