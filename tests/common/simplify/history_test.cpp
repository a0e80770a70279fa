#include <gtest/gtest.h>

#include <algorithm>

#include "common/simplify/history.h"
#include "tests/common/simplify/shapes.h"

namespace lodestream::simplify {
namespace {

constexpr std::uint32_t slices = 8;

class Validate : public ::testing::Test {
  protected:
    bool accepts() const {
        const Status status = validate(history, mesh.positions.size(), mesh.triangles.size());
        if (!status.ok()) {
            EXPECT_EQ(status.error().code, ErrorCode::invalid_input);
        }
        return status.ok();
    }
    // A vertex that merges, and not first.
    std::size_t merging() const {
        const auto& steps = history.vertex_step;
        return static_cast<std::size_t>(
            std::find_if(steps.begin(), steps.end(), [](std::uint32_t s) { return s != never && s > 3; }) -
            steps.begin());
    }

    const mesh::Mesh mesh = testing::sphere(slices);
    History history = record_history(mesh).value();
};

TEST_F(Validate, AcceptsWhatWasRecorded) {
    EXPECT_TRUE(accepts());
}

TEST_F(Validate, RefusesTooFewVertices) {
    history.vertex_parent.pop_back();
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesTooManySteps) {
    history.vertex_step.push_back(never);
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesTooFewTriangles) {
    history.triangle_order.pop_back();
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesTooFewTriangleSteps) {
    history.triangle_step.pop_back();
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesAParentOutOfRange) {
    history.vertex_parent[merging()] = static_cast<std::uint32_t>(mesh.positions.size());
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesAParentThatMergedEarlier) {
    const std::size_t v = merging();
    const auto& steps = history.vertex_step;
    history.vertex_parent[v] = static_cast<std::uint32_t>(std::min_element(steps.begin(), steps.end()) - steps.begin());
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesACircle) {
    history.vertex_parent[history.vertex_parent[merging()]] = static_cast<std::uint32_t>(merging());
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesAMergeIntoItself) {
    const std::size_t v = merging();
    history.vertex_parent[v] = static_cast<std::uint32_t>(v);
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesAStayingVertexWithAParent) {
    history.vertex_step[merging()] = never;
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesAStepThatCannotBe) {
    history.vertex_parent = std::vector<std::uint32_t>(mesh.positions.size(), 0);
    history.vertex_step = std::vector<std::uint32_t>(mesh.positions.size(), never - 1);
    history.vertex_step[0] = never;
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesATriangleOutOfRange) {
    history.triangle_order[3] = static_cast<std::uint32_t>(mesh.triangles.size());
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesATriangleTwice) {
    history.triangle_order[3] = history.triangle_order[4];
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesTriangleStepsThatRise) {
    std::swap(history.triangle_step.front(), history.triangle_step.back());
    EXPECT_FALSE(accepts());
}

TEST_F(Validate, RefusesATriangleStepThatCannotBe) {
    history.triangle_step[0] = never - 1;
    EXPECT_FALSE(accepts());
}

}  // namespace
}  // namespace lodestream::simplify
