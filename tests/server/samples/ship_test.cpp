#include <gtest/gtest.h>

#include "server/samples/samples.h"
#include "server/samples/shape_builder.h"
#include "tests/server/samples/mesh_checks.h"

namespace lodestream::samples {
namespace {

using namespace lodestream::testing;

TEST(Ship, IsSoundForAnyNumberOfObjects) {
    for (const std::uint64_t n : {1, 2, 10, 33, 100, 777, 3'000}) {
        SCOPED_TRACE(n);
        const auto model = ship(n);
        ASSERT_TRUE(model.ok());
        EXPECT_EQ(model->objects, n);
        EXPECT_EQ(model->kind, mesh::Kind::scene);
        expect_sound(*model);
        EXPECT_GT(worst_normal(model->mesh), 0.6);
    }
}

TEST(Ship, EveryObjectAddsTrianglesOfItsOwn) {
    std::size_t previous = 0;
    for (std::uint64_t n = 1; n <= 30; ++n) {  // while parts are added one after another to a ship of one size
        const std::size_t triangles = ship(n)->mesh.triangles.size();
        EXPECT_GT(triangles, previous) << n;
        previous = triangles;
    }
}

TEST(Ship, HasAtLeastAsManySeparateShellsAsObjects) {
    for (const std::uint64_t n : {100, 1'000}) EXPECT_GE(components(directed_edges(ship(n)->mesh)), n);
}

TEST(Ship, HasAHullThatIsClosedAndFacesOutwards) {
    const auto model = ship(1);
    EXPECT_TRUE(border(directed_edges(model->mesh)).empty());
    EXPECT_GT(signed_volume(model->mesh), 0);
    const Box box = mesh::bounds(model->mesh);
    EXPECT_GT(box.extent().x, 4 * box.extent().z);
    EXPECT_LT(box.min.y, 0);
    EXPECT_GT(box.max.y, 0);
}

TEST(Ship, GrowsWithItsObjects) {
    EXPECT_GT(mesh::bounds(ship(3'000)->mesh).extent().x, 1.5 * mesh::bounds(ship(300)->mesh).extent().x);
}

TEST(Ship, IsTheSameForASeedAndDifferentForAnother) {
    const auto one = ship(200, 5), again = ship(200, 5), other = ship(200, 6);
    EXPECT_EQ(one->mesh.positions, again->mesh.positions);
    EXPECT_EQ(one->mesh.triangle_materials, again->mesh.triangle_materials);
    EXPECT_NE(one->mesh.positions, other->mesh.positions);
}

TEST(Ship, RefusesNoneAndTooMany) {
    EXPECT_EQ(ship(0).error().code, ErrorCode::invalid_input);
    EXPECT_EQ(ship(max_ship_objects + 1).error().code, ErrorCode::limit_exceeded);
}

// The largest has no more triangles an object than one of a sixth.
TEST(Ship, StaysBelowTheTriangleLimitAtItsLargest) {
    constexpr std::uint64_t share = 6;
    const auto model = ship(max_ship_objects / share);
    ASSERT_TRUE(model.ok());
    EXPECT_LE(share * model->mesh.triangles.size(), max_sample_triangles);
}

double volume_of(ShapeBuilder& builder) {
    return signed_volume(builder.take());
}

TEST(ShapeBuilder, ShapesAreClosedAndEncloseTheirVolume) {
    const Frame tilted = along({1, 2, 3}, {2, 4, 2});
    ShapeBuilder builder;
    builder.box(tilted, {1, 2, 3});
    EXPECT_NEAR(volume_of(builder), 6, 1e-5);

    builder.rod({0, 0, 0}, {3, 1, 2}, 0.5, 64);
    EXPECT_NEAR(volume_of(builder), pi * 0.25 * std::sqrt(14.0), 0.02);

    const std::vector<Vec3d> path{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}};
    builder.pipe(path, 0.1, 8);
    const mesh::Mesh pipe = builder.take();
    EXPECT_TRUE(border(directed_edges(pipe)).empty());
    EXPECT_GT(signed_volume(pipe), 0);
}

}  // namespace
}  // namespace lodestream::samples
