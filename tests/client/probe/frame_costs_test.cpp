#include "client/probe/frame_costs.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/random.h"

namespace lodestream::probe {
namespace {

control::FrameCosts some_costs() {
    control::FrameCosts costs;
    costs.fixed_ms = 0.2;
    costs.per_million_triangles_ms = 80.0;
    costs.per_million_vertices_ms = 95.0;
    costs.per_million_pixels_ms = 0.5;
    costs.per_million_shaded_ms = 5.0;
    costs.per_million_textured_ms = 2.0;
    costs.per_million_extent_ms = 30.0;
    return costs;
}

// Pictures of few and many, small and large triangles that share their vertices or do not.
std::vector<TimedPicture> pictures(const control::FrameCosts& costs, double noise) {
    Random random(5);
    std::vector<TimedPicture> out;
    for (const double triangles : {1e2, 6e3, 6e4})
        for (const double pixels : {4e3, 6e4, 1e6})
            for (const double vertices_share : {0.5, 1.0, 1.5}) {
                control::Work work;
                work.triangles = triangles;
                work.vertices = vertices_share * triangles;
                work.pixels = pixels;
                work.shaded_px = pixels * (triangles < 1e3 ? 0.01 : 0.8);
                work.textured_px = vertices_share > 1.0 ? work.shaded_px : 0.0;
                work.extent_px = 1.4 * std::sqrt(triangles * work.shaded_px);
                out.push_back({work, control::frame_ms(costs, work) * std::exp(noise * random.normal())});
            }
    return out;
}

TEST(FrameCosts, AreFoundInPicturesThatKeepToThem) {
    const control::FrameCosts costs = some_costs();
    const control::FrameCosts found = fit_costs(pictures(costs, 0.0));
    EXPECT_NEAR(found.fixed_ms, costs.fixed_ms, 1e-3);
    EXPECT_NEAR(found.per_million_triangles_ms, costs.per_million_triangles_ms, 0.1);
    EXPECT_NEAR(found.per_million_vertices_ms, costs.per_million_vertices_ms, 0.1);
    EXPECT_NEAR(found.per_million_pixels_ms, costs.per_million_pixels_ms, 1e-2);
    EXPECT_NEAR(found.per_million_shaded_ms, costs.per_million_shaded_ms, 1e-2);
    EXPECT_NEAR(found.per_million_textured_ms, costs.per_million_textured_ms, 1e-2);
    EXPECT_NEAR(found.per_million_extent_ms, costs.per_million_extent_ms, 0.1);
}

TEST(FrameCosts, PredictThroughNoise) {
    const control::FrameCosts costs = some_costs(), found = fit_costs(pictures(costs, 0.03));
    for (const TimedPicture& picture : pictures(costs, 0.0))
        EXPECT_NEAR(control::frame_ms(found, picture.work) / picture.ms, 1.0, 0.08);
}

TEST(FrameCosts, AreNeverBelowZeroAndFiniteForAnyTimes) {
    Random random(9);
    for (int round = 0; round < 50; ++round) {
        std::vector<TimedPicture> any = pictures(some_costs(), 0.0);
        for (TimedPicture& picture : any) picture.ms = random.log_uniform(1e-6, 1e6);
        const control::FrameCosts found = fit_costs(any);
        for (const double cost : {found.fixed_ms, found.per_million_triangles_ms, found.per_million_vertices_ms,
                                  found.per_million_pixels_ms, found.per_million_shaded_ms,
                                  found.per_million_textured_ms, found.per_million_extent_ms}) {
            EXPECT_TRUE(std::isfinite(cost));
            EXPECT_GE(cost, 0.0);
        }
    }
    EXPECT_EQ(fit_costs({}).per_million_triangles_ms, 0.0);
}

TEST(FrameCosts, WhatNoPictureHasCostsNothing) {
    control::FrameCosts costs = some_costs();
    costs.per_million_vertices_ms = 0.0;
    std::vector<TimedPicture> without = pictures(costs, 0.0);
    for (TimedPicture& picture : without) picture.work.vertices = 0.0;
    EXPECT_EQ(fit_costs(without).per_million_vertices_ms, 0.0);
    EXPECT_NEAR(fit_costs(without).per_million_triangles_ms, 80.0, 0.1);
}

TEST(FrameCosts, AHybridLevelsWorkIsThatOfBothItsPrimitives) {
    codec::Decoded content;
    for (const codec::Shading shading : {codec::Shading::gouraud, codec::Shading::flat}) {
        codec::Primitive primitive;
        primitive.shading = shading;
        primitive.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
        primitive.mesh.triangles = {{0, 1, 2}};
        if (shading == codec::Shading::flat) primitive.mesh.triangles.push_back({1, 3, 2});
        primitive.material = shading == codec::Shading::flat ? 1 : 0;
        content.primitives.push_back(primitive);
    }
    content.materials.resize(2);
    content.materials[1].base_color_texture.image = 0;
    content.origin = {100, 0, 0};
    const shading::View view{{100, 0, 1}, {100, 0, 0}, 90.0, {0, 1, 0}};
    const control::Work work = work_of(content, view, {400, 400});
    EXPECT_EQ(work.triangles, 3.0);
    EXPECT_EQ(work.vertices, 4.0 + 2.0);
    EXPECT_EQ(work.pixels, 160'000.0);
    EXPECT_NEAR(work.shaded_px, 3.0 * 0.5 * 200 * 200, 1e-3);
    EXPECT_NEAR(work.textured_px, 2.0 * 0.5 * 200 * 200, 1e-3);
    EXPECT_NEAR(work.extent_px, 3.0 * 200, 1e-3);
}

}  // namespace
}  // namespace lodestream::probe
