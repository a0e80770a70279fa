#include "common/mesh/operations.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace lodestream::mesh {
namespace {

using testing::flat_grid;
using testing::single_triangle;
using testing::sphere;
using testing::tetrahedron;

double worst_length_error(const std::vector<Vec3f>& normals) {
    double worst = 0.0;
    for (const Vec3f& n : normals) worst = std::max(worst, std::abs(length(Vec3d(n)) - 1.0));
    return worst;
}

TEST(Weld, TakesNegativeZeroForZero) {
    EXPECT_EQ(weld_positions({{0.0f, 1.0f, 0.0f}, {-0.0f, 1.0f, -0.0f}, {0.0f, 1.0f, 1e-30f}}),
              (std::vector<std::uint32_t>{0, 0, 2}));
}

TEST(Weld, OfNothingIsNothing) {
    EXPECT_TRUE(weld_positions({}).empty());
}

TEST(Compact, JoinsEqualVerticesAndDropsUnusedOnes) {
    Mesh soup;
    soup.positions = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}};
    soup.triangles = {{1, 2, 3}, {4, 5, 6}};
    const Mesh out = compact(soup);
    EXPECT_EQ(out.positions.size(), 4u);
    EXPECT_EQ(out.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
}

TEST(Compact, DropsTrianglesOfFewerThanThreePositions) {
    Mesh mesh = single_triangle();
    mesh.positions.push_back(mesh.positions[0]);
    mesh.triangles.push_back({0, 3, 1});
    mesh.triangles.push_back({1, 1, 2});
    EXPECT_EQ(compact(mesh).triangles.size(), 1u);
}

TEST(Compact, KeepsSeamsAndMaterialBordersApart) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {2, 1, 3}};
    mesh.triangle_materials = {0, 1};
    EXPECT_EQ(compact(mesh).positions.size(), 6u);

    mesh.triangle_materials.clear();
    EXPECT_EQ(compact(mesh).positions.size(), 4u);
    mesh.positions.push_back({1, 0, 0});
    mesh.texture_coordinates = {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {0, 0}};
    mesh.triangles[1] = {2, 4, 3};
    EXPECT_EQ(compact(mesh).positions.size(), 5u);
}

TEST(Compact, KeepsAVertexOnceForEachOfManyMaterials) {
    Mesh mesh = single_triangle();
    mesh.triangles.assign(60, {0, 1, 2});
    for (std::uint32_t m = 0; m < 60; ++m) mesh.triangle_materials.push_back(m);
    EXPECT_EQ(compact(mesh).positions.size(), 180u);
    mesh.triangle_materials[0] = 0xffffffffu;
    EXPECT_EQ(compact(mesh).positions.size(), 180u);
}

TEST(Compact, IsIdempotent) {
    const Mesh once = compact(sphere(12));
    const Mesh twice = compact(once);
    EXPECT_EQ(once.triangles, twice.triangles);
    EXPECT_EQ(once.positions, twice.positions);
}

TEST(Normals, OfASphereAreItsPositions) {
    Mesh mesh = sphere(48);
    mesh.normals.clear();
    const Mesh lit = with_normals(mesh, 60.0);
    ASSERT_EQ(lit.positions.size(), mesh.positions.size());
    for (std::size_t v = 0; v < lit.positions.size(); ++v)
        EXPECT_GT(dot(Vec3d(lit.normals[v]), normalize(Vec3d(lit.positions[v]))), 0.999);
}

TEST(Normals, SplitEdgesSharperThanTheCrease) {
    EXPECT_EQ(with_normals(tetrahedron(), 60.0).positions.size(), 12u);
    EXPECT_EQ(with_normals(tetrahedron(), 180.0).positions.size(), 4u);
}

TEST(PlausibleNormals, KeepsThoseThatASmoothEdgeWouldHave) {
    const Mesh mesh = sphere(24);
    const Mesh same = with_plausible_normals(mesh, 60.0, 40.0);
    EXPECT_EQ(same.positions.size(), mesh.positions.size());
    for (std::size_t v = 0; v < same.positions.size(); ++v)
        EXPECT_GT(dot(Vec3d(same.normals[v]), normalize(Vec3d(same.positions[v]))), 0.999);
}

TEST(PlausibleNormals, MakesTheOthersAnewCornerByCorner) {
    Mesh mesh = flat_grid(2);  // faces +y
    mesh.normals.assign(mesh.positions.size(), Vec3f(0, std::sqrt(0.5f), std::sqrt(0.5f)));
    mesh.normals[4] = {1, 0, 0};
    mesh.normals[8] = {0, -1, 0};
    const Mesh lit = with_plausible_normals(mesh, 60.0, 40.0);
    ASSERT_EQ(lit.positions.size(), mesh.positions.size());
    for (std::size_t v = 0; v < lit.positions.size(); ++v) {
        const bool was_off = lit.positions[v] == mesh.positions[4] || lit.positions[v] == mesh.positions[8];
        EXPECT_EQ(lit.normals[v], was_off ? Vec3f(0, 1, 0) : mesh.normals[0]) << v;
    }
}

TEST(Normals, OfZeroAreaTrianglesComeFromTheNeighbours) {
    Mesh mesh = flat_grid(1);
    mesh.positions.push_back({0.5f, 0.0f, 0.5f});
    mesh.triangles.push_back({1, 4, 2});  // on the diagonal: three positions, no area
    const Mesh lit = with_normals(mesh, 60.0);
    for (const Vec3f& n : lit.normals) EXPECT_EQ(n, Vec3f(0, 1, 0));
}

TEST(Normals, AreUnitVectorsForAnyScale) {
    for (const float scale : {1e-30f, 1e-9f, 1.0f, 1e9f, 1e30f}) {
        Mesh mesh = sphere(8);
        for (Vec3f& p : mesh.positions) p *= scale;
        EXPECT_LT(worst_length_error(with_normals(mesh, 60.0).normals), 1e-6) << scale;
    }
}

TEST(Normals, OfAFanWithTenThousandTrianglesTakeLinearTime) {
    Mesh fan;
    fan.positions.push_back({0, 0, 0});
    constexpr std::uint32_t blades = 10'000;
    for (std::uint32_t i = 0; i <= blades; ++i)
        fan.positions.push_back(
            {static_cast<float>(std::cos(0.0006 * i)), 0.0f, static_cast<float>(-std::sin(0.0006 * i))});
    for (std::uint32_t i = 0; i < blades; ++i) fan.triangles.push_back({0, i + 1, i + 2});
    for (const Vec3f& n : with_normals(fan, 60.0).normals) EXPECT_NEAR(n.y, 1.0, 1e-6);
}

TEST(FaceNormal, OfALineIsZeroAndOfASliverFinite) {
    EXPECT_EQ(face_normal({0, 0, 0}, {1, 1, 1}, {2, 2, 2}), Vec3d(0.0));
    const Vec3d n = face_normal({0, 0, 0}, {1, 0, 0}, {0.5f, 1e-8f, 0});
    EXPECT_NEAR(n.z, 1.0, 1e-9);
}

TEST(Bounds, IgnoreVerticesWithoutATriangle) {
    Mesh mesh = single_triangle();
    mesh.positions.push_back({1e6f, 0, 0});
    EXPECT_DOUBLE_EQ(bounds(mesh).max.x, 1.0);
    EXPECT_TRUE(bounds(Mesh{}).empty());
    EXPECT_DOUBLE_EQ(Box{}.diagonal(), 0.0);
}

TEST(DistinctTriangles, KeepsTheOtherSideAndDropsTurnedCopies) {
    Mesh m = testing::single_triangle();
    m.positions.insert(m.positions.end(), m.positions.begin(), m.positions.end());  // the same places again
    m.triangles = {{0, 1, 2}, {4, 5, 3}, {2, 1, 0}, {3, 5, 4}, {1, 2, 3}};
    EXPECT_EQ(distinct_triangles(m), (std::vector<std::uint32_t>{0, 2}));
}

TEST(Part, HasTheVerticesThatItsTrianglesUse) {
    Mesh m = testing::flat_grid(3);
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t) {
        m.triangle_materials.push_back(t);
        m.triangle_objects.push_back(100 + t);
    }
    const std::vector<std::uint32_t> taken{17, 2};
    const Mesh p = part(m, taken);
    ASSERT_EQ(p.triangles.size(), 2u);
    EXPECT_EQ(p.triangle_materials, taken);
    EXPECT_EQ(p.triangle_objects, (std::vector<std::uint32_t>{117, 102}));
    EXPECT_EQ(p.positions.size(), 6u);
    for (std::size_t i = 0; i < 2; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_EQ(p.positions[p.triangles[i][k]], m.positions[m.triangles[taken[i]][k]]);
}

TEST(Append, ShiftsIndices) {
    Mesh all = testing::single_triangle();
    append(all, testing::tetrahedron());
    EXPECT_EQ(all.positions.size(), 7u);
    EXPECT_EQ(all.triangles.back(), (Triangle{4, 5, 6}));
}

}  // namespace
}  // namespace lodestream::mesh
