#include <gtest/gtest.h>

#include "server/samples/samples.h"
#include "tests/server/samples/mesh_checks.h"

namespace lodestream::samples {
namespace {

using namespace lodestream::testing;

TEST(Teapot, HasExactlyTheTrianglesAskedFor) {
    std::vector<std::uint64_t> counts{teapot_triangles, 800, 4'095, 4'096, 4'097, 9'999, 100'000, 250'001};
    for (std::uint64_t n = min_teapot_triangles; n < 700; ++n) counts.push_back(n);
    for (const std::uint64_t n : counts) {
        const auto model = teapot(n);
        ASSERT_TRUE(model.ok()) << n;
        EXPECT_EQ(model->mesh.triangles.size(), n);
    }
}

TEST(Teapot, IsSoundAtEverySize) {
    for (const std::uint64_t n : {128, 129, 191, 800, 6'400, 200'000}) {
        SCOPED_TRACE(n);
        expect_sound(*teapot(n));
    }
}

TEST(Teapot, HasFourTubesWithoutCracksWhoseSixRimsAreTheOnlyBorders) {
    for (const std::uint64_t n : {128, 200, 801, 6'400}) {
        const auto model = teapot(n);
        const auto edges = directed_edges_by_index(model->mesh);
        EXPECT_TRUE(each_edge_once(edges)) << n;
        EXPECT_EQ(components(edges), 4u) << n;
        std::map<Edge, int> rims;
        for (const Edge& edge : border(edges)) rims[edge] = 1;
        EXPECT_EQ(components(rims), 6u) << n;
    }
}

TEST(Teapot, SharesVerticesWherePatchesMeet) {
    const auto model = teapot();
    const auto welded = mesh::weld_positions(model->mesh.positions);
    int twice = 0;
    for (std::uint32_t i = 0; i < welded.size(); ++i) twice += welded[i] != i;
    EXPECT_LE(twice, 1);  // Newell's handle touches the body in one point
}

TEST(Teapot, IsTwoMetresWideAndCentredInTheClassicProportions) {
    const auto model = teapot(200'000);
    const Box box = mesh::bounds(model->mesh);
    EXPECT_NEAR(length(box.center()), 0, 1e-6);
    EXPECT_NEAR(box.extent().x, 2.0, 1e-6);
    EXPECT_NEAR(box.extent().y, 2.0 * 3.15 / 6.434, 1e-3);
    EXPECT_NEAR(box.extent().z, 2.0 * 4.0 / 6.434, 1e-3);
}

TEST(Teapot, FacesOutwardsWithTheSurfacesOwnNormals) {
    EXPECT_GT(signed_volume(teapot()->mesh), 0.75);
    EXPECT_GT(worst_normal(teapot(200'000)->mesh), 0.9);
}

TEST(Teapot, PointsStraightUpAndDownAtItsPoles) {
    const auto model = teapot();
    const mesh::Mesh& m = model->mesh;
    const Box box = mesh::bounds(m);
    int up = 0, down = 0;
    for (std::size_t i = 0; i < m.positions.size(); ++i) {
        const Vec3d p(m.positions[i]);
        up += p.y == box.max.y && m.normals[i] == Vec3f{0, 1, 0};
        down += p.y == box.min.y && m.normals[i] == Vec3f{0, -1, 0};
    }
    EXPECT_EQ(up, 1);
    EXPECT_GE(down, 1);
}

TEST(Teapot, RefusesCountsThatNoTessellationHas) {
    EXPECT_EQ(teapot(min_teapot_triangles - 1).error().code, ErrorCode::invalid_input);
    EXPECT_EQ(teapot(max_sample_triangles + 1).error().code, ErrorCode::limit_exceeded);
    EXPECT_EQ(teapot(0).error().message, "teapot triangles must be 128 to 20000000, not 0");
}

}  // namespace
}  // namespace lodestream::samples
