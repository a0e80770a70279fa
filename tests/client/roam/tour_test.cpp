#include "client/roam/tour.h"

#include <gtest/gtest.h>

#include "common/scene/view.h"

namespace lodestream::roam {
namespace {

TEST(Tour, SeesTheSceneAllTheWayAndGoesFromAfarCloseUpAndAway) {
    for (const Vec3d& extent : {Vec3d{100, 20, 15}, Vec3d{5, 1, 80}, Vec3d{1, 1, 1}, Vec3d{3e7, 1e-3, 2e7}}) {
        const Box box{Vec3d{-7.0}, Vec3d{-7.0} + extent};
        const motion::Trace trace = tour(box);
        EXPECT_DOUBLE_EQ(motion::duration_s(trace), tour_s);
        double nearest = 1e9;
        const auto distance_at = [&](double t_s) {
            return distance(*motion::pose_at(trace, t_s).position, box.center()) / box.radius();
        };
        for (const motion::Sample& sample : trace) {
            ASSERT_TRUE(all_finite(*sample.pose.position));
            scene::View view = scene::view_towards(*sample.pose.position,
                                                   *sample.pose.position + box.radius() * direction(sample.pose));
            view.fov_y_deg = 60.0;
            ASSERT_TRUE(scene::validate(view));
            ASSERT_TRUE(scene::Projection(view).sees(box)) << sample.t_s;
            nearest = std::min(nearest, distance_at(sample.t_s));
        }
        EXPECT_LT(nearest, 1.2);
        EXPECT_GT(distance_at(0.0), 2.0);
        EXPECT_GT(distance_at(tour_s), 2.0);
    }
}

TEST(Tour, StandsStillWhereThereIsNothing) {
    for (const Box& box : {Box{}, Box{Vec3d{1.0}, Vec3d{1.0}}}) {
        EXPECT_EQ(motion::duration_s(tour(box)), 0.0);
        EXPECT_EQ(tour(box).size(), 1u);
    }
}

}  // namespace
}  // namespace lodestream::roam
