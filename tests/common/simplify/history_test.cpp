#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "common/simplify/history.h"
#include "tests/common/simplify/shapes.h"

namespace lodestream::simplify {
namespace {

struct Validate : ::testing::Test {
    mesh::Mesh mesh = testing::textured_tube(8, 4);
    History history = record_history(mesh).value();

    void expect_refused(const std::string& why) const {
        const Status status = validate(view(history));
        ASSERT_FALSE(status.ok());
        EXPECT_NE(status.error().message.find(why), std::string::npos) << status.error().message;
    }
    std::size_t last() const { return history.steps.size() - 1; }
};

TEST_F(Validate, AcceptsWhatWasRecorded) {
    EXPECT_TRUE(validate(view(history)).ok());
    EXPECT_TRUE(validate(HistoryView{}).ok());
}

TEST_F(Validate, RefusesTooFewValues) {
    history.positions.pop_back();
    expect_refused("values");
}

TEST_F(Validate, RefusesTooManyNormals) {
    history.normals.push_back(0);
    expect_refused("values");
}

TEST_F(Validate, RefusesTooFewTriangles) {
    history.triangles.pop_back();
    expect_refused("triangles");
}

TEST_F(Validate, RefusesMaterialsForSomeTriangles) {
    history.triangle_materials = {0, 0};
    expect_refused("triangles");
}

TEST_F(Validate, RefusesTooManyChanges) {
    history.changed_vertices.push_back(0);
    expect_refused("changes");
}

TEST_F(Validate, RefusesTooFewCornerMoves) {
    history.moved_corners.pop_back();
    expect_refused("corner moves");
}

TEST_F(Validate, RefusesCornerMovesForTooFewVertices) {
    history.moved_corner_ends.pop_back();
    expect_refused("corner moves");
}

TEST_F(Validate, RefusesAVertexThatGivesCornersBack) {
    history.moved_corner_ends[history.moved_corner_ends.size() / 2] = 0;
    expect_refused("takes corners");
}

TEST_F(Validate, RefusesTrianglesWithoutSteps) {
    history.steps.clear();
    expect_refused("triangles");
}

TEST_F(Validate, RefusesAStepThatTakesBack) {
    history.steps[1].triangles = 0;
    expect_refused("takes back");
}

TEST_F(Validate, RefusesAChangeOfAVertexThatIsNotThere) {
    ASSERT_FALSE(history.changed_vertices.empty());
    history.changed_vertices.front() = history.steps[last()].vertices - 1;
    expect_refused("changes a vertex");
}

TEST_F(Validate, RefusesAMoveOfACornerThatIsNotThere) {
    history.moved_corners.front() = 3 * history.steps[last()].triangles - 1;
    expect_refused("moves a corner");
}

TEST_F(Validate, RefusesATriangleOfAVertexThatIsNotThere) {
    history.triangles.front()[1] = history.steps[last()].vertices - 1;
    expect_refused("triangle uses");
}

TEST_F(Validate, RefusesNumbersThatAreNone) {
    history.positions[3].y = std::numeric_limits<float>::quiet_NaN();
    expect_refused("not finite");
    history = record_history(mesh).value();
    history.texture_coordinates[2].x = std::numeric_limits<float>::infinity();
    expect_refused("not finite");
}

}  // namespace
}  // namespace lodestream::simplify
