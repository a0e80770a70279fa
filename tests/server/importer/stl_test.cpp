#include <gmock/gmock.h>

#include "tests/server/importer/inputs.h"
#include "tests/server/importer/sane.h"

namespace lodestream::importer {
namespace {

using testing::BinaryWriter;
using ::testing::HasSubstr;
using testing::import_text;
using testing::mentions;

Result<mesh::Model> import_stl(std::string_view text) {
    return import_text(text, Format::stl);
}

std::string binary_stl(std::string header, std::uint32_t stated, int held) {
    header.resize(80, ' ');
    BinaryWriter file;
    file.put(stated);
    for (int i = 0; i < held; ++i) {
        const auto z = static_cast<float>(i);
        file.put_all<float>({0, 0, 0, 0, 0, z, 1, 0, z, 0, 1, z}).put<std::uint16_t>(0);
    }
    return header + file.data();
}

const char* const facet =
    "facet normal 9 9 9\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

TEST(ImportStl, BinaryFileMayBeginWithSolid) {
    const auto model = import_stl(binary_stl("solid facet in a binary header", 2, 2));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 2u);
}

TEST(ImportStl, RefusesBinaryThatHoldsLessThanItStates) {
    EXPECT_THAT(import_stl(binary_stl("x", 66, 4)).error().message, HasSubstr("states 66 facets but holds 4"));
    EXPECT_THAT(import_stl(binary_stl("x", 0xffffffff, 1)).error().message, HasSubstr("but holds 1"));
    EXPECT_THAT(import_stl("abc").error().message, HasSubstr("too short"));
}

TEST(ImportStl, IgnoresBytesAfterTheLastFacet) {
    const auto model = import_stl(binary_stl("x", 1, 2) + "tail");
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->mesh.triangles.size(), 1u);
    EXPECT_TRUE(mentions(model.warnings, "after the last facet"));
}

TEST(ImportStl, ReadsSolidsWhoseNamesHoldKeywords) {
    const auto model = import_stl(std::string("solid vertex 1 2 3 facet\n") + facet + "endsolid vertex\nSOLID b\n" +
                                  facet + "endsolid\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 2u);
    EXPECT_EQ(model->objects, 2u);
    EXPECT_EQ(model->kind, mesh::Kind::scene);
}

TEST(ImportStl, ReadsCarriageReturnsCapitalsAndNoEnd) {
    const auto model =
        import_stl("Solid a\rFACET NORMAL 0 0 1\rOUTER LOOP\rVERTEX +0 0 0\rVERTEX 1e0 0 0\rVERTEX 0 1 0\rENDLOOP");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 1u);
}

TEST(ImportStl, IgnoresFacetNormalsAndWeldsCorners) {
    const auto model =
        import_stl(std::string("solid\n") + facet +
                   "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.positions.size(), 4u);
    EXPECT_EQ(model->mesh.normals[0], Vec3f(0, 0, 1));
}

TEST(ImportStl, DropsShortAndUnreadableFacets) {
    const auto model = import_stl(std::string("solid\n") + facet +
                                  "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\n" +
                                  "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 x\nvertex 1 2 3\nendloop\nendfacet\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 1u);
    EXPECT_TRUE(mentions(model.warnings, "1 face dropped: fewer than three readable corners"));
    EXPECT_TRUE(mentions(model.warnings, "1 face dropped: coordinates not finite"));
}

TEST(ImportStl, EmptySolidHasNoGeometry) {
    EXPECT_THAT(import_stl("solid a\nendsolid a\n").error().message, HasSubstr("no geometry"));
    EXPECT_THAT(import_stl(binary_stl("x", 0, 0)).error().message, HasSubstr("no geometry"));
}

}  // namespace
}  // namespace lodestream::importer
