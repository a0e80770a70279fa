#include "client/render/slices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <span>

#include "client/render/gl_context.h"
#include "common/mesh/operations.h"
#include "server/samples/samples.h"
#include "tests/support/cloud_difference.h"
#include "tests/support/meshes.h"

namespace lodestream::render {
namespace {

using points::Parameters;
using points::PointCloud;

class Slices : public ::testing::Test {
  protected:
    void SetUp() override {
        auto made_context = create_headless_context();
        ASSERT_TRUE(made_context) << made_context.error().message;
        context.emplace(*std::move(made_context));
        auto made = SliceRenderer::create();
        ASSERT_TRUE(made) << made.error().message;
        renderer.emplace(*std::move(made));
    }

    PointCloud by_gpu(const mesh::Mesh& mesh, const Parameters& parameters) {
        auto cloud =
            points::resample(mesh, parameters, [&](const points::SlicedView& view) { return renderer->draw(view); });
        EXPECT_TRUE(cloud) << cloud.error().message;
        return cloud ? *std::move(cloud) : PointCloud{};
    }

    std::optional<GlContext> context;
    std::optional<SliceRenderer> renderer;  // goes before its context
};

// The bound that resample.h and the README state.
constexpr double most_differing_share = 0.01;

TEST_F(Slices, TheGpusPointsAreTheCpusOnSmoothAndEdgedModels) {
    for (const char* name : {"teapot", "ship", "terrain:5000"}) {
        const mesh::Mesh mesh = samples::make_sample(name)->mesh;
        for (const Parameters& parameters : {Parameters{40, 40}, {100, 100}, {7, 160}}) {
            const PointCloud by_cpu = points::resample(mesh, parameters), gpus = by_gpu(mesh, parameters);
            EXPECT_GT(by_cpu.positions.size(), 1000u);
            EXPECT_LE(testing::differing_share(mesh, parameters, by_cpu, gpus), most_differing_share)
                << name << ' ' << parameters.side;
        }
    }
}

TEST_F(Slices, ColoursAreCarriedAlike) {
    mesh::Mesh mesh = testing::sphere(20);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        mesh.colors.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(3 * i), 7, 255});
    const Parameters parameters{50, 50};
    const PointCloud by_cpu = points::resample(mesh, parameters), gpus = by_gpu(mesh, parameters);
    ASSERT_EQ(gpus.colors.size(), gpus.positions.size());
    EXPECT_LE(testing::differing_share(mesh, parameters, by_cpu, gpus), most_differing_share);
}

TEST_F(Slices, WhatFallsBetweenAllPixelsIsAPointEitherWay) {
    mesh::Mesh specks = testing::sphere(8);
    const auto first = static_cast<std::uint32_t>(specks.positions.size());
    for (const float x : {0.0f, 1e-4f, 2e-4f}) specks.positions.push_back({1.5f + x, 0.3f + x * x, 0.2f - x});
    if (!specks.normals.empty()) specks.normals.resize(specks.positions.size(), {0, 1, 0});
    specks.triangles.push_back({first, first + 1, first + 2});
    const Parameters parameters{20, 20};
    const PointCloud by_cpu = points::resample(specks, parameters), gpus = by_gpu(specks, parameters);
    const auto has_speck = [](const PointCloud& cloud) {
        return std::any_of(cloud.positions.begin(), cloud.positions.end(), [](const Vec3f& p) { return p.x > 1.4f; });
    };
    EXPECT_TRUE(has_speck(by_cpu));
    EXPECT_TRUE(has_speck(gpus));
}

TEST_F(Slices, ExtremesGiveSoundClouds) {
    EXPECT_TRUE(by_gpu({}, {10, 10}).positions.empty());
    for (const Parameters& parameters : {Parameters{1, 1}, {1, 200}, {200, 1}})
        for (const float size : {1e-9f, 1.0f, 1e9f}) {
            mesh::Mesh mesh = testing::tetrahedron();
            for (Vec3f& p : mesh.positions) p *= size;
            const PointCloud cloud = by_gpu(mesh, parameters);
            EXPECT_FALSE(cloud.positions.empty());
            for (const Vec3f& p : cloud.positions) EXPECT_TRUE(all_finite(p));
        }
    const PointCloud edge_on = by_gpu(testing::single_triangle(), {30, 30});
    EXPECT_FALSE(edge_on.positions.empty());
}

TEST_F(Slices, RefusesPicturesThatTheDriverCannotDraw) {
    const std::array<Vec3f, 3> triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    const auto refused = renderer->draw({{1u << 20, 4, 1.0, 4}, std::span(&triangle, 1)});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::limit_exceeded);
}

}  // namespace
}  // namespace lodestream::render
