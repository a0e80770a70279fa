#include <gtest/gtest.h>

#include "common/simplify/history.h"
#include "tests/common/simplify/shapes.h"

namespace lodestream::simplify {
namespace {

using mesh::Mesh;

// A square of two triangles, 0 1 2 and 1 3 2, with a second square hanging on its right side: 1 4 3 and 4 5 3.
Mesh two_squares() {
    Mesh m;
    m.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 0, 0}, {2, 1, 0}};
    m.normals.assign(6, {0, 0, 1});
    m.texture_coordinates = {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {2, 0}, {2, 1}};
    m.colors = {{0, 0, 0, 255}, {1, 0, 0, 255}, {2, 0, 0, 255}, {3, 0, 0, 255}, {4, 0, 0, 255}, {5, 0, 0, 255}};
    m.triangles = {{0, 1, 2}, {1, 3, 2}, {1, 4, 3}, {4, 5, 3}};
    m.triangle_materials = {7, 7, 8, 9};
    return m;
}

// Step 0: 1 into 4 (triangle 2 vanishes); step 1: 3 into 5 (triangle 3); step 2: triangle 1 is dropped.
History two_squares_history() {
    return {{0, 4, 2, 5, 4, 5}, {never, 0, never, 1, never, never}, {0, 1, 3, 2}, {never, 2, 1, 0}};
}

TEST(Cut, GivesEverythingForALargeBudget) {
    for (const std::uint64_t n : {std::uint64_t{4}, std::uint64_t{5}, ~std::uint64_t{0}}) {
        const Mesh level = cut(two_squares(), two_squares_history(), n);
        EXPECT_EQ(level.triangles.size(), 4u);
        EXPECT_EQ(level.positions.size(), 6u);
    }
}

TEST(Cut, GivesNothingForNothing) {
    const Mesh level = cut(two_squares(), two_squares_history(), 0);
    EXPECT_TRUE(level.triangles.empty());
    EXPECT_TRUE(level.positions.empty());
}

TEST(Cut, FollowsTheMergesUpToTheLevel) {
    const Mesh level = cut(two_squares(), two_squares_history(), 2);
    ASSERT_EQ(level.triangles.size(), 2u);
    const std::vector<Vec3f> expected{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 1, 0}};
    EXPECT_EQ(level.positions, expected);
    EXPECT_EQ(level.triangles[0], (mesh::Triangle{0, 1, 2}));
    EXPECT_EQ(level.triangles[1], (mesh::Triangle{1, 3, 2}));
}

TEST(Cut, CarriesAttributesAndMaterials) {
    const Mesh level = cut(two_squares(), two_squares_history(), 3);
    ASSERT_EQ(level.triangles.size(), 3u);
    EXPECT_EQ(level.triangle_materials, (std::vector<std::uint32_t>{7, 7, 9}));
    ASSERT_EQ(level.colors.size(), level.positions.size());
    ASSERT_EQ(level.normals.size(), level.positions.size());
    for (std::size_t v = 0; v < level.positions.size(); ++v) {
        EXPECT_EQ(level.texture_coordinates[v], Vec2f(level.positions[v]));
        EXPECT_EQ(two_squares().positions[level.colors[v].r], level.positions[v]);
    }
}

TEST(Cut, GoesBelowTheBudgetWhereTrianglesVanishTogether) {
    History history = two_squares_history();
    history.triangle_step = {never, 2, 2, 0};
    EXPECT_EQ(cut(two_squares(), history, 3).triangles.size(), 3u);
    EXPECT_EQ(cut(two_squares(), history, 2).triangles.size(), 1u);
}

TEST(Cut, LeavesOutTrianglesThatADamagedHistoryFoldsUp) {
    History history = two_squares_history();
    history.vertex_parent[0] = 4;  // triangle 0 folds up while it is said to live
    history.vertex_step[0] = 0;
    ASSERT_TRUE(validate(history, 6, 4).ok());
    for (std::uint64_t n = 0; n <= 4; ++n)
        for (const Mesh level = cut(two_squares(), history, n); const mesh::Triangle& t : level.triangles)
            EXPECT_GT(mesh::face_area(level.positions[t[0]], level.positions[t[1]], level.positions[t[2]]), 0);
}

TEST(Cut, WalksVeryLongChainsOfMerges) {
    const std::uint32_t n = 200'000;
    Mesh m;
    History history;
    for (std::uint32_t v = 0; v <= n; ++v) {
        m.positions.push_back({static_cast<float>(v), 0, 0});
        history.vertex_parent.push_back(std::min(v + 1, n));
        history.vertex_step.push_back(v < n ? v : never);
    }
    m.positions.insert(m.positions.end(), {{0, 1, 0}, {0, 2, 0}});
    history.vertex_parent.insert(history.vertex_parent.end(), {n + 1, n + 2});
    history.vertex_step.insert(history.vertex_step.end(), {never, never});
    m.triangles = {{0, n + 1, n + 2}, {5, n + 1, n + 2}};
    history.triangle_order = {0, 1};
    history.triangle_step = {never, n};
    ASSERT_TRUE(validate(history, m.positions.size(), 2).ok());
    const Mesh level = cut(m, history, 1);
    ASSERT_EQ(level.triangles.size(), 1u);
    EXPECT_EQ(level.positions[0].x, static_cast<float>(n));
}

}  // namespace
}  // namespace lodestream::simplify
