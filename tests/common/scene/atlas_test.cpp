#include "common/scene/atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/mesh/operations.h"
#include "tests/support/scenes.h"

namespace lodestream::scene {
namespace {

using testing::moved;

Vec3d place_of(const mesh::Mesh& mesh, const Texel& texel) {
    Vec3d place(0.0);
    for (int k = 0; k < 3; ++k)
        place += static_cast<double>(texel.weights[k]) *
                 Vec3d(mesh.positions[mesh.triangles[texel.triangle][static_cast<std::size_t>(k)]]);
    return place;
}

// Where the image shows a place of a triangle of the atlas, texels.
glm::dvec2 seen_at(const Atlas& atlas, const Texel& texel) {
    glm::dvec2 place(0.0);
    for (int k = 0; k < 3; ++k) {
        const std::uint32_t v = atlas.mesh.triangles[texel.triangle][static_cast<std::size_t>(k)];
        place += static_cast<double>(texel.weights[k]) * glm::dvec2(atlas.mesh.texture_coordinates[v]);
    }
    return place * glm::dvec2(atlas.width, atlas.height);
}

void expect_sound(const Atlas& atlas, const mesh::Mesh& surface) {
    ASSERT_EQ(atlas.texels.size(), std::size_t{atlas.width} * atlas.height);
    ASSERT_EQ(atlas.mesh.triangles.size(), surface.triangles.size());
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_EQ(atlas.mesh.positions[atlas.mesh.triangles[t][k]], surface.positions[surface.triangles[t][k]]);
    for (const Vec2f& place : atlas.mesh.texture_coordinates) {
        EXPECT_TRUE(place.x >= 0.0f && place.x <= 1.0f && place.y >= 0.0f && place.y <= 1.0f);
    }
    EXPECT_TRUE(std::any_of(atlas.texels.begin(), atlas.texels.end(),
                            [](const Texel& texel) { return texel.triangle != Texel::nothing; }));
}

TEST(Atlas, ATexelShowsThePlaceWhoseCoordinatesLeadToIt) {
    const mesh::Mesh sphere = testing::sphere(24);
    const Atlas atlas = unfold(sphere, 10'000);
    expect_sound(atlas, sphere);
    std::size_t shown = 0;
    for (std::size_t i = 0; i < atlas.texels.size(); ++i) {
        if (atlas.texels[i].triangle == Texel::nothing) continue;
        ++shown;
        const std::size_t x = i % atlas.width, y = i / atlas.width;
        const glm::dvec2 middle(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
        EXPECT_LT(distance(seen_at(atlas, atlas.texels[i]), middle), 1e-2);
        EXPECT_NEAR(length(place_of(sphere, atlas.texels[i])), 1.0, 0.02);
    }
    EXPECT_GT(shown, 5'000u);
    EXPECT_LT(shown, 10'500u);
}

TEST(Atlas, ChartsKeepATexelApart) {
    const mesh::Mesh sphere = testing::sphere(16);
    const Atlas atlas = unfold(sphere, 4'000);
    const auto chart_of = [&](const Texel& texel) { return atlas.mesh.triangles[texel.triangle]; };
    std::vector<std::uint32_t> chart(atlas.mesh.positions.size());  // the lowest vertex that is joined to it
    for (std::uint32_t v = 0; v < chart.size(); ++v) chart[v] = v;
    for (std::size_t round = 0; round < chart.size(); ++round) {
        bool is_changed = false;
        for (const auto& [a, b, c] : atlas.mesh.triangles) {
            const std::uint32_t least = std::min({chart[a], chart[b], chart[c]});
            is_changed = is_changed || chart[a] != least || chart[b] != least || chart[c] != least;
            chart[a] = chart[b] = chart[c] = least;
        }
        if (!is_changed) break;
    }
    for (std::uint32_t y = 0; y < atlas.height; ++y)
        for (std::uint32_t x = 1; x < atlas.width; ++x) {
            const Texel &left = atlas.texels[y * atlas.width + x - 1], &right = atlas.texels[y * atlas.width + x];
            if (left.triangle == Texel::nothing || right.triangle == Texel::nothing) continue;
            EXPECT_EQ(chart[chart_of(left)[0]], chart[chart_of(right)[0]]) << x << ' ' << y;
        }
}

TEST(Atlas, WhatLiesOverItselfIsSeveralCharts) {
    // A strip that turns around an axis three times, all of it facing up.
    mesh::Mesh stairs;
    constexpr std::uint32_t steps = 90;
    for (std::uint32_t i = 0; i <= steps; ++i)
        for (const double radius : {1.0, 3.0}) {
            const double angle = 6.0 * pi * i / steps;
            stairs.positions.emplace_back(radius * std::cos(angle), 0.02 * i, -radius * std::sin(angle));
        }
    for (std::uint32_t i = 0; i < steps; ++i) {
        stairs.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 2});
        stairs.triangles.push_back({2 * i + 1, 2 * i + 3, 2 * i + 2});
    }
    const Atlas atlas = unfold(stairs, 20'000);
    expect_sound(atlas, stairs);
    std::vector<std::size_t> shown(stairs.triangles.size(), 0);
    for (const Texel& texel : atlas.texels)
        if (texel.triangle != Texel::nothing) ++shown[texel.triangle];
    EXPECT_GT(*std::min_element(shown.begin(), shown.end()), 20u);
}

TEST(Atlas, NeedlesSoupAndScalesStayWithinBounds) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> place(-1.0f, 1.0f);
    mesh::Mesh needles;
    for (std::uint32_t i = 0; i < 500; ++i) {
        const Vec3f from(place(random), place(random), place(random)), to(place(random), place(random), place(random));
        needles.positions.insert(needles.positions.end(), {from, to, from + Vec3f(0, 1e-7f, 0)});
        needles.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    for (const float scale : {1e-9f, 1.0f, 1e9f})
        for (const mesh::Mesh& mesh :
             {needles, testing::single_triangle(), testing::flat_grid(9), testing::tetrahedron()}) {
            const mesh::Mesh scaled = moved(mesh, {0, 0, 0}, scale);
            const Atlas atlas = unfold(scaled, 1'000);
            expect_sound(atlas, scaled);
            EXPECT_LE(atlas.width, 2 * max_atlas_side);
            EXPECT_LE(atlas.texels.size(), 500'000u);
        }
}

TEST(Atlas, OneTexelServesOneTriangle) {
    const Atlas atlas = unfold(testing::single_triangle(), 1);
    expect_sound(atlas, testing::single_triangle());
    EXPECT_LE(atlas.texels.size(), 36u);
}

}  // namespace
}  // namespace lodestream::scene
