#include "common/shading/view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lodestream::shading {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Box box_of_radius(double radius) {
    Box box;
    box.add(Vec3d{-radius / std::sqrt(3.0)});
    box.add(Vec3d{radius / std::sqrt(3.0)});
    return box;
}

View from(double distance) {
    return {{0, 0, distance}, {0, 0, 0}, 45.0, {0, 1, 0}};
}

TEST(Distance, IsZeroAtTheObjectAndOneWhereItIsSixteenPixelsTall) {
    const Box box = box_of_radius(2.0);
    EXPECT_EQ(distance_level(from(2.0), box, default_display, 8), 0.0);
    EXPECT_EQ(distance_level(from(0.5), box, default_display, 8), 0.0);
    const double farthest = 2.0 * 600.0 / (far_diameter_px * std::tan(radians(22.5)));
    EXPECT_EQ(distance_level(from(farthest * 1.001), box, default_display, 8), 1.0);
    EXPECT_EQ(distance_level(from(1e300), box, default_display, 8), 1.0);
}

TEST(Distance, GrowsInAsManyStepsAsTheDeviceAffords) {
    const Box box = box_of_radius(1.0);
    for (const std::uint32_t steps : {2u, 5u, 16u}) {
        double last = 0.0;
        std::size_t changes = 0;
        for (double d = 1.0; d < 300.0; d *= 1.01) {
            const double level = distance_level(from(d), box, default_display, steps);
            EXPECT_GE(level, last);
            changes += level != last;
            EXPECT_NEAR(level * steps, std::round(level * steps), 1e-9);
            last = level;
        }
        EXPECT_EQ(changes, steps);
    }
}

TEST(DistanceSteps, FollowTheCapacity) {
    EXPECT_EQ(distance_steps(1.0), 16u);
    EXPECT_EQ(distance_steps(300.0 / 3400.0), 5u);
    EXPECT_EQ(distance_steps(70.0 / 3400.0), 2u);
    EXPECT_EQ(distance_steps(1e300), 16u);
    EXPECT_EQ(distance_steps(0.0), 2u);
    EXPECT_EQ(distance_steps(nan), 2u);
}

TEST(ScreenSpaceError, IsTheProjectionAtTheNearestPoint) {
    const double per_unit = pixels_per_unit(from(3.0), box_of_radius(1.0), default_display);
    EXPECT_NEAR(per_unit, 600.0 / (2.0 * std::tan(radians(22.5)) * 2.0), 1e-9);
}

TEST(ScreenSpaceError, IsFiniteInsideTheObjectAndForEveryScale) {
    for (const double scale : {1e-300, 1e-9, 1.0, 1e9, 1e300}) {
        const Box box = box_of_radius(scale);
        for (const double eye : {0.0, 0.5, 1.0, 2.0, 1e9}) {
            View view = from(eye * scale);
            EXPECT_TRUE(std::isfinite(pixels_per_unit(view, box, default_display))) << scale << ' ' << eye;
            EXPECT_TRUE(std::isfinite(distance_level(view, box, default_display, 4)));
        }
    }
    EXPECT_EQ(pixels_per_unit(from(1), Box{}, default_display), 0.0);
}

TEST(Distance, DisplaysWithoutPixelsAndSixteenThousandWideOnesAreFinite) {
    const Box box = box_of_radius(1.0);
    for (const budget::Display display : {budget::Display{0, 0}, budget::Display{0, 16'384}, budget::Display{16'384, 0},
                                          budget::Display{16'384, 16'384}})
        for (const double eye : {0.0, 1.0, 1.5, 1e3, 1e300})
            for (const double fov : {1e-300, 45.0, 179.9}) {
                View view = from(eye);
                view.fov_y_deg = fov;
                const double d = distance_level(view, box, display, 16);
                EXPECT_GE(d, 0.0);
                EXPECT_LE(d, 1.0);
                EXPECT_TRUE(std::isfinite(pixels_per_unit(view, box, display)));
            }
}

TEST(Distance, StepsRoundTheContinuousDistanceUp) {
    const Box box = box_of_radius(1.0);
    for (double d = 0.5; d < 500.0; d *= 1.3) {
        const double continuous = continuous_distance(from(d), box, default_display);
        const double level = distance_level(from(d), box, default_display, 5);
        EXPECT_GE(level, continuous - 1e-9);
        EXPECT_LT(level, continuous + 0.2);
    }
}

TEST(FramingView, TouchesTheFrustumFromOutside) {
    const View view = framing_view(box_of_radius(3.0));
    EXPECT_NEAR(length(view.eye), 3.0 / std::sin(radians(22.5)), 1e-9);
    EXPECT_TRUE(validate(view).ok());
    EXPECT_TRUE(validate(framing_view(Box{})).ok());
}

TEST(View, RefusesWhatHasNoDirection) {
    View view = from(3.0);
    EXPECT_TRUE(validate(view).ok());
    view.light = Vec3d{0.0};
    EXPECT_FALSE(validate(view).ok());
    view = from(0.0);
    EXPECT_FALSE(validate(view).ok());
    view = from(3.0);
    view.eye.y = nan;
    EXPECT_FALSE(validate(view).ok());
    for (const double fov : {0.0, 180.0, -45.0, nan}) {
        view = from(3.0);
        view.fov_y_deg = fov;
        EXPECT_FALSE(validate(view).ok()) << fov;
    }
}

}  // namespace
}  // namespace lodestream::shading
