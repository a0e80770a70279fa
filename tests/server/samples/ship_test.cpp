#include <gtest/gtest.h>

#include "common/mesh/instances.h"
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

TEST(FineShip, IsTheShipWithEightyMillionTrianglesAtItsLargest) {
    const auto model = fine_ship();
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->objects, max_ship_objects);
    EXPECT_NEAR(static_cast<double>(mesh::triangle_count(*model)), 80e6, 2e6);
    EXPECT_LE(model->shapes.size(), 16u);
    EXPECT_LT(model->mesh.triangles.size(), 100'000u);
}

TEST(FineShip, HasItsPartsWhereTheShipHasThem) {
    for (const std::uint64_t n : {1, 777, 2'000}) {
        SCOPED_TRACE(n);
        const auto fine = fine_ship(n), plain = ship(n);
        ASSERT_TRUE(fine.ok());
        EXPECT_EQ(fine->objects, n);
        EXPECT_EQ(fine->graph.object_nodes.size(), n);
        mesh::Model flat = *fine;
        flat.mesh = mesh::flattened(*fine, fine->shapes);
        expect_sound(flat);
        EXPECT_GT(worst_normal(flat.mesh), 0.2);  // short pipe runs are bent sharply
        std::vector<Box> boxes(n), plain_boxes(n);
        const auto add = [](std::vector<Box>& to, const mesh::Mesh& mesh) {
            for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
                for (const std::uint32_t v : mesh.triangles[t])
                    to[mesh.triangle_objects[t]].add(Vec3d(mesh.positions[v]));
        };
        add(boxes, flat.mesh);
        add(plain_boxes, plain->mesh);
        constexpr double slack_m = 0.6;  // pipes are as thick as the length of their run would have them
        for (std::size_t i = 0; i < n; ++i) {
            EXPECT_LT(distance(boxes[i].min, plain_boxes[i].min), slack_m) << i;
            EXPECT_LT(distance(boxes[i].max, plain_boxes[i].max), slack_m) << i;
        }
    }
}

TEST(FineShip, RefusesNoneAndTooMany) {
    EXPECT_EQ(fine_ship(0).error().code, ErrorCode::invalid_input);
    EXPECT_EQ(fine_ship(max_ship_objects + 1).error().code, ErrorCode::limit_exceeded);
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
