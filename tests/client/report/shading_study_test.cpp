#include "client/report/shading_study.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/meshes.h"

namespace lodestream::report {
namespace {

TEST(ShadingStudy, APurchaseNeverCostsMoreThanThePriceAndLeavesLessThanOneStep) {
    for (const std::uint64_t price : {4ull, 5ull, 401ull, 8000ull})
        for (double share = 0.25; share <= 1.0; share += 0.05) {
            const Purchase bought = purchase(price, share);
            const std::uint64_t cost = bought.triangles + 3 * bought.gouraud;
            EXPECT_LE(cost, price) << price << " " << share;
            EXPECT_LE(bought.gouraud, bought.triangles);
            EXPECT_TRUE(bought.gouraud == bought.triangles || cost + 3 > price) << price << " " << share;
        }
    EXPECT_EQ(purchase(8000, 1.0).gouraud, 0u);
    EXPECT_EQ(purchase(8000, 0.25).gouraud, 2000u);
    EXPECT_EQ(purchase(8000, 0.5).gouraud, 1333u);
}

TEST(ShadingStudy, LightRigStartsWithTheViewsLightAndItsIntensitiesSumToOne) {
    const shading::View view;
    for (const std::size_t count : {1u, 4u, 16u, 64u}) {
        const auto lights = light_rig(view, count);
        ASSERT_EQ(lights.size(), count);
        EXPECT_EQ(lights[0].direction, view.light);
        double sum = 0.0;
        for (const render::Light& light : lights) {
            sum += light.intensity;
            EXPECT_GT(length(light.direction), 0.5);
            EXPECT_TRUE(all_finite(light.direction));
        }
        EXPECT_NEAR(sum, 1.0, 1e-12);
    }
}

TEST(ShadingStudy, CountsTable3OnAMeshOfAsManyPolygons) {
    codec::Decoded content;
    content.materials.emplace_back();
    content.primitives.push_back({codec::Shading::gouraud, 0, testing::sphere(60)});
    content.primitives[0].mesh.triangles.resize(6400);
    const CountedOperations counted = count_operations(content, shading::View{{0, 0, 4}, {0, 0, 0}, 45, {0, 1, 0}});
    EXPECT_EQ(counted.criterion, 57'600u);
    EXPECT_EQ(counted.all_flat, 64'000u);
    EXPECT_EQ(counted.all_gouraud, 83'200u);
    EXPECT_EQ(counted.hybrid, 64'537u);
    EXPECT_EQ(counted.hybrid_as_printed, 75'463u);
    content.primitives[0].mesh.triangles.resize(100);
    EXPECT_FALSE(count_operations(content, {}).hybrid_as_printed.has_value());
}

}  // namespace
}  // namespace lodestream::report
