#include "common/points/pictures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/mesh/operations.h"
#include "common/points/level.h"
#include "common/points/order.h"
#include "common/points/resample.h"
#include "tests/support/meshes.h"

namespace lodestream::points {
namespace {

struct Level {
    OrderedCloud ordered;
    std::vector<points::Level> levels;

    Discs discs(std::uint64_t count) const { return {ordered.cloud, count, level_of(levels, count).radius}; }
};

Level points_of(const mesh::Mesh& mesh, std::uint64_t count) {
    Level level{order(resample(mesh, choose_parameters(mesh, count)), count), {}};
    level.levels = measured_levels(metric::SurfaceIndex(mesh, 100), mesh, level.ordered);
    return level;
}

mesh::Mesh scaled(mesh::Mesh mesh, float factor) {
    for (Vec3f& p : mesh.positions) p *= factor;
    return mesh;
}

TEST(Pictures, TheModelItselfIsOffByNothing) {
    const mesh::Mesh sphere = testing::sphere(40);
    EXPECT_EQ(Pictures({sphere}).error(Surface{sphere}), 0.0);
}

TEST(Pictures, FinerLevelsAreNearer) {
    const mesh::Mesh sphere = testing::sphere(90);
    const Pictures pictures({sphere});
    const Level cloud = points_of(sphere, 8000);
    double before = 1.0;
    for (const std::uint64_t count : {30u, 120u, 500u, 2000u, 8000u}) {
        const double error = pictures.error(cloud.discs(count));
        EXPECT_LT(error, before) << count;
        before = error;
    }
    EXPECT_LT(before, 0.05);
    EXPECT_LT(pictures.error(Surface{testing::sphere(30)}), pictures.error(Surface{testing::sphere(12)}));
}

TEST(Pictures, SmoothTrianglesShowLessOfTheirErrorThanFlatOnes) {
    const mesh::Mesh sphere = testing::sphere(90), coarse = testing::sphere(20);
    const Pictures pictures({sphere});
    EXPECT_LT(pictures.error(Surface{coarse}), pictures.error(Surface{coarse, {}, true}));
}

TEST(Pictures, NothingIsAsFarOffAsTheModelIsFromTheBackground) {
    const mesh::Mesh sphere = testing::sphere(40), nothing;
    const double error = Pictures({sphere}).error(Surface{nothing});
    EXPECT_GT(error, 0.1);
    EXPECT_LT(error, 1.0);
    EXPECT_EQ(Pictures({sphere}).error(Discs{{}, 10, 1.0}), error);
    EXPECT_EQ(Pictures({nothing}).error(Surface{sphere}), 0.0);
}

TEST(Pictures, ColoursCount) {
    const mesh::Mesh sphere = testing::sphere(40);
    const ColorAt red = [](std::size_t, const Vec3f&) { return Rgba8(255, 0, 0, 255); };
    const ColorAt blue = [](std::size_t, const Vec3f&) { return Rgba8(0, 0, 255, 255); };
    const Pictures pictures({sphere, red});
    EXPECT_EQ(pictures.error(Surface{sphere, red}), 0.0);
    EXPECT_GT(pictures.error(Surface{sphere, blue}), 0.3);
}

TEST(Pictures, SizesAndPlacesOfModelsChangeNothing) {
    const mesh::Mesh sphere = testing::sphere(60), coarse = testing::sphere(12);
    const double expected = Pictures({sphere}).error(Surface{coarse});
    for (const float factor : {1e-9f, 1e9f}) {
        const double error = Pictures({scaled(sphere, factor)}).error(Surface{scaled(coarse, factor)});
        EXPECT_NEAR(error, expected, 1e-3) << factor;
    }
}

TEST(Pictures, WhatHasNoAreaOrNoExtentIsFinite) {
    mesh::Mesh needle;
    needle.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    needle.triangles = {{0, 1, 2}};
    mesh::Mesh speck = needle;
    for (Vec3f& p : speck.positions) p = Vec3f(5.0f);
    for (const mesh::Mesh* mesh : {&needle, &speck}) {
        const Pictures pictures({*mesh});
        EXPECT_TRUE(std::isfinite(pictures.error(Surface{testing::sphere(8)})));
        EXPECT_TRUE(std::isfinite(pictures.error(Discs{{{Vec3f(0.0f)}, {Vec3f(0.0f)}, {}}, 1, 0.0})));
    }
}

TEST(Pictures, AreTheSameForEveryExecutor) {
    const mesh::Mesh sphere = testing::sphere(40), coarse = testing::sphere(12);
    const simplify::Executor backwards = [](std::size_t count, const std::function<void(std::size_t)>& task) {
        for (std::size_t k = count; k-- > 0;) task(k);
    };
    EXPECT_EQ(Pictures({sphere}, backwards).error(Surface{coarse}), Pictures({sphere}).error(Surface{coarse}));
}

}  // namespace
}  // namespace lodestream::points
