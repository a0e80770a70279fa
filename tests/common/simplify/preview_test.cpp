#include "common/simplify/preview.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <thread>

#include "tests/common/simplify/shapes.h"

namespace lodestream::simplify {
namespace {

Preview preview_of(const mesh::Mesh& mesh, std::uint64_t triangles) {
    return make_previews(mesh, std::span(&triangles, 1)).at(0);
}

void expect_sound(const mesh::Mesh& mesh, const mesh::Mesh& source) {
    const std::size_t n = mesh.positions.size();
    for (const Vec3f& p : mesh.positions) EXPECT_TRUE(all_finite(p));
    EXPECT_EQ(mesh.normals.size(), source.normals.empty() ? 0 : n);
    EXPECT_EQ(mesh.texture_coordinates.size(), source.texture_coordinates.empty() ? 0 : n);
    EXPECT_EQ(mesh.colors.size(), source.colors.empty() ? 0 : n);
    EXPECT_EQ(mesh.triangle_materials.size(), source.triangle_materials.empty() ? 0 : mesh.triangles.size());
    for (const mesh::Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            ASSERT_LT(t[k], n);
            EXPECT_NE(mesh.positions[t[k]], mesh.positions[t[(k + 1) % 3]]);
        }
}

TEST(Preview, HoldsEveryCountAndComesNearIt) {
    const mesh::Mesh sphere = testing::sphere(80);
    for (const std::uint64_t count : {4u, 20u, 200u, 1000u, 4000u, 12000u}) {
        const Preview preview = preview_of(sphere, count);
        EXPECT_LE(preview.mesh.triangles.size(), count);
        EXPECT_GE(2 * preview.mesh.triangles.size(), count);
        expect_sound(preview.mesh, sphere);
    }
}

TEST(Preview, AMeshThatFitsIsItself) {
    const mesh::Mesh torus = testing::torus(10);
    const Preview preview = preview_of(torus, 200);
    EXPECT_EQ(preview.mesh.triangles.size(), 200u);
    EXPECT_EQ(preview.error.max, 0.0);
    EXPECT_TRUE(preview_of(mesh::Mesh{}, 10).mesh.triangles.empty());
}

TEST(Preview, ReportsNoLessThanAnIndependentMeasurement) {
    mesh::Mesh scene = testing::torus(60);
    testing::append(scene, testing::soup(500), {5, 0, 0});
    for (const mesh::Mesh& mesh :
         {testing::sphere(90), testing::torus(70), scene,
          testing::grid(70, [](double x, double z) { return 5.0 * std::sin(x / 7.0) * std::cos(z / 5.0); })}) {
        const metric::SurfaceIndex original(mesh);
        for (const std::uint64_t count : {2000u, 400u, 60u}) {
            const Preview preview = preview_of(mesh, count);
            const metric::SurfaceError measured = metric::measure(original, mesh, preview.mesh);
            EXPECT_GE(preview.error.rms, 0.95 * measured.rms) << count;
            EXPECT_LE(preview.error.rms, 1.5 * measured.rms) << count;
            EXPECT_GE(preview.error.max, preview.error.rms) << count;
        }
    }
}

TEST(Preview, BothSidesOfASeamStayAndLieOnOnePosition) {
    const mesh::Mesh tube = testing::textured_tube(96, 60);
    const Preview preview = preview_of(tube, 600);
    std::map<std::array<float, 3>, std::set<float>> u_at;
    for (std::size_t v = 0; v < preview.mesh.positions.size(); ++v) {
        const Vec3f& p = preview.mesh.positions[v];
        u_at[{p.x, p.y, p.z}].insert(preview.mesh.texture_coordinates[v].x);
    }
    std::size_t seam = 0;
    for (const auto& [position, us] : u_at)
        if (us.size() == 2 && *us.rbegin() - *us.begin() > 0.5f) ++seam;
    EXPECT_GE(seam, 4u);
    // No triangle spans the picture: one side's vertices were never taken for the other's.
    for (const mesh::Triangle& t : preview.mesh.triangles) {
        float low = 1, high = 0;
        for (const std::uint32_t v : t) {
            low = std::min(low, preview.mesh.texture_coordinates[v].x);
            high = std::max(high, preview.mesh.texture_coordinates[v].x);
        }
        EXPECT_LT(high - low, 0.5f);
    }
}

// A cell's vertex goes to where its planes meet: near the cube's edges and corners, not between them.
TEST(Preview, EdgesAndCornersStaySharp) {
    mesh::Mesh cube = testing::sphere(120);
    for (Vec3f& p : cube.positions) p /= std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    const Preview preview = preview_of(cube, 600);  // cells are 0.3 wide
    EXPECT_LT(preview.error.rms, 0.01);
    Box bounds;
    for (const Vec3f& p : preview.mesh.positions) bounds.add(Vec3d(p));
    EXPECT_NEAR(bounds.diagonal(), 2.0 * std::sqrt(3.0), 0.05);
}

TEST(Preview, SheetsThatShareACellAreNotJoined) {
    mesh::Mesh sheets = testing::flat_grid(40);
    testing::append(sheets, testing::flat_grid(40), {0, 0.01f, 0});
    const Preview preview = preview_of(sheets, 400);
    std::set<float> heights;
    for (const Vec3f& p : preview.mesh.positions) heights.insert(p.y);
    EXPECT_EQ(heights, (std::set<float>{0.0f, 0.01f}));
}

TEST(Preview, SoupAndScatteredPiecesLeaveSomething) {
    const mesh::Mesh soup = testing::soup(3000);
    mesh::Mesh crumbs;
    for (int i = 0; i < 500; ++i) {
        const int row = i / 23;
        testing::append(crumbs, testing::tetrahedron(), {float(i % 23), float(i % 7), float(row)}, 0.01f);
    }
    for (const mesh::Mesh& mesh : {soup, crumbs})
        for (const std::uint64_t count : {1u, 7u, 200u}) {
            const Preview preview = preview_of(mesh, count);
            EXPECT_GE(preview.mesh.triangles.size(), 1u);
            EXPECT_LE(preview.mesh.triangles.size(), count);
            expect_sound(preview.mesh, mesh);
        }
}

TEST(Preview, ExtremeCoordinatesStayFinite) {
    mesh::Mesh outlier = testing::sphere(40);
    testing::append(outlier, testing::single_triangle(), {1e6f, 0, 0});
    outlier.normals.resize(outlier.positions.size(), {0, 1, 0});
    std::vector<mesh::Mesh> meshes{outlier};
    for (const float scale : {1e-30f, 1e-9f, 1e9f, 1e30f}) {
        meshes.push_back(testing::sphere(40));
        for (Vec3f& p : meshes.back().positions) p *= scale;
    }
    for (const mesh::Mesh& mesh : meshes) {
        const Preview preview = preview_of(mesh, 300);
        EXPECT_GE(preview.mesh.triangles.size(), 100u);
        expect_sound(preview.mesh, mesh);
        EXPECT_TRUE(std::isfinite(preview.error.rms) && std::isfinite(preview.error.max));
    }
}

TEST(Preview, MaterialsFollowTheirTriangles) {
    mesh::Mesh two = testing::flat_grid(30);
    testing::append(two, testing::flat_grid(30), {40, 0, 0});
    two.triangle_materials.assign(two.triangles.size(), 0);
    std::fill(two.triangle_materials.begin() + 1800, two.triangle_materials.end(), 1u);
    const Preview preview = preview_of(two, 200);
    for (std::size_t t = 0; t < preview.mesh.triangles.size(); ++t)
        EXPECT_EQ(preview.mesh.triangle_materials[t],
                  preview.mesh.positions[preview.mesh.triangles[t][0]].x > 35 ? 1u : 0u);
}

TEST(Preview, IsTheSameOnAnyExecutor) {
    const mesh::Mesh torus = testing::torus(60);
    const std::uint64_t counts[] = {2000, 500, 100};
    const Executor side_by_side = [](std::size_t count, const std::function<void(std::size_t)>& task) {
        std::vector<std::jthread> threads;
        for (std::size_t i = 0; i < count; ++i) threads.emplace_back([&task, i] { task(i); });
    };
    const auto one = make_previews(torus, counts), many = make_previews(torus, counts, side_by_side);
    for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one[i].mesh.positions, many[i].mesh.positions);
        EXPECT_EQ(one[i].mesh.triangles, many[i].mesh.triangles);
        EXPECT_EQ(one[i].error.rms, many[i].error.rms);
    }
}

}  // namespace
}  // namespace lodestream::simplify
