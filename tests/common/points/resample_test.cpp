#include "common/points/resample.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "common/points/view.h"
#include "tests/support/meshes.h"
#include "tests/support/threads.h"

#include <gtest/gtest.h>

namespace lodestream::points {
namespace {

PointCloud resampled(const mesh::Mesh& mesh, std::uint64_t budget, const ResampleOptions& options = {}) {
    return resample(mesh, choose_parameters(mesh, budget), options);
}

void expect_sound(const PointCloud& cloud) {
    ASSERT_EQ(cloud.normals.size(), cloud.positions.size());
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
        ASSERT_TRUE(all_finite(cloud.positions[i]));
        ASSERT_NEAR(glm::length(Vec3d(cloud.normals[i])), 1.0, 1e-4);
    }
}

// The farthest that a point lies from the surface, as a share of the mesh's diagonal.
double farthest(const mesh::Mesh& mesh, const PointCloud& cloud) {
    const metric::SurfaceIndex index(mesh);
    double far = 0.0;
    for (const Vec3f& p : cloud.positions) far = std::max(far, index.distance(Vec3d(p)));
    return far / mesh::bounds(mesh).diagonal();
}

mesh::Mesh scaled(mesh::Mesh mesh, float factor) {
    for (Vec3f& p : mesh.positions) p *= factor;
    return mesh;
}

TEST(Resample, EmptyMeshGivesNoPoints) {
    EXPECT_TRUE(resampled({}, 1000).positions.empty());
    EXPECT_EQ(choose_parameters({}, 1000).side, 1u);
}

TEST(Resample, BudgetOfZeroStillHasParameters) {
    const Parameters parameters = choose_parameters(testing::tetrahedron(), 0);
    EXPECT_EQ(parameters.side, 1u);
    EXPECT_FALSE(resample(testing::tetrahedron(), parameters).positions.empty());
}

TEST(Resample, OneTriangle) {
    const mesh::Mesh mesh = testing::single_triangle();
    const PointCloud cloud = resampled(mesh, 1000);
    expect_sound(cloud);
    EXPECT_NEAR(static_cast<double>(cloud.positions.size()), 1000 * oversampling, 300);
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
        EXPECT_EQ(cloud.positions[i].z, 0.0f);
        EXPECT_EQ(cloud.normals[i], Vec3f(0, 0, 1));
    }
}

// A plane lies in the line of sight of two of the three axes; the third alone must see it whole.
TEST(Resample, PlaneSeenEdgeOn) {
    const mesh::Mesh mesh = testing::flat_grid(4);
    const PointCloud cloud = resampled(mesh, 1000);
    expect_sound(cloud);
    EXPECT_NEAR(static_cast<double>(cloud.positions.size()), 1000 * oversampling, 300);
    for (const Vec3f& p : cloud.positions) EXPECT_EQ(p.y, 0.0f);
}

TEST(Resample, NeedleFallsBetweenPixelsAndIsKept) {
    mesh::Mesh mesh = testing::tetrahedron();
    for (Vec3f& p : mesh.positions) p *= Vec3f(1e-6f, 1.0f, 1e-6f);
    const PointCloud cloud = resampled(mesh, 1000);
    expect_sound(cloud);
    EXPECT_FALSE(cloud.positions.empty());
    EXPECT_LT(farthest(mesh, cloud), 1e-3);
}

TEST(Resample, SpecksSmallerThanAPixelAreDrawnAsPoints) {
    mesh::Mesh mesh = testing::flat_grid(1);
    for (const float x : {0.2f, 0.5f, 0.8f}) {
        mesh::Mesh speck = scaled(testing::tetrahedron(), 1e-5f);
        for (Vec3f& p : speck.positions) p += Vec3f(x, 0.5f, 0.5f);
        mesh::append(mesh, speck);
    }
    const PointCloud cloud = resample(mesh, {16, 16});
    for (const float x : {0.2f, 0.5f, 0.8f})
        EXPECT_TRUE(std::any_of(cloud.positions.begin(), cloud.positions.end(), [&](const Vec3f& p) {
            return std::abs(p.x - x) < 1e-3f && std::abs(p.y - 0.5f) < 1e-3f;
        }));
}

TEST(Resample, ZeroAreaTriangles) {
    mesh::Mesh mesh = testing::single_triangle();
    mesh.positions[2] = {0.5f, 0, 0};
    const PointCloud cloud = resampled(mesh, 100);
    expect_sound(cloud);
    EXPECT_EQ(cloud.positions.size(), 1u);
}

TEST(Resample, AllCornersInOnePlace) {
    mesh::Mesh mesh = testing::single_triangle();
    mesh.positions.assign(3, Vec3f(5, 5, 5));
    const PointCloud cloud = resampled(mesh, 100);
    expect_sound(cloud);
    EXPECT_EQ(cloud.positions, std::vector<Vec3f>{Vec3f(5, 5, 5)});
}

TEST(Resample, HugeAndTinyModelsGiveTheSamePoints) {
    const mesh::Mesh mesh = testing::sphere(24);
    const PointCloud same = resampled(mesh, 2000);
    for (const float factor : {0x1p30f, 0x1p-30f}) {
        const PointCloud other = resampled(scaled(mesh, factor), 2000);
        ASSERT_EQ(other.positions.size(), same.positions.size());
        for (std::size_t i = 0; i < same.positions.size(); ++i)
            ASSERT_EQ(other.positions[i], same.positions[i] * factor) << i;
    }
    for (const float factor : {1e9f, 1e-9f}) {
        const mesh::Mesh other = scaled(mesh, factor);
        EXPECT_LT(farthest(other, resampled(other, 2000)), 1e-3);
    }
}

TEST(Resample, PointsLieOnTheSurfaceAndCoverIt) {
    const mesh::Mesh mesh = testing::sphere(40);
    const PointCloud cloud = resampled(mesh, 20'000);
    expect_sound(cloud);
    EXPECT_NEAR(static_cast<double>(cloud.positions.size()), 20'000 * oversampling, 15'000);
    EXPECT_LT(farthest(mesh, cloud), 2.0 / choose_parameters(mesh, 20'000).side);
    for (std::size_t i = 0; i < cloud.positions.size(); ++i)
        ASSERT_GT(dot(cloud.positions[i], cloud.normals[i]), 0.98f);
}

TEST(Resample, HiddenInsideIsLeftOut) {
    mesh::Mesh mesh = testing::sphere(32);
    mesh::append(mesh, scaled(testing::sphere(32), 0.5f));
    for (const Vec3f& p : resampled(mesh, 50'000).positions) ASSERT_GT(glm::length(p), 0.9f);
}

TEST(Resample, AnOpeningLetsTheInsideBeSeen) {
    mesh::Mesh mesh = testing::sphere(32);
    std::erase_if(mesh.triangles, [&](const mesh::Triangle& t) { return mesh.positions[t[0]].y > 0.9f; });
    mesh::append(mesh, scaled(testing::sphere(32), 0.5f));
    const PointCloud cloud = resampled(mesh, 50'000);
    EXPECT_TRUE(std::any_of(cloud.positions.begin(), cloud.positions.end(),
                            [](const Vec3f& p) { return glm::length(p) < 0.6f; }));
}

TEST(Resample, SlicesReachBothEnds) {
    mesh::Mesh mesh;  // a stair of squares, one above the other
    for (int step = 0; step < 8; ++step) {
        mesh::Mesh square = testing::flat_grid(1);
        for (Vec3f& p : square.positions) p.y = static_cast<float>(step) / 7.0f;
        mesh::append(mesh, square);
    }
    for (const std::uint32_t slices : {1u, 2u, 8u, 64u}) {
        const PointCloud cloud = resample(mesh, {slices, 32});
        std::vector<int> points(8, 0);
        for (const Vec3f& p : cloud.positions) ++points[static_cast<std::size_t>(std::lround(p.y * 7.0f))];
        EXPECT_GT(points.front(), 900) << slices;
        EXPECT_GT(points.back(), 900) << slices;
        const auto seen = std::count_if(points.begin(), points.end(), [](int n) { return n > 900; });
        EXPECT_EQ(seen, slices == 1 ? 2 : slices == 2 ? 4 : 8) << slices;
    }
}

TEST(Resample, ColorsAndTheCallersColorsAreCarried) {
    mesh::Mesh mesh = testing::single_triangle();
    mesh.colors = {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}};
    const PointCloud own = resampled(mesh, 500);
    ASSERT_EQ(own.colors.size(), own.positions.size());
    for (std::size_t i = 0; i < own.colors.size(); ++i) ASSERT_NEAR(own.colors[i].g, 255 * own.positions[i].x, 1.5);
    ResampleOptions options;
    options.color = [](std::size_t, const Vec3f& w) { return Rgba8(0, 0, 0, static_cast<std::uint8_t>(200 * w.x)); };
    for (const Rgba8& color : resampled(mesh, 500, options).colors) ASSERT_EQ(color.r, 0);
}

TEST(Resample, ThreadsChangeNothing) {
    const mesh::Mesh mesh = testing::sphere(300);  // several runs of triangles
    ResampleOptions threaded;
    threaded.executor = testing::on_threads;
    const PointCloud alone = resampled(mesh, 20'000), together = resampled(mesh, 20'000, threaded);
    EXPECT_EQ(alone.positions, together.positions);
    EXPECT_EQ(alone.normals, together.normals);
}

TEST(Resample, ParametersFollowBudgetAndPixels) {
    const mesh::Mesh mesh = testing::sphere(24);
    EXPECT_LT(choose_parameters(mesh, 1000).side, choose_parameters(mesh, 10'000).side);
    EXPECT_EQ(choose_parameters(mesh, 1'000'000, 20).side, 40u);
    EXPECT_LE(choose_parameters(mesh, ~0ull).side, max_side);
}

// One layer of hits with the middle pixel missing.
std::vector<Hit> with_a_hole() {
    std::vector<Hit> hits;
    for (std::uint32_t pixel = 0; pixel < 25; ++pixel)
        if (pixel != 12) hits.push_back({pixel, 3.0f, pixel});
    return hits;
}

TEST(View, FiltersCloseAHole) {
    const ViewSize size{5, 5, 1.0};
    const auto holes_closed = [&](HoleFilter filter) {
        const std::vector<Sample> samples = sampled(with_a_hole(), size, filter);
        return std::count_if(samples.begin(), samples.end(), [](const Sample& s) {
            return s.fills_a_hole && s.hit.pixel == 12 && s.hit.depth == 3.0f;
        });
    };
    EXPECT_EQ(holes_closed(HoleFilter::none), 0);
    EXPECT_EQ(holes_closed(HoleFilter::median), 1);
    EXPECT_EQ(holes_closed(HoleFilter::gaussian), 1);
    EXPECT_EQ(holes_closed(HoleFilter::opposites), 1);
}

TEST(View, OppositesCloseACrackBetweenThinSidesThatTheMedianLeavesOpen) {
    const std::vector<Hit> sides{{11, 3.0f, 0}, {13, 3.5f, 1}};
    const auto closed_at = [&](HoleFilter filter) {
        std::vector<float> depths;
        for (const Sample& sample : sampled(sides, {5, 5, 1.0}, filter))
            if (sample.fills_a_hole) depths.push_back(sample.hit.depth);
        return depths;
    };
    EXPECT_EQ(closed_at(HoleFilter::median), std::vector<float>{});
    EXPECT_EQ(closed_at(HoleFilter::opposites), std::vector<float>{3.25f});
}

TEST(View, FiltersKeepAWindowOpen) {
    std::vector<Hit> hits = with_a_hole();
    std::erase_if(hits, [](const Hit& hit) {  // 3 x 3 pixels
        const std::uint32_t x = hit.pixel % 5, y = hit.pixel / 5;
        return x >= 1 && x <= 3 && y >= 1 && y <= 3;
    });
    for (const HoleFilter filter : {HoleFilter::median, HoleFilter::gaussian, HoleFilter::opposites})
        for (const Sample& sample : sampled(hits, {5, 5, 1.0}, filter)) EXPECT_NE(sample.hit.pixel, 12u);
}

// A scene of millions of triangles seen small: hours, if every hit were compared with all beside it.
TEST(View, AHoleAmongCrowdedPixelsIsClosedAtEveryDepthOnce) {
    constexpr std::uint32_t crowd = 100'000;
    constexpr double depth = 50.0;
    std::vector<Hit> hits;
    for (std::uint32_t pixel = 0; pixel < 25; ++pixel)
        for (std::uint32_t k = 0; pixel != 12 && k < crowd; ++k)
            hits.push_back({pixel, static_cast<float>(depth * k / crowd), k});
    std::vector<float> filled;
    for (const Sample& sample : sampled(std::move(hits), {5, 5, 1.0}, HoleFilter::median))
        if (sample.fills_a_hole) filled.push_back(sample.hit.depth);
    ASSERT_FALSE(filled.empty());
    EXPECT_LE(filled.size(), static_cast<std::size_t>(depth) + 1);
    for (double d = 0.0; d < depth; d += 0.1)
        EXPECT_TRUE(std::any_of(filled.begin(), filled.end(), [&](float f) { return std::abs(f - d) <= 1.0; })) << d;
}

}  // namespace
}  // namespace lodestream::points
