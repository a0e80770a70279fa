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

ScreenExtent screen_extent(const mesh::Mesh& mesh, const Vec3d& origin, const View& view, const budget::Display& on) {
    return ScreenExtents(view, on).draw(mesh, origin);
}

TEST(ScreenExtent, IsATrianglesAreaAndTheSideOfItsRectangle) {
    const mesh::Mesh mesh = one_triangle({0, 0, -1}, {0.9f, 0, -1}, {0, 0.4f, -1});
    const ScreenExtent extent = screen_extent(mesh, {}, from_origin(), display);
    EXPECT_NEAR(extent.shaded_px, 0.5 * 90 * 40, 1e-3);
    EXPECT_NEAR(extent.extent_px, 60.0, 1e-3);
}

TEST(ScreenExtent, FallsWithTheDistance) {
    mesh::Mesh mesh = one_triangle({0, 0, 0}, {0.9f, 0, 0}, {0, 0.4f, 0});
    const ScreenExtent near = screen_extent(mesh, {0, 0, -1}, from_origin(), display);
    const ScreenExtent far = screen_extent(mesh, {0, 0, -10}, from_origin(), display);
    EXPECT_NEAR(far.shaded_px / near.shaded_px, 0.01, 1e-9);
    EXPECT_NEAR(far.extent_px / near.extent_px, 0.1, 1e-9);
}

TEST(ScreenExtent, OutsideOfThePictureNothingCounts) {
    const mesh::Mesh aside = one_triangle({3, 0, -1}, {4, 0, -1}, {3, 1, -1});
    EXPECT_EQ(screen_extent(aside, {}, from_origin(), display).shaded_px, 0.0);
    EXPECT_EQ(screen_extent(aside, {}, from_origin(), display).extent_px, 0.0);
    // Its rectangle is 16 times the picture.
    const mesh::Mesh larger = one_triangle({-8, -4, -1}, {8, -4, -1}, {0, 4, -1});
    const ScreenExtent extent = screen_extent(larger, {}, from_origin(), display);
    EXPECT_NEAR(extent.shaded_px, 0.5 * 400 * 200, 1e-2);
    EXPECT_NEAR(extent.extent_px, std::sqrt(400.0 * 200.0), 1e-3);
}

TEST(ScreenExtent, BehindTheEyeNothingCountsAndAcrossItStaysFinite) {
    const mesh::Mesh behind = one_triangle({0, 0, 1}, {1, 0, 1}, {0, 1, 1});
    EXPECT_EQ(screen_extent(behind, {}, from_origin(), display).extent_px, 0.0);
    const mesh::Mesh across = one_triangle({-1, 0, -1}, {1, 0.5f, -1}, {0, 0, 1});
    const ScreenExtent extent = screen_extent(across, {}, from_origin(), display);
    EXPECT_GT(extent.shaded_px, 0.0);
    EXPECT_LE(extent.shaded_px, 400.0 * 200.0);
    for (const float huge : {1e-30f, 1e30f}) {
        const mesh::Mesh mesh = one_triangle({0, 0, -huge}, {huge, 0, -huge}, {0, huge, -huge});
        EXPECT_TRUE(std::isfinite(screen_extent(mesh, {}, from_origin(), display).shaded_px));
        EXPECT_TRUE(std::isfinite(screen_extent(mesh, {}, from_origin(), display).extent_px));
    }
}

TEST(ScreenExtent, OfNothingIsNothingAndLookingStraightDownIsAView) {
    EXPECT_EQ(screen_extent({}, {}, from_origin(), display).shaded_px, 0.0);
    const View down{{0, 1, 0}, {0, 0, 0}, 90.0, {0, 1, 0}};
    const mesh::Mesh floor = one_triangle({0, 0, 0}, {0.9f, 0, 0}, {0, 0, 0.4f});
    EXPECT_NEAR(screen_extent(floor, {}, down, display).shaded_px, 0.5 * 90 * 40, 1e-3);
}

// Two squares of 100 px a side at distance 1 and 2, the farther twice as large: both fill the same pixels.
mesh::Mesh square_at(float distance) {
    mesh::Mesh mesh;
    const float half = 0.5f * distance;
    mesh.positions = {
        {-half, -half, -distance}, {half, -half, -distance}, {half, half, -distance}, {-half, half, -distance}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

TEST(ScreenExtent, WhatIsDrawnBehindWhatIsThereIsNotShadedAndInFrontItIs) {
    ScreenExtents front_to_back(from_origin(), display), back_to_front(from_origin(), display);
    EXPECT_NEAR(front_to_back.draw(square_at(1.0f), {}).shaded_px, 1e4, 1.0);
    const ScreenExtent hidden = front_to_back.draw(square_at(2.0f), {});
    EXPECT_NEAR(hidden.extent_px, 200.0, 1e-3);
    EXPECT_EQ(hidden.shaded_px, 0.0);
    EXPECT_NEAR(back_to_front.draw(square_at(2.0f), {}).shaded_px, 1e4, 1.0);
    EXPECT_NEAR(back_to_front.draw(square_at(1.0f), {}).shaded_px, 1e4, 1.0);
}

TEST(ScreenExtent, ATiltedTriangleHidesWhereItIsNearer) {
    // Cuts through a square at distance 1 along its middle.
    mesh::Mesh tilted = square_at(1.0f);
    tilted.positions = {{-0.4f, -0.5f, -0.8f}, {0.6f, -0.5f, -1.2f}, {0.6f, 0.5f, -1.2f}, {-0.4f, 0.5f, -0.8f}};
    ScreenExtents extents(from_origin(), display);
    extents.draw(square_at(1.0f), {});
    const ScreenExtent extent = extents.draw(tilted, {});
    const double alone_px = screen_extent(tilted, {}, from_origin(), display).shaded_px;
    EXPECT_GT(extent.shaded_px, 0.4 * alone_px);
    EXPECT_LT(extent.shaded_px, 0.7 * alone_px);
}

// Triangles far smaller than a sample's cell meet one by chance: the share is that of all of them.
TEST(ScreenExtent, SharesOfSmallTrianglesAreThoseOfLargeOnes) {
    const auto grid = [](float distance) {
        constexpr std::uint32_t cells = 200;
        mesh::Mesh mesh;
        for (std::uint32_t y = 0; y <= cells; ++y)
            for (std::uint32_t x = 0; x <= cells; ++x)
                mesh.positions.push_back({distance * (static_cast<float>(x) / cells - 0.5f),
                                          distance * (static_cast<float>(y) / cells - 0.5f), -distance});
        for (std::uint32_t y = 0; y < cells; ++y)
            for (std::uint32_t x = 0; x < cells; ++x) {
                const std::uint32_t a = y * (cells + 1) + x, b = a + cells + 1;
                mesh.triangles.push_back({a, a + 1, b + 1});
                mesh.triangles.push_back({a, b + 1, b});
            }
        return mesh;
    };
    ScreenExtents extents(from_origin(), display);
    EXPECT_NEAR(extents.draw(grid(2.0f), {}).shaded_px, 1e4, 200.0);
    EXPECT_NEAR(extents.draw(grid(1.0f), {}).shaded_px, 1e4, 200.0);
    EXPECT_LT(extents.draw(grid(1.5f), {}).shaded_px, 100.0);
}

TEST(ScreenExtent, NoPictureAndAHugeOneStayFinite) {
    for (const budget::Display& on :
         {budget::Display{0, 0}, {1, 1}, {16'384, 16'384}, {1, 4'000'000'000}, {4'000'000'000, 4'000'000'000}}) {
        const ScreenExtent extent = screen_extent(square_at(1.0f), {}, from_origin(), on);
        EXPECT_TRUE(std::isfinite(extent.shaded_px));
        EXPECT_GE(extent.shaded_px, 0.0);
    }
}

}  // namespace
}  // namespace lodestream::shading
