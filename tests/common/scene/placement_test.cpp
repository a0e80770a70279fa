#include "common/scene/placement.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/base/random.h"
#include "common/base/transform.h"

namespace lodestream::scene {
namespace {

const Box box{Vec3d{-1, -2, -3}, Vec3d{2, 1, 4}};

Mat4d by(const Vec3d& offset) {
    return matrix_of(offset, {0, 0, 0, 1}, {1, 1, 1});
}

TEST(Placement, RefusesWhatNoObjectCanBePutBy) {
    EXPECT_TRUE(validate({}));
    EXPECT_TRUE(validate({matrix_of({1e12, 0, 0}, {1, 2, 3, 4}, {-1, 1e6, 1e-6}), true}));
    const double infinite = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(validate({by({infinite, 0, 0}), true}));
    EXPECT_FALSE(validate({by({std::numeric_limits<double>::quiet_NaN(), 0, 0}), true}));
    EXPECT_FALSE(validate({by({1.1e12, 0, 0}), true}));
    EXPECT_FALSE(validate({matrix_of({0, 0, 0}, {0, 0, 0, 1}, {1.1e6, 1, 1}), true}));
    EXPECT_FALSE(validate({matrix_of({0, 0, 0}, {0, 0, 0, 1}, {1e-7, 1, 1}), true}));
    EXPECT_FALSE(validate({matrix_of({0, 0, 0}, {0, 0, 0, 1}, {0, 1, 1}), true}));
    Mat4d projective(1.0);
    projective[2][3] = 0.1;
    EXPECT_FALSE(validate({projective, true}));
}

TEST(Placement, LargestScaleIsTheMostThatAnyVectorGrows) {
    EXPECT_NEAR(largest_scale(Mat4d(1.0)), 1.0, 1e-15);
    EXPECT_NEAR(largest_scale(matrix_of({5, 5, 5}, {1, 2, 3, 4}, {-3, 2, 0.1})), 3.0, 1e-12);
    Random random{7};
    for (int i = 0; i < 200; ++i) {
        Mat4d matrix(1.0);
        for (int k = 0; k < 9; ++k) matrix[k / 3][k % 3] = 2.0 * random.uniform() - 1.0;
        const double bound = largest_scale(matrix);
        double most = 0.0;
        for (int k = 0; k < 400; ++k) {
            const Vec3d v{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
            most = std::max(most, length(Mat3d(matrix) * v) / length(v));
        }
        EXPECT_LE(most, bound * (1.0 + 1e-12));
        EXPECT_GE(most, 0.9 * bound);
    }
}

TEST(Placement, DisplacementIsHowFarAPlaceMovesButNoMoreThanTheExtent) {
    EXPECT_EQ(displacement(box, {}, {}), 0.0);
    EXPECT_NEAR(displacement(box, {}, {by({0.5, 0, 0}), true}), 0.5, 1e-12);
    EXPECT_NEAR(displacement(box, {by({0.5, 0, 0}), true}, {by({0.5, 0, 0.25}), true}), 0.25, 1e-12);
    const double extent = box.diagonal();
    EXPECT_NEAR(displacement(box, {}, {by({1e9, 0, 0}), true}), extent, 1e-9);
    EXPECT_NEAR(displacement(box, {}, {Mat4d(1.0), false}), extent, 1e-12);
    EXPECT_NEAR(displacement(box, {Mat4d(1.0), false}, {matrix_of({0, 0, 0}, {0, 0, 0, 1}, {2, 2, 2}), true}),
                2.0 * extent, 1e-12);
    EXPECT_EQ(displacement(box, {Mat4d(1.0), false}, {by({1, 0, 0}), false}), 0.0);
    EXPECT_EQ(displacement({}, {}, {by({1, 0, 0}), true}), 0.0);
}

TEST(Placement, NoPointOfTheBoxMovesFarther) {
    Random random{11};
    for (int i = 0; i < 200; ++i) {
        const auto part = [&] { return random.uniform() - 0.5; };
        const Placement a{matrix_of({part(), part(), part()}, {part(), part(), part(), 1}, {1, 1, 1}), true};
        const Placement b{matrix_of({part(), part(), part()}, {part(), part(), part(), 1}, {1, 1, 1}), true};
        const double bound = displacement(box, a, b);
        for (int k = 0; k < 50; ++k) {
            const Vec3d p = box.min + Vec3d{random.uniform(), random.uniform(), random.uniform()} * box.extent();
            const Vec4d moved = a.matrix * Vec4d(p, 1.0) - b.matrix * Vec4d(p, 1.0);
            EXPECT_LE(std::min(length(Vec3d(moved)), box.diagonal()), bound * (1.0 + 1e-9));
        }
    }
}

TEST(Placement, ABoxIsPlacedWithAllItHolds) {
    EXPECT_TRUE(placed({}, by({1, 2, 3})).empty());
    const Box turned = placed(box, matrix_of({10, 0, 0}, {0, 0, 1, 1}, {1, 1, 1}));  // a quarter turn: x to y, y to -x
    EXPECT_LT(distance(turned.min, Vec3d{9, -1, -3}), 1e-12);
    EXPECT_LT(distance(turned.max, Vec3d{12, 2, 4}), 1e-12);
}

}  // namespace
}  // namespace lodestream::scene
