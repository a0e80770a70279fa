#include "common/shading/normal_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/meshes.h"

namespace lodestream::shading {
namespace {

mesh::Mesh triangle(const Vec3f& normal_a, const Vec3f& normal_b, const Vec3f& normal_c) {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}};
    mesh.triangles = {{0, 1, 2}};
    mesh.normals = {normal_a, normal_b, normal_c};
    return mesh;
}

const Vec3f up{0, 1, 0};

TEST(NormalErrors, OfALevelAgainstItselfGouraudIsNothing) {
    const mesh::Mesh mesh = testing::sphere(16);
    const NormalErrors errors = normal_errors(mesh, ReferenceSurface(mesh));
    ASSERT_EQ(errors.flat.size(), mesh.triangles.size());
    ASSERT_EQ(errors.gouraud.size(), mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        EXPECT_GT(errors.flat[t], 0.0);
        EXPECT_NEAR(errors.gouraud[t], 0.0, 1e-9);
    }
}

// Four places, all turned by as much: |a - b|² is 2 - 2cos.
TEST(NormalErrors, AreTheSquaredDifferenceOfUnitNormals) {
    const Vec3f tilted(std::sin(0.3f), std::cos(0.3f), 0);
    const NormalErrors errors =
        normal_errors(triangle(up * 5.0f, up, up * 0.1f), ReferenceSurface(triangle(tilted, tilted, tilted)));
    EXPECT_NEAR(errors.flat[0], 2.0 - 2.0 * std::cos(0.3), 1e-6);
    EXPECT_NEAR(errors.gouraud[0], errors.flat[0], 1e-6);
}

TEST(NormalErrors, AFlatReferenceIsNearerToTheFaceThanToBentNormals) {
    const Vec3f left(-0.5f, 1, 0), right(0.5f, 1, 0);
    const NormalErrors errors = normal_errors(triangle(left, left, right), ReferenceSurface(triangle(up, up, up)));
    EXPECT_NEAR(errors.flat[0], 0.0, 1e-12);
    EXPECT_GT(errors.gouraud[0], 0.05);
}

TEST(NormalErrors, ReferenceWithoutNormalsHasThoseOfItsTriangles) {
    mesh::Mesh bare = triangle(up, up, up);
    bare.normals.clear();
    EXPECT_EQ(ReferenceSurface(bare).normal_near({0.2, 3.0, 0.2}), Vec3d(0, 1, 0));
    EXPECT_NEAR(normal_errors(triangle(up, up, up), ReferenceSurface(bare)).flat[0], 0.0, 1e-12);
}

TEST(NormalErrors, LevelWithoutNormalsIsFlatEitherWay) {
    mesh::Mesh bare = testing::sphere(8);
    bare.normals.clear();
    const NormalErrors errors = normal_errors(bare, ReferenceSurface(testing::sphere(32)));
    EXPECT_EQ(errors.flat, errors.gouraud);
}

TEST(NormalErrors, PlacesThatFaceApartSayNothing) {
    const NormalErrors errors = normal_errors(triangle(up, up, up), ReferenceSurface(triangle(-up, -up, -up)));
    EXPECT_EQ(errors.flat[0], 0.0);
    EXPECT_EQ(errors.gouraud[0], 0.0);
}

TEST(NormalErrors, EmptyZeroAreaAndUnfiniteInputGivesNothing) {
    const ReferenceSurface empty{mesh::Mesh{}}, round(testing::sphere(8));
    EXPECT_EQ(empty.normal_near({1, 2, 3}), Vec3d(0.0));
    EXPECT_TRUE(normal_errors({}, round).flat.empty());
    mesh::Mesh broken = triangle(up, up, up);
    EXPECT_EQ(normal_errors(broken, empty).flat[0], 0.0);
    broken.positions[1] = broken.positions[0];
    EXPECT_EQ(normal_errors(broken, round).flat[0], 0.0);
    broken.positions[1] = Vec3f(std::numeric_limits<float>::quiet_NaN());
    EXPECT_EQ(normal_errors(broken, round).flat[0], 0.0);
    broken = triangle(Vec3f(std::numeric_limits<float>::infinity()), up, Vec3f(0.0f));
    const NormalErrors errors = normal_errors(broken, round);
    EXPECT_TRUE(std::isfinite(errors.flat[0]) && std::isfinite(errors.gouraud[0]));
}

}  // namespace
}  // namespace lodestream::shading
