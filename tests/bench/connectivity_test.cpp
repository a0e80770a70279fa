#include "tests/bench/connectivity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lodestream::bench {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

mesh::Mesh mesh_of(std::vector<Vec3f> positions, std::vector<mesh::Triangle> triangles) {
    mesh::Mesh mesh;
    mesh.positions = std::move(positions);
    mesh.triangles = std::move(triangles);
    return mesh;
}

const std::vector<mesh::Triangle> tetrahedron{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

TEST(OppositeCorners, ShareTheEdgeInTheOtherDirection) {
    const std::vector<std::uint32_t> opposite = opposite_corners(tetrahedron);
    for (std::uint32_t c = 0; c < opposite.size(); ++c) {
        ASSERT_NE(opposite[c], none);
        EXPECT_EQ(opposite[opposite[c]], c);
        EXPECT_EQ(vertex_of(tetrahedron, c), vertex_of(tetrahedron, next_corner(opposite[c])));
    }
}

TEST(OppositeCorners, AreNoneOnABoundary) {
    EXPECT_THAT(opposite_corners({{0, 1, 2}}), ElementsAre(none, none, none));
}

TEST(OpenEdges, OfAClosedSurfaceAreNone) {
    EXPECT_THAT(open_edges(mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, tetrahedron)), IsEmpty());
}

TEST(OpenEdges, ASeamOfEqualPositionsIsClosedAndATornOneIsOpen) {
    const std::vector<mesh::Triangle> quad{{0, 1, 2}, {3, 4, 5}};
    const std::vector<Vec3f> joined{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    EXPECT_EQ(open_edges(mesh_of(joined, quad)).size(), 4u);
    std::vector<Vec3f> torn = joined;
    torn[3].x = 1.001f;
    EXPECT_EQ(open_edges(mesh_of(torn, quad)).size(), 6u);
}

TEST(MakeManifold, LeavesAManifoldAlone) {
    Repairs repairs;
    const mesh::Mesh closed =
        make_manifold(mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, tetrahedron), repairs);
    EXPECT_EQ(closed.triangles.size(), 4u);
    EXPECT_EQ(closed.positions.size(), 4u);
    EXPECT_EQ(repairs.dropped_triangles, 0u);
    EXPECT_EQ(repairs.split_vertices, 0u);
}

TEST(MakeManifold, DropsTheThirdTriangleOfAnEdge) {
    Repairs repairs;
    const mesh::Mesh fins =
        mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
    EXPECT_EQ(make_manifold(fins, repairs).triangles.size(), 2u);
    EXPECT_EQ(repairs.dropped_triangles, 1u);
}

TEST(MakeManifold, SplitsAVertexBetweenTwoFans) {
    Repairs repairs;
    const mesh::Mesh bow_tie =
        mesh_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 4}});
    const mesh::Mesh split = make_manifold(bow_tie, repairs);
    EXPECT_EQ(repairs.split_vertices, 1u);
    EXPECT_EQ(split.positions.size(), 6u);
    EXPECT_NE(split.triangles[0][0], split.triangles[1][0]);
    EXPECT_EQ(split.positions[split.triangles[0][0]], split.positions[split.triangles[1][0]]);
}

}  // namespace
}  // namespace lodestream::bench
