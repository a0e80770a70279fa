#include "client/report/crowd.h"

#include <gtest/gtest.h>

#include <cmath>
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

// Popping: what a change of levels alone changes in a picture, the levels of the step before drawn in this step's view.
TEST_F(CrowdTest, FadingTakesMostOffTheWorstStepOfADepartingCamera) {
    CrowdModel model = upload(3000, {3000, 700, 150, 30, 8});
    const auto worst_pop = [&](LevelChange change) {
        constexpr int steps = 200;
        double worst = 0.0;
        std::vector<render::Instance> before;
        for (int i = 0; i <= steps; ++i) {
            shading::View view;
            view.target = model.bounds.center();
            view.eye = view.target +
                       Vec3d(0, 0, model.bounds.radius() * std::lerp(20.0, 60.0, static_cast<double>(i) / steps));
            view.fov_y_deg = 5.0;
            render::DrawOptions options;
            options.width = options.height = 128;
            options.instances = crowd_of(model, {1, 1, 1}, view.eye, change);
            const auto now = points->draw(view, options);
            if (!before.empty()) {
                options.instances = before;
                worst = std::max(worst, render::compare(points->draw(view, options)->image, now->image)->rms);
            }
            before = crowd_of(model, {1, 1, 1}, view.eye, change);
        }
        return worst;
    };
    const double at_once = worst_pop(LevelChange::at_once), fading = worst_pop(LevelChange::fading);
    EXPECT_GT(at_once, 5.0);
    EXPECT_LT(fading, 0.5 * at_once);
}

TEST_F(CrowdTest, AnInstanceThatFadesSharesItsSamplesOutBetweenTwoLevels) {
    const CrowdModel model = upload(100, {50, 40, 30, 20, 10});
    for (const double distance : {1.0, 22.4, 22.6, 24.0, 24.999, 25.0, 47.0, 199.0, 201.0, 1e6}) {
        const Vec3d eye = model.bounds.center() + Vec3d(0, 0, distance * model.bounds.radius());
        double sum = 0.0;
        for (const render::Instance& instance : crowd_of(model, {1, 1, 1}, eye, LevelChange::fading))
            sum += instance.share.to - instance.share.from;
        EXPECT_DOUBLE_EQ(sum, 1.0) << distance;
        EXPECT_EQ(crowd_of(model, {1, 1, 1}, eye).size(), 1u);
    }
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
