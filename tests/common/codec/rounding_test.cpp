#include "common/codec/rounding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/mesh/operations.h"
#include "tests/support/meshes.h"

namespace lodestream::codec {
namespace {

QuantizationGrid grid_around(const mesh::Mesh& mesh, int bits) {
    QuantizationGrid grid = choose_grid(mesh::bounds(mesh), 0.0, 0.0);
    grid.bits = bits;
    return grid;
}

Vec3d coordinates(const Vec3f& p, const QuantizationGrid& grid) {
    return (Vec3d(p) - Vec3d(grid.origin)) / grid.step();
}

double farthest_axis(const Vec3d& d) {
    return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
}

// A square of size 1 that leans, of `side` squares a side.
mesh::Mesh sheet(int side) {
    mesh::Mesh mesh;
    for (int y = 0; y <= side; ++y)
        for (int x = 0; x <= side; ++x) {
            const double u = double(x) / side, v = double(y) / side;
            mesh.positions.emplace_back(u, 0.3719 * u + 0.2113 * v, v);
        }
    const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (side + 1) + x); };
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            mesh.triangles.push_back({at(x, y), at(x, y + 1), at(x + 1, y)});
            mesh.triangles.push_back({at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)});
        }
    return mesh;
}

TEST(SurfaceRounding, LeavesASmoothSurfaceByLessThanHalfOfWhatTheNearestPointsDo) {
    const mesh::Mesh sphere = testing::sphere(48);
    const SurfaceRounding surface(sphere.positions, sphere.triangles);
    for (const int bits : {9, 11, 13}) {
        const QuantizationGrid grid = grid_around(sphere, bits);
        EXPECT_LT(surface.round(grid).off_surface_rms, 0.5 * 0.289 * grid.step()) << bits;
    }
}

TEST(SurfaceRounding, GoesAStepAndAHalfAtMostAndStaysOnTheGrid) {
    const mesh::Mesh sphere = testing::sphere(24);
    const QuantizationGrid grid = grid_around(sphere, 8);
    const std::vector<Vec3d> points = SurfaceRounding(sphere.positions, sphere.triangles).round(grid).points;
    ASSERT_EQ(points.size(), sphere.positions.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
        EXPECT_LE(farthest_axis(points[v] - coordinates(sphere.positions[v], grid)), 1.5 + 1e-6);
        EXPECT_EQ(points[v], glm::floor(points[v]));
        EXPECT_GE(std::min({points[v].x, points[v].y, points[v].z}), 0.0);
        EXPECT_LE(farthest_axis(points[v]), 255.0);
    }
}

TEST(SurfaceRounding, BordersGoToTheNearestPointWhateverLiesBesideThem) {
    const mesh::Mesh mesh = sheet(16);
    const QuantizationGrid grid = grid_around(mesh, 7);
    const std::vector<Vec3d> points = SurfaceRounding(mesh.positions, mesh.triangles).round(grid).points;
    int inner_moved = 0;
    for (int y = 0; y <= 16; ++y)
        for (int x = 0; x <= 16; ++x) {
            const std::size_t v = static_cast<std::size_t>(y * 17 + x);
            const bool is_nearest = points[v] == nearest_grid_point(mesh.positions[v], grid);
            const bool is_border = x == 0 || y == 0 || x == 16 || y == 16;
            EXPECT_TRUE(is_nearest || !is_border);
            inner_moved += !is_border && !is_nearest;
        }
    EXPECT_GT(inner_moved, 30);
}

TEST(SurfaceRounding, VerticesOfOnePositionStayTogether) {
    mesh::Mesh mesh = testing::sphere(16);
    const std::size_t vertices = mesh.positions.size();
    for (std::size_t v = 0; v < vertices; ++v) mesh.positions.push_back(mesh.positions[v]);
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 2)
        for (std::uint32_t& v : mesh.triangles[t]) v += static_cast<std::uint32_t>(vertices);
    const std::vector<Vec3d> points =
        SurfaceRounding(mesh.positions, mesh.triangles).round(grid_around(mesh, 8)).points;
    for (std::size_t v = 0; v < vertices; ++v) EXPECT_EQ(points[v], points[v + vertices]);
}

TEST(SurfaceRounding, TurnsNoTriangleAroundThatTheNearestPointsWouldNot) {
    const mesh::Mesh sphere = testing::sphere(64);
    for (const int bits : {6, 7, 8}) {
        const QuantizationGrid grid = grid_around(sphere, bits);
        const std::vector<Vec3d> points = SurfaceRounding(sphere.positions, sphere.triangles).round(grid).points;
        for (const mesh::Triangle& t : sphere.triangles) {
            const auto faces = [&](const auto& at) {
                const Vec3d outside(sphere.positions[t[0]] + sphere.positions[t[1]] + sphere.positions[t[2]]);
                return dot(cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0])), outside);
            };
            const auto nearest = [&](std::uint32_t v) { return nearest_grid_point(sphere.positions[v], grid); };
            const auto rounded = [&](std::uint32_t v) { return points[v]; };
            EXPECT_TRUE(faces(rounded) >= 0.0 || faces(nearest) <= 0.0);
        }
    }
}

TEST(SurfaceRounding, DegenerateAndExtremeInputStaysFinite) {
    for (const float scale : {1e-30f, 1.0f, 1e30f}) {
        mesh::Mesh mesh = testing::sphere(6);
        for (Vec3f& p : mesh.positions) p *= scale;
        mesh.triangles.push_back({0, 0, 1});
        mesh.triangles.push_back(mesh.triangles[3]);
        mesh.positions.emplace_back(std::numeric_limits<float>::quiet_NaN());  // that no triangle uses
        const Rounded rounded = SurfaceRounding(mesh.positions, mesh.triangles).round(grid_around(mesh, 10));
        EXPECT_TRUE(std::isfinite(rounded.off_surface_rms));
        for (std::size_t v = 0; v + 1 < mesh.positions.size(); ++v) EXPECT_TRUE(all_finite(rounded.points[v]));
    }
    EXPECT_EQ(SurfaceRounding({}, {}).round({}).off_surface_rms, 0.0);
}

// Of levels whose surface says nothing of how well they are shown.
constexpr double error_degrees = 2.0 * faithful_normal_error_degrees;

TEST(FitGrid, KeepsRoundingBelowItsShareOfTheErrorAndTheExtent) {
    const mesh::Mesh sphere = testing::sphere(32);
    double last_step = 0.0;
    int last_bits = max_position_bits + 1;
    for (const double error : {0.0, 1e-4, 1e-3, 1e-2, 0.1}) {
        const QuantizationGrid grid = fit_grid(mesh::bounds(sphere), sphere, error, error_degrees);
        const double off = SurfaceRounding(sphere.positions, sphere.triangles).round(grid).off_surface_rms;
        EXPECT_LE(off, std::hypot(off_surface_share_of_error * error, off_surface_share_of_extent * grid.range));
        EXPECT_GE(grid.step(), last_step);
        last_step = grid.step();
        EXPECT_LE(grid.bits, last_bits);
        EXPECT_LE(grid.step(), mesh::mean_edge_length(sphere) / steps_per_edge);
        last_bits = grid.bits;
    }
    EXPECT_LT(last_bits, 10);
}

TEST(FitGrid, UsesWhatItMayBecauseStepsNeedNotHalve) {
    const mesh::Mesh sphere = testing::sphere(64);
    const Box bounds = mesh::bounds(sphere);
    for (const double error : {2e-4, 2.5e-4, 3e-4, 3.5e-4, 4e-4}) {
        const QuantizationGrid grid = fit_grid(bounds, sphere, error, error_degrees);
        const double allowed =
            std::hypot(off_surface_share_of_error * error, off_surface_share_of_extent * bounds.extent().x);
        const double off = SurfaceRounding(sphere.positions, sphere.triangles).round(grid).off_surface_rms;
        EXPECT_GT(off, 0.85 * allowed) << error;
        EXPECT_LE(off, allowed) << error;
        EXPECT_GE(grid.origin.x + grid.range, bounds.max.x);
        EXPECT_LT(grid.range, 2.1f * bounds.extent().x);
    }
}

TEST(FitGrid, IsFinerWhereRoundingIsAllThatShowsAndFewNormalsAreTold) {
    mesh::Mesh sphere = testing::sphere(48);
    const Box bounds = mesh::bounds(sphere);
    sphere.normals = sphere.positions;
    for (Vec3f& n : sphere.normals) n = normalize(n);
    for (const bool lean : {false, true}) {
        const double coarse = fit_grid(bounds, sphere, 0.0, error_degrees, lean).step();
        EXPECT_LT(fit_grid(bounds, sphere, 0.0, 0.0, lean).step(), 0.9 * coarse);
        mesh::Mesh told = sphere;
        for (Vec3f& n : told.normals) n = normalize(n + Vec3f(0.1f, 0.2f, 0.0f));
        EXPECT_EQ(fit_grid(bounds, told, 0.0, 0.0, lean).step(), coarse);
    }
    EncodeOptions faithful, other;
    fit_normals(faithful, sphere, 0.0);
    fit_normals(other, sphere, error_degrees);
    EXPECT_LT(faithful.normal_tolerance_degrees, other.normal_tolerance_degrees);
}

TEST(FitGrid, HoldsItsLevelNearTheLargestFloats) {
    mesh::Mesh sphere = testing::sphere(8);
    for (Vec3f& p : sphere.positions) p = 1.6e38f * p;
    for (const double error : {0.0, 1e36, 1e38}) {
        const Box bounds = mesh::bounds(sphere);
        const QuantizationGrid grid = fit_grid(bounds, sphere, error, error_degrees);
        EXPECT_TRUE(std::isfinite(grid.range));
        EXPECT_GE(double(grid.origin.x) + double(grid.range), bounds.max.x);
    }
}

TEST(FitGrid, AnswersForAnyLevel) {
    mesh::Mesh point;
    point.positions.assign(3, Vec3f(7.0f));
    point.triangles = {{0, 1, 2}};
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const mesh::Mesh& mesh : {mesh::Mesh{}, point, sheet(1)})
        for (const double error : {0.0, -1.0, 1e300, nan, std::numeric_limits<double>::infinity()}) {
            const QuantizationGrid grid = fit_grid(mesh::bounds(mesh), mesh, error, error_degrees);
            EXPECT_GE(grid.bits, min_position_bits);
            EXPECT_LE(grid.bits, max_position_bits);
            EXPECT_GT(grid.range, 0.0f);
            const double tolerance = fit_normal_tolerance_degrees(error);
            EXPECT_GE(tolerance, least_normal_tolerance_degrees);
            EXPECT_LE(tolerance, largest_normal_tolerance_degrees);
        }
}

TEST(FitNormalBits, KeepAStepBelowAQuarterOfTheTolerance) {
    EXPECT_EQ(fit_normal_bits(8.0), 6);
    EXPECT_EQ(fit_normal_bits(2.8125), 8);
    EXPECT_EQ(fit_normal_bits(least_normal_tolerance_degrees), most_normal_bits);
    EXPECT_EQ(fit_normal_bits(least_normal_tolerance_degrees, true), most_told_normal_bits);
    EXPECT_EQ(fit_normal_bits(largest_normal_tolerance_degrees, true), 6);
    EXPECT_EQ(fit_normal_bits(1e-9), most_normal_bits);
    EXPECT_EQ(fit_normal_bits(1e9), 4);
}

}  // namespace
}  // namespace lodestream::codec
