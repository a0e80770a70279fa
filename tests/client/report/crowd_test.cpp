#include "client/report/crowd.h"

#include <gtest/gtest.h>

#include <optional>

#include "client/render/gl_context.h"
#include "common/points/order.h"
#include "common/points/resample.h"
#include "tests/support/meshes.h"

namespace lodestream::report {
namespace {

struct CrowdTest : ::testing::Test {
    void SetUp() override {
        auto made = render::create_headless_context();
        ASSERT_TRUE(made) << made.error().message;
        context.emplace(*std::move(made));
        auto created = render::Renderer::create();
        ASSERT_TRUE(created) << created.error().message;
        points.emplace(*std::move(created));
    }

    CrowdModel upload(std::uint64_t count, std::array<std::uint64_t, crowd_levels> levels) {
        mesh::Model model;
        model.mesh = testing::sphere(24);
        model.materials.resize(1);
        const codec::Decoded content = render::drawable(model, model.mesh);
        full.emplace(content);
        points::OrderedCloud ordered =
            points::order(points::resample(model.mesh, points::choose_parameters(model.mesh, count)), count);
        codec::Points cloud;
        cloud.levels = points::measured_levels(metric::SurfaceIndex(model.mesh), model.mesh, ordered);
        cloud.cloud = std::move(ordered.cloud);
        EXPECT_TRUE(points->upload(cloud));
        return {*full, *points, render::world_bounds(content), levels};
    }

    std::optional<render::GlContext> context;
    std::optional<render::Renderer> points;
    std::optional<SilhouetteTree> full;
};

TEST_F(CrowdTest, PointsOfEveryLevelScoreAboveThePaper) {
    CrowdModel model = upload(3000, {3000, 2000, 1000, 500, 250});
    CrowdOptions options;
    options.side = 3;
    options.directions = 3;
    options.canvas = {256, 256};
    const auto score = score_crowd(model, options);
    ASSERT_TRUE(score) << score.error().message;
    EXPECT_GT(score->all.f_measure(), 0.947);
    std::uint64_t drawn = 0;
    for (const std::uint64_t instances : score->instances) drawn += instances;
    EXPECT_EQ(drawn, 27u * orbit_distances.size() * options.directions);
}

TEST_F(CrowdTest, TooFewPointsScoreWorse) {
    CrowdOptions options;
    options.side = 2;
    options.directions = 3;
    options.canvas = {256, 256};
    CrowdModel fine = upload(3000, {3000, 3000, 3000, 3000, 3000});
    const double fine_f = score_crowd(fine, options)->all.f_measure();
    fine.levels = {4, 4, 4, 4, 4};
    EXPECT_LT(score_crowd(fine, options)->all.f_measure(), fine_f - 0.05);
}

TEST_F(CrowdTest, ThatReachesTheCameraIsRefused) {
    CrowdModel model = upload(100, {100, 100, 100, 100, 100});
    CrowdOptions options;
    options.side = 15;
    const auto refused = score_crowd(model, options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::invalid_input);
}

TEST_F(CrowdTest, MayBeStopped) {
    CrowdModel model = upload(100, {100, 100, 100, 100, 100});
    const auto stopped = score_crowd(model, {}, [] { return false; });
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, ErrorCode::unavailable);
}

TEST(SilhouetteScore, IsThePapersRecallPrecisionAndF) {
    const SilhouetteScore score{90, 10, 30};
    EXPECT_DOUBLE_EQ(score.recall(), 0.75);
    EXPECT_DOUBLE_EQ(score.precision(), 0.9);
    EXPECT_DOUBLE_EQ(score.f_measure(), 2 * 0.75 * 0.9 / 1.65);
    EXPECT_DOUBLE_EQ(SilhouetteScore{}.f_measure(), 1.0);
    EXPECT_DOUBLE_EQ((SilhouetteScore{0, 5, 5}.f_measure()), 0.0);
}

}  // namespace
}  // namespace lodestream::report
