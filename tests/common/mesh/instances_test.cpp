#include "common/mesh/instances.h"

#include <gtest/gtest.h>

#include "common/base/transform.h"
#include "common/mesh/operations.h"

namespace lodestream::mesh {
namespace {

Mesh one_triangle() {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    mesh.triangle_materials = {0};
    return mesh;
}

// One object in the mesh, and the same triangle at x = 10 and, mirrored and twice as large, at x = 20.
Model three_objects() {
    Model model;
    model.mesh = one_triangle();
    model.mesh.triangle_objects = {0};
    model.shapes = {one_triangle()};
    model.instances = {{1, 0, translation({10, 0, 0})}, {2, 0, matrix_of({20, 0, 0}, {0, 0, 0, 1}, {-2, 2, 2})}};
    model.objects = 3;
    model.graph = flat_graph(3);
    return model;
}

TEST(Instances, AreCountedAsOftenAsTheyAreShown) {
    EXPECT_EQ(triangle_count(three_objects()), 3u);
    EXPECT_EQ(vertex_count(three_objects()), 9u);
    EXPECT_EQ(triangle_count(Model{}), 0u);
}

TEST(Instances, BoundsHoldWhatIsShownAndNotTheShapeItself) {
    Model model = three_objects();
    EXPECT_EQ(bounds(model).min, Vec3d(0, 0, 0));
    EXPECT_EQ(bounds(model).max, Vec3d(20, 2, 0));
    model.mesh = {};
    EXPECT_EQ(bounds(model).min, Vec3d(10, 0, 0));
    EXPECT_TRUE(bounds(Model{}).empty());
}

TEST(Instances, FlattenedIsEveryObjectAtItsPlaceFacingAsItDoesThere) {
    const Model model = three_objects();
    const Mesh all = flattened(model, model.shapes);
    EXPECT_EQ(all.triangle_objects, (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(all.triangle_materials.size(), 3u);
    for (const auto& [a, b, c] : all.triangles)
        EXPECT_GT(face_normal(all.positions[a], all.positions[b], all.positions[c]).z, 0.0);
}

}  // namespace
}  // namespace lodestream::mesh
