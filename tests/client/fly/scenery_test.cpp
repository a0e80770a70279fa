#include "client/fly/scenery.h"

#include <gtest/gtest.h>

#include "tests/client/fly/constructed_scenery.h"

namespace lodestream::fly {
namespace {

using testing::spheres;

Vec3d forward(const shading::View& view) {
    return normalize(view.target - view.eye);
}

TEST(Scenery, APoseWithoutAPositionIsRelativeToTheDefaultView) {
    const shading::View home = default_view(spheres(), 45.0);
    const shading::View same = view_of(home, {});
    EXPECT_NEAR(length(same.eye - home.eye), 0.0, 1e-12);
    EXPECT_NEAR(length(forward(same) - forward(home)), 0.0, 1e-12);
    const shading::View turned = view_of(home, {std::nullopt, 30.0, 0.0});
    EXPECT_NEAR(length(turned.eye - home.eye), 0.0, 1e-12);
    EXPECT_LT(dot(forward(turned), forward(home)), 0.9);
}

TEST(Scenery, APoseWithAPositionIsAbsolute) {
    const shading::View view = view_of(default_view(spheres(), 45.0), {Vec3d{1, 2, 3}, 90.0, 0.0});
    EXPECT_EQ(view.eye, Vec3d(1, 2, 3));
    EXPECT_NEAR(length(forward(view) - Vec3d(-1, 0, 0)), 0.0, 1e-12);
}

TEST(Scenery, PitchStopsStraightUpAndDown) {
    const shading::View up = view_of(default_view(spheres("terrain"), 45.0), {std::nullopt, 0.0, 90.0});
    EXPECT_TRUE(shading::validate(up));
    EXPECT_NEAR(forward(up).y, 1.0, 1e-9);
    // The default view of a mesh looks down already.
    const shading::View down = view_of(default_view(spheres(), 45.0), {std::nullopt, 0.0, -90.0});
    EXPECT_TRUE(shading::validate(down));
    EXPECT_NEAR(forward(down).y, -1.0, 1e-9);
}

TEST(Scenery, OfATerrainTheViewerStandsInTheMiddleAboveTheGround) {
    const shading::View view = default_view(spheres("terrain"), 100.0);
    EXPECT_NEAR(view.eye.x, 0.0, 1e-6);
    EXPECT_GT(view.eye.y, 1.0);
    EXPECT_LT(view.eye.y, 1.1);
    EXPECT_NEAR(length(forward(view) - Vec3d(0, 0, -1)), 0.0, 1e-12);
    EXPECT_EQ(view.fov_y_deg, 100.0);
}

TEST(Scenery, ALadderHasErrorsInPixelsOfItsView) {
    const Scenery scenery = spheres();
    const shading::View home = default_view(scenery, 45.0);
    const auto ladder = ladder_of(scenery, home, {800, 600});
    const auto larger = ladder_of(scenery, home, {1600, 1200});
    ASSERT_EQ(ladder.size(), 3u);
    EXPECT_EQ(ladder[0].error_px, 0.0);
    EXPECT_GT(ladder[2].error_px, ladder[1].error_px);
    EXPECT_NEAR(larger[1].error_px / ladder[1].error_px, 2.0, 1e-9);
    EXPECT_TRUE(control::check(ladder, {}));
}

TEST(Scenery, ChosenLevelsKeepTheirOrder) {
    const Scenery two = chosen(spheres(), {0, 2});
    ASSERT_EQ(two.levels.size(), 2u);
    EXPECT_EQ(two.levels[1].triangles, spheres().levels[2].triangles);
}

TEST(Scenery, TellsHowMuchOfItAViewShows) {
    const Scenery scenery = spheres();
    const std::vector<Vec3d> points = sampled_triangles(scenery);
    ASSERT_FALSE(points.empty());
    const budget::Display display{400, 300};
    const shading::View home = default_view(scenery, 45.0);
    EXPECT_EQ(share_in_view(points, home, display), 1.0);
    EXPECT_EQ(share_in_view(points, view_of(home, {std::nullopt, 180.0, 0.0}), display), 0.0);
    // One that looks along an edge of the picture sees half of it.
    EXPECT_NEAR(share_in_view(points, view_of(home, {std::nullopt, 0.0, 22.5}), display), 0.5, 0.1);
    shading::View down = home;
    down.eye = home.target + Vec3d{0, 2.0 * length(home.eye - home.target), 0};
    EXPECT_EQ(share_in_view(points, down, display), 1.0);
    EXPECT_EQ(share_in_view({}, home, display), 1.0);
}

}  // namespace
}  // namespace lodestream::fly
