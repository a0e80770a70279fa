#include <gtest/gtest.h>

#include "common/base/packed_normal.h"
#include "common/simplify/history.h"
#include "tests/common/simplify/shapes.h"

namespace lodestream::simplify {
namespace {

using mesh::Mesh;

// Step 0: triangle 0 1 2. Step 1 parts vertex 3 from vertex 1, which moves: triangle 1 comes between them. Step 2 hangs
// triangle 2 with a vertex of its own on them.
History three_steps() {
    History h;
    h.steps = {{1, 3, 0}, {2, 4, 1}, {3, 5, 1}};
    h.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {2, 2, 0}, {1, 0, 0}, {3, 3, 0}};
    for (const Vec3f& p : h.positions) {
        h.normals.push_back(pack_normal({0, 0, 1}));
        h.texture_coordinates.emplace_back(p);
        h.colors.emplace_back(static_cast<std::uint8_t>(p.x), static_cast<std::uint8_t>(p.y), 0, 255);
    }
    h.changed_vertices = {1};
    h.moved_corners = {2};
    h.moved_corner_ends = {0, 0, 0, 1, 1};
    h.triangles = {{0, 1, 2}, {1, 3, 2}, {1, 4, 3}};
    h.triangle_materials = {7, 8, 9};
    return h;
}

TEST(Cut, GivesEverythingForALargeBudget) {
    for (const std::uint64_t n : {std::uint64_t{3}, std::uint64_t{4}, ~std::uint64_t{0}}) {
        const Mesh level = cut(three_steps(), n);
        EXPECT_EQ(level.triangles.size(), 3u);
        EXPECT_EQ(level.positions.size(), 5u);
    }
}

TEST(Cut, GivesNothingForNothing) {
    const Mesh level = cut(three_steps(), 0);
    EXPECT_TRUE(level.triangles.empty());
    EXPECT_TRUE(level.positions.empty());
    EXPECT_TRUE(cut(History{}, 5).triangles.empty());
}

TEST(Cut, TheCoarsestLevelIsTheBase) {
    const Mesh level = cut(three_steps(), 1);
    EXPECT_EQ(level.triangles, (std::vector<mesh::Triangle>{{0, 1, 2}}));
    EXPECT_EQ(level.positions, (std::vector<Vec3f>{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}));
}

TEST(Cut, StepsMakeMoveAndChange) {
    const Mesh level = cut(three_steps(), 2);
    EXPECT_EQ(level.triangles, (std::vector<mesh::Triangle>{{0, 1, 3}, {1, 3, 2}}));
    EXPECT_EQ(level.positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {2, 2, 0}}));
}

TEST(Cut, CarriesAttributesAndMaterials) {
    const Mesh level = cut(three_steps(), 3);
    EXPECT_EQ(level.triangle_materials, (std::vector<std::uint32_t>{7, 8, 9}));
    ASSERT_EQ(level.colors.size(), level.positions.size());
    ASSERT_EQ(level.normals.size(), level.positions.size());
    for (std::size_t v = 0; v < level.positions.size(); ++v) {
        EXPECT_EQ(level.texture_coordinates[v], Vec2f(level.positions[v]));
        EXPECT_EQ(level.colors[v].r, level.positions[v].x);
        EXPECT_EQ(level.normals[v], Vec3f(0, 0, 1));
    }
}

TEST(Cut, GoesBelowTheBudgetWhereTrianglesComeTogether) {
    History h = three_steps();
    h.steps = {{1, 3, 0}, {3, 5, 0}};
    h.positions.pop_back();
    h.normals.pop_back();
    h.texture_coordinates.pop_back();
    h.colors.pop_back();
    h.changed_vertices.clear();
    ASSERT_TRUE(validate(view(h)).ok());
    EXPECT_EQ(cut(h, 2).triangles.size(), 1u);
    EXPECT_EQ(triangles_within(view(h), 2), 1u);
    EXPECT_EQ(triangles_within(view(h), 3), 3u);
    EXPECT_EQ(triangles_within(view(h), 0), 0u);
}

TEST(Cut, LeavesOutTrianglesThatFold) {
    History h = three_steps();
    h.positions[3] = h.positions[2];  // vertex 3 lies where vertex 2 does
    ASSERT_TRUE(validate(view(h)).ok());
    const Mesh level = cut(h, 3);
    EXPECT_EQ(level.triangles.size(), 2u);
    EXPECT_EQ(level.triangle_materials, (std::vector<std::uint32_t>{7, 9}));
}

TEST(PackedNormal, KeepsADirectionToAFewThousandthsOfADegree) {
    for (int i = 0; i < 2000; ++i) {
        const double theta = std::acos(1 - 2 * (i + 0.5) / 2000), phi = 2.399963 * i;
        const Vec3d n{std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
        const Vec3d back(unpack_normal(pack_normal(Vec3f(7.0 * n))));
        EXPECT_LT(length(back - n), 1e-4) << i;
    }
}

TEST(PackedNormal, IsAUnitVectorWhateverGoesIn) {
    const float infinity = std::numeric_limits<float>::infinity();
    for (const Vec3f& v : {Vec3f{0.0f}, Vec3f{infinity, 0, 0}, Vec3f{std::nanf(""), 1, 2}, Vec3f{-1, 0, 0},
                           Vec3f{0, 0, -1}, Vec3f{3e38f, 3e38f, -3e38f}, Vec3f{1e-45f, 0, 0}})
        EXPECT_NEAR(length(unpack_normal(pack_normal(v))), 1.0f, 1e-6f);
    for (const std::uint32_t bits : {0u, 0xffffffffu, 0x80008000u, 0x7fff8000u, 0x80007fffu})
        EXPECT_NEAR(length(unpack_normal(bits)), 1.0f, 1e-6f) << bits;
}

}  // namespace
}  // namespace lodestream::simplify
