#include <gtest/gtest.h>

#include "server/samples/samples.h"
#include "tests/server/samples/mesh_checks.h"

namespace lodestream::samples {
namespace {

using namespace lodestream::testing;

TEST(Terrain, HasExactlyTheVerticesAskedForAndUsesThemAll) {
    for (const std::uint64_t n : {3, 4, 5, 6, 7, 8, 9, 10, 12, 13, 99, 100, 101, 110, 111, 40'000, 40'001}) {
        SCOPED_TRACE(n);
        const auto model = terrain(n);
        ASSERT_TRUE(model.ok());
        EXPECT_EQ(model->mesh.positions.size(), n);
        EXPECT_EQ(model->mesh.colors.size(), n);
        EXPECT_EQ(model->kind, mesh::Kind::terrain);
        expect_sound(*model);
    }
}

TEST(Terrain, IsOneSheetWithOneBorderEvenWhereTheLastRowIsShort) {
    for (const std::uint64_t n : {3, 4, 5, 7, 8, 13, 101, 111, 10'000, 9'950}) {
        const auto edges = directed_edges(terrain(n)->mesh);
        EXPECT_TRUE(each_edge_once(edges)) << n;
        EXPECT_EQ(components(edges), 1u) << n;
        std::map<std::uint32_t, int> leaving;
        std::map<Edge, int> rim;
        for (const Edge& edge : border(edges)) {
            ++leaving[edge.first];
            rim[edge] = 1;
        }
        EXPECT_EQ(components(rim), 1u) << n;
        for (const auto& [vertex, count] : leaving) EXPECT_EQ(count, 1) << n;
    }
}

TEST(Terrain, LiesOnATenMetreGridAndFacesUp) {
    const auto model = terrain(1'000);
    const mesh::Mesh& m = model->mesh;
    EXPECT_EQ(m.positions[1].x - m.positions[0].x, 10.0f);
    EXPECT_EQ(m.positions[32].z - m.positions[0].z, 10.0f);
    for (const auto& [a, b, c] : m.triangles)
        ASSERT_GT(mesh::face_normal(m.positions[a], m.positions[b], m.positions[c]).y, 0);
}

TEST(Terrain, StaysBetweenSeaAndPeakForManySeeds) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Box box = mesh::bounds(terrain(10'000, seed)->mesh);
        EXPECT_GE(box.min.y, 0);
        EXPECT_LE(box.max.y, 1'500);
        EXPECT_GT(box.extent().y, 1) << "flat";
    }
}

TEST(Terrain, HasFeaturesInMetresWhateverTheCount) {
    const auto small = terrain(101 * 101), large = terrain(301 * 301);
    EXPECT_EQ(small->mesh.positions[101 * 50 + 50], large->mesh.positions[301 * 150 + 150]);
    EXPECT_EQ(small->mesh.positions[0], large->mesh.positions[301 * 100 + 100]);
}

TEST(Terrain, NormalsFollowTheSlope) {
    EXPECT_GT(worst_normal(terrain(10'000)->mesh), 0.7);
}

TEST(Terrain, IsTheSameForASeedAndDifferentForAnother) {
    EXPECT_EQ(terrain(500, 7)->mesh.positions, terrain(500, 7)->mesh.positions);
    EXPECT_NE(terrain(500, 7)->mesh.positions, terrain(500, 8)->mesh.positions);
}

TEST(Terrain, RefusesTooFewAndTooMany) {
    EXPECT_EQ(terrain(2).error().code, ErrorCode::invalid_input);
    EXPECT_EQ(terrain(max_terrain_vertices + 1).error().code, ErrorCode::limit_exceeded);
}

}  // namespace
}  // namespace lodestream::samples
