#include "server/bake/shapes.h"

#include <gtest/gtest.h>

#include "common/base/transform.h"
#include "common/mesh/instances.h"
#include "tests/support/scenes.h"

namespace lodestream::bake {
namespace {

std::vector<ShapeLevels> levels_of(const mesh::Model& model) {
    return *make_shape_levels(model, [] { return true; });
}

TEST(ShapeLevels, BeginWithTheShapeAndEndAtTheFewestTriangles) {
    const mesh::Model model = testing::instanced_spheres(2, 24);
    const ShapeLevels levels = levels_of(model).front();
    EXPECT_EQ(levels.front().mesh.positions, model.shapes[0].positions);
    EXPECT_EQ(levels.front().error.max, 0.0);
    for (std::size_t i = 1; i < levels.size(); ++i) {
        EXPECT_LE(2 * levels[i].mesh.triangles.size(), levels[i - 1].mesh.triangles.size() + 2);
        EXPECT_GT(levels[i].error.max, 0.0);
    }
    EXPECT_LT(levels.back().mesh.triangles.size(), 2 * least_shape_triangles);
    EXPECT_GE(levels.back().mesh.triangles.size() + 1, least_shape_triangles);
}

TEST(ShapeLevels, OfAShapeWithFewTrianglesAreTheShape) {
    mesh::Model model = testing::instanced_spheres(2, 3);
    EXPECT_EQ(levels_of(model).front().size(), 1u);
    EXPECT_EQ(stand_in(levels_of(model).front()).error.max, 0.0);
}

TEST(ShapeLevels, MakingThemCanBeEnded) {
    const auto levels = make_shape_levels(testing::instanced_spheres(2, 24), [] { return false; });
    ASSERT_FALSE(levels.ok());
    EXPECT_EQ(levels.error().code, ErrorCode::unavailable);
}

TEST(StandIn, IsSmallOrCloseWhicheverTakesFewerTriangles) {
    const ShapeLevels smooth = levels_of(testing::instanced_spheres(2, 40)).front();
    const ShapeLevel& chosen = stand_in(smooth);
    EXPECT_LE(chosen.error.max, stand_in_error * mesh::bounds(smooth.front().mesh).diagonal());
    EXPECT_LT(chosen.mesh.triangles.size(), stand_in_ratio * smooth.front().mesh.triangles.size());

    mesh::Model thin = testing::instanced_spheres(2, 8);  // no coarser level is close
    const ShapeLevels rough = levels_of(thin).front();
    EXPECT_LE(stand_in(rough).mesh.triangles.size(), stand_in_ratio * rough.front().mesh.triangles.size());
}

TEST(WholeModel, IsTheSceneItselfWhereThatFits) {
    const mesh::Model model = testing::instanced_spheres(3, 12);
    const WholeModel whole = whole_model(model, levels_of(model), mesh::triangle_count(model));
    EXPECT_EQ(whole.model.mesh.positions, mesh::flattened(model, model.shapes).positions);
    EXPECT_EQ(whole.error.max, 0.0);
    EXPECT_TRUE(whole.model.instances.empty());
    EXPECT_EQ(whole.model.objects, model.objects);
}

TEST(WholeModel, KeepsToItsTrianglesAndSaysWhatThatIsOff) {
    const mesh::Model model = testing::instanced_spheres(4, 24);
    const std::vector<ShapeLevels> levels = levels_of(model);
    const mesh::Mesh finest = mesh::flattened(model, model.shapes);
    const metric::SurfaceIndex original(finest);
    double before = 0.0;
    for (const std::uint64_t most : {15'000u, 10'000u, 6'000u}) {
        const WholeModel whole = whole_model(model, levels, most);
        EXPECT_LE(whole.model.mesh.triangles.size(), most);
        EXPECT_GT(whole.error.max, before);
        EXPECT_LE(metric::measure(original, finest, whole.model.mesh).max, 1.05 * whole.error.max);
        before = whole.error.max;
    }
}

TEST(WholeModel, ThatCannotBeAsSmallIsMadeOfTheCoarsestLevels) {
    const mesh::Model model = testing::instanced_spheres(3, 12);
    const std::vector<ShapeLevels> levels = levels_of(model);
    const std::size_t coarsest = levels.front().back().mesh.triangles.size();
    EXPECT_EQ(whole_model(model, levels, 1).model.mesh.triangles.size(),
              model.mesh.triangles.size() + model.instances.size() * coarsest);
}

TEST(WholeModel, CoarsensFirstWhatIsOffLeastWhereItStands) {
    mesh::Model model = testing::instanced_spheres(3, 12);
    model.shapes.push_back(model.shapes[0]);
    const std::size_t shape = model.shapes[0].triangles.size();
    for (std::size_t i = 0; i < 3; ++i) {
        model.instances[i].shape = 1;
        model.instances[i].matrix = model.instances[i].matrix * matrix_of({0, 0, 0}, {0, 0, 0, 1}, Vec3d(0.01));
    }
    const WholeModel whole = whole_model(model, levels_of(model), mesh::triangle_count(model) - shape);
    EXPECT_LT(whole.error.max, 0.01) << "the small ones were coarsened";
    EXPECT_GT(whole.error.max, 0.0);
}

}  // namespace
}  // namespace lodestream::bake
