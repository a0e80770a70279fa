#include "tests/bench/subdivide.h"

#include <gtest/gtest.h>

#include "common/mesh/operations.h"
#include "tests/bench/connectivity.h"

namespace lodestream::bench {
namespace {

mesh::Mesh octahedron() {
    mesh::Mesh mesh;
    mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    return mesh;
}

mesh::Mesh square() {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

TEST(LoopSubdivide, MakesFourOfOneAndStaysClosed) {
    const mesh::Mesh fine = loop_subdivide(octahedron());
    EXPECT_EQ(fine.triangles.size(), 32u);
    EXPECT_EQ(fine.positions.size(), 18u);
    EXPECT_TRUE(open_edges(fine).empty());
}

TEST(LoopSubdivide, PullsAnOctahedronsCornersIn) {
    // Valence 4, Warren's 3/(8 n): 1 - 4 * 3/32 of the corner, and the four neighbours cancel out.
    EXPECT_FLOAT_EQ(loop_subdivide(octahedron()).positions[0].x, 0.625f);
}

TEST(LoopSubdivide, KeepsAFlatSquareFlatAndItsSidesStraight) {
    const mesh::Mesh fine = loop_subdivide(square());
    for (const Vec3f& p : fine.positions) EXPECT_EQ(p.z, 0.0f);
    for (const auto& [a, b] : open_edges(fine)) {
        const Vec3f middle = (fine.positions[a] + fine.positions[b]) * 0.5f;
        EXPECT_LE(std::min({middle.x, middle.y, 1 - middle.x, 1 - middle.y}), 0.125f);
    }
}

TEST(Detailed, IsAFunctionOfItsSeed) {
    const mesh::Mesh a = detailed(octahedron(), 2, 0.05, 1), again = detailed(octahedron(), 2, 0.05, 1);
    const mesh::Mesh other = detailed(octahedron(), 2, 0.05, 2);
    EXPECT_EQ(a.positions, again.positions);
    EXPECT_NE(a.positions, other.positions);
}

TEST(Detailed, MovesNothingWithoutRoughness) {
    const mesh::Mesh smooth = loop_subdivide(octahedron());
    EXPECT_DOUBLE_EQ(mesh::bounds(detailed(octahedron(), 1, 0.0, 1)).diagonal(), mesh::bounds(smooth).diagonal());
}

TEST(Detailed, KeepsTheSurfaceClosed) {
    const mesh::Mesh rough = detailed(octahedron(), 3, 0.05, 1);
    EXPECT_EQ(rough.triangles.size(), 8u * 64u);
    EXPECT_TRUE(open_edges(rough).empty());
}

}  // namespace
}  // namespace lodestream::bench
