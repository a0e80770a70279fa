#include "common/shading/screen_extent.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lodestream::shading {
namespace {

constexpr budget::Display display{400, 200};

// At distance 1 a unit measures 100 px.
View from_origin() {
    return {{0, 0, 0}, {0, 0, -1}, 90.0, {0, 1, 0}};
}

mesh::Mesh one_triangle(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    mesh::Mesh mesh;
    mesh.positions = {a, b, c};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

TEST(ScreenExtent, IsATrianglesAreaAndTheSideOfItsRectangle) {
    const mesh::Mesh mesh = one_triangle({0, 0, -1}, {0.9f, 0, -1}, {0, 0.4f, -1});
    const ScreenExtent extent = screen_extent(mesh, {}, from_origin(), display);
    EXPECT_NEAR(extent.covered_px, 0.5 * 90 * 40, 1e-3);
    EXPECT_NEAR(extent.extent_px, 60.0, 1e-3);
}

TEST(ScreenExtent, FallsWithTheDistance) {
    mesh::Mesh mesh = one_triangle({0, 0, 0}, {0.9f, 0, 0}, {0, 0.4f, 0});
    const ScreenExtent near = screen_extent(mesh, {0, 0, -1}, from_origin(), display);
    const ScreenExtent far = screen_extent(mesh, {0, 0, -10}, from_origin(), display);
    EXPECT_NEAR(far.covered_px / near.covered_px, 0.01, 1e-9);
    EXPECT_NEAR(far.extent_px / near.extent_px, 0.1, 1e-9);
}

TEST(ScreenExtent, OutsideOfThePictureNothingCounts) {
    const mesh::Mesh aside = one_triangle({3, 0, -1}, {4, 0, -1}, {3, 1, -1});
    EXPECT_EQ(screen_extent(aside, {}, from_origin(), display).covered_px, 0.0);
    EXPECT_EQ(screen_extent(aside, {}, from_origin(), display).extent_px, 0.0);
    // Its rectangle is 16 times the picture.
    const mesh::Mesh larger = one_triangle({-8, -4, -1}, {8, -4, -1}, {0, 4, -1});
    const ScreenExtent extent = screen_extent(larger, {}, from_origin(), display);
    EXPECT_NEAR(extent.covered_px, 0.5 * 400 * 200, 1e-2);
    EXPECT_NEAR(extent.extent_px, std::sqrt(400.0 * 200.0), 1e-3);
}

TEST(ScreenExtent, BehindTheEyeNothingCountsAndAcrossItStaysFinite) {
    const mesh::Mesh behind = one_triangle({0, 0, 1}, {1, 0, 1}, {0, 1, 1});
    EXPECT_EQ(screen_extent(behind, {}, from_origin(), display).extent_px, 0.0);
    const mesh::Mesh across = one_triangle({-1, 0, -1}, {1, 0.5f, -1}, {0, 0, 1});
    const ScreenExtent extent = screen_extent(across, {}, from_origin(), display);
    EXPECT_GT(extent.covered_px, 0.0);
    EXPECT_LE(extent.covered_px, 400.0 * 200.0);
    for (const float huge : {1e-30f, 1e30f}) {
        const mesh::Mesh mesh = one_triangle({0, 0, -huge}, {huge, 0, -huge}, {0, huge, -huge});
        EXPECT_TRUE(std::isfinite(screen_extent(mesh, {}, from_origin(), display).covered_px));
        EXPECT_TRUE(std::isfinite(screen_extent(mesh, {}, from_origin(), display).extent_px));
    }
}

TEST(ScreenExtent, OfNothingIsNothingAndLookingStraightDownIsAView) {
    EXPECT_EQ(screen_extent({}, {}, from_origin(), display).covered_px, 0.0);
    const View down{{0, 1, 0}, {0, 0, 0}, 90.0, {0, 1, 0}};
    const mesh::Mesh floor = one_triangle({0, 0, 0}, {0.9f, 0, 0}, {0, 0, 0.4f});
    EXPECT_NEAR(screen_extent(floor, {}, down, display).covered_px, 0.5 * 90 * 40, 1e-3);
}

}  // namespace
}  // namespace lodestream::shading
