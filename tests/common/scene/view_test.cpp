#include "common/scene/view.h"

#include <gtest/gtest.h>

#include "tests/common/scene/trees.h"

namespace lodestream::scene {
namespace {

View towards_minus_z() {
    View view;
    view.eye = {0, 0, 10};
    view.target = {0, 0, 0};
    view.width = view.height = 1'000;
    view.fov_y_deg = 90.0;
    return view;
}

TEST(View, AnErrorShowsByItsDepthAndTheCanvas) {
    const Box box{{-1, -1, -1}, {1, 1, 0}};
    EXPECT_NEAR(Projection(towards_minus_z()).error_px(box, 0.1), 0.1 * 500.0 / 10.0, 1e-9);
    View small = towards_minus_z();
    small.width = small.height = 100;
    EXPECT_NEAR(Projection(small).error_px(box, 0.1), 0.1 * 50.0 / 10.0, 1e-9);
}

TEST(View, WhatIsBehindOrBesideIsNotSeen) {
    const Projection projection(towards_minus_z());
    EXPECT_FALSE(projection.sees({{-1, -1, 11}, {1, 1, 12}}));
    EXPECT_FALSE(projection.sees({{50, -1, 0}, {51, 1, 1}}));
    EXPECT_FALSE(projection.sees({{-1, 50, 0}, {1, 51, 1}}));
    EXPECT_FALSE(projection.sees({}));
    EXPECT_TRUE(projection.sees({{-1, -1, 0}, {1, 1, 1}}));
    EXPECT_EQ(projection.error_px({{-1, -1, 11}, {1, 1, 12}}, 5.0), 0.0);
}

TEST(View, ACameraInsideABoxSeesAFiniteError) {
    const double error = Projection(towards_minus_z()).error_px({{-20, -20, -20}, {20, 20, 20}}, 1.0);
    EXPECT_NEAR(error, 500.0 / 0.1, 1e-6);
}

TEST(View, TheNearPlaneThroughABoxBoundsItsError) {
    View view = towards_minus_z();
    view.near = 9.5;
    EXPECT_NEAR(Projection(view).error_px({{-1, -1, -1}, {1, 1, 1}}, 1.0), 500.0 / 9.5, 1e-6);
    EXPECT_FALSE(Projection(view).sees({{-1, -1, 0.6}, {1, 1, 1}}));
}

TEST(View, ABoxBesideTheEyeIsAsDeepAsItsDistanceSays) {
    // It begins behind the eye, but nothing of it that is on the canvas is near.
    const double error = Projection(towards_minus_z()).error_px({{20, -1, -40}, {21, 1, 20}}, 1.0);
    EXPECT_LT(error, 500.0 / (20.0 * 0.57));
    EXPECT_GT(error, 0.0);
}

TEST(View, SeesMillimetresFromPlanetaryCoordinates) {
    const Vec3d far{6.4e6, 1e6, -2e6};
    View view = towards_minus_z();
    view.eye += far;
    view.target += far;
    const Box box{far + Vec3d{-1, -1, -1}, far + Vec3d{1, 1, 0}};
    EXPECT_NEAR(Projection(view).error_px(box, 0.001), 0.05, 1e-6);
}

TEST(View, ABoxWithinAnotherShowsNoLargerError) {
    Random random(3);
    for (int round = 0; round < 200; ++round) {
        const LodTree tree = testing::made_tree(200, random, random.log_uniform(1e-3, 1e6));
        const Projection projection(testing::made_view(random, tree[0].box));
        for (std::size_t i = 1; i < tree.size(); ++i)
            ASSERT_LE(projection.error_px(tree[i].box, 1.0), projection.error_px(tree[tree[i].parent].box, 1.0));
    }
}

TEST(View, TheDepthOfEveryPointOnTheCanvasIsAtLeastTheLeastDepth) {
    Random random(5);
    for (int round = 0; round < 2'000; ++round) {
        const Box box{{-1, -2, -3}, {3, 2, 1}};
        const View view = testing::made_view(random, box);
        const Projection projection(view);
        const Vec3d forward = normalize(view.target - view.eye);
        const double focal = view.height / 2.0 / std::tan(radians(view.fov_y_deg) / 2.0);
        for (int k = 0; k < 20; ++k) {
            const Vec3d point = box.min + box.extent() * Vec3d{random.uniform(), random.uniform(), random.uniform()};
            if (!projection.sees({point, point})) continue;
            ASSERT_GE(projection.error_px(box, 1.0) * (1 + 1e-9), focal / dot(forward, point - view.eye));
        }
    }
}

TEST(View, RefusesWhatIsNoView) {
    EXPECT_TRUE(validate(View{}));
    const auto refused = [](auto change) {
        View view;
        change(view);
        return !validate(view);
    };
    EXPECT_TRUE(refused([](View& v) { v.target = v.eye; }));
    EXPECT_TRUE(refused([](View& v) { v.eye.x = NAN; }));
    EXPECT_TRUE(refused([](View& v) { v.up = v.target - v.eye; }));
    EXPECT_TRUE(refused([](View& v) { v.up = Vec3d{0.0}; }));
    EXPECT_TRUE(refused([](View& v) { v.near = 0.0; }));
    EXPECT_TRUE(refused([](View& v) { v.fov_y_deg = 180.0; }));
    EXPECT_TRUE(refused([](View& v) { v.width = 0; }));
    EXPECT_TRUE(refused([](View& v) { v.target = Vec3d{1e308}, v.eye = Vec3d{-1e308}; }));
}

TEST(ViewTowards, IsAValidViewInEveryDirection) {
    const Vec3d eye{3.0, -2.0, 1e6};
    for (const Vec3d& direction :
         {Vec3d{0, 1, 0}, Vec3d{0, -1, 0}, Vec3d{1e-9, 1, 0}, Vec3d{1, 0, 0}, Vec3d{0, 0, -5}}) {
        const View view = view_towards(eye, eye + direction);
        EXPECT_TRUE(validate(view));
        EXPECT_EQ(view.eye, eye);
    }
}

TEST(AheadOf, GoesOnStraightAndTurnsOnAsTheMotionDid) {
    View before, now;
    before.eye = {0, 0, 0};
    before.target = {0, 0, -2};
    now.eye = {1, 0, 0};
    now.target = now.eye + 2.0 * Vec3d{std::sin(0.1), 0, -std::cos(0.1)};
    const View view = ahead_of(before, now, 3.0);
    EXPECT_NEAR(distance(view.eye, Vec3d{4, 0, 0}), 0.0, 1e-12);
    EXPECT_NEAR(distance(view.target, view.eye + 2.0 * Vec3d{std::sin(0.4), 0, -std::cos(0.4)}), 0.0, 1e-12);
}

TEST(AheadOf, IsAValidViewWhateverTheMotion) {
    View before, now;
    for (const Vec3d& jump : {Vec3d{0, 0, 0}, Vec3d{1e300, -1e300, 1e300}, Vec3d{1e-300, 0, 0}})
        for (const Vec3d& look : {Vec3d{0, 0, -1}, Vec3d{0, 0, 1}, Vec3d{1, 0, 0}, Vec3d{1e-9, 1, 1e-9}})
            for (const double steps : {0.0, 1.0, 1e6, 1e300}) {
                now.eye = before.eye + jump;
                now.target = now.eye + look;
                now.up = {0.3, 0.1, 0.9};
                if (!validate(now)) continue;
                EXPECT_TRUE(validate(ahead_of(before, now, steps)).ok());
            }
}

}  // namespace
}  // namespace lodestream::scene
