#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/codec/level_codec.h"

namespace lodestream::codec {
namespace {

Box box(const Vec3d& low, const Vec3d& high) {
    Box result;
    result.add(low);
    result.add(high);
    return result;
}

bool is_usable(const QuantizationGrid& grid) {
    return all_finite(grid.origin) && std::isfinite(grid.range) && grid.range > 0.0f &&
           grid.bits >= min_position_bits && grid.bits <= max_position_bits &&
           std::isnormal(static_cast<float>(grid.step()));
}

TEST(QuantizationGrid, StepStaysWithinItsLawsForRandomLevels) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> exponent(-12.0, 12.0), unit(0.0, 1.0);
    for (int i = 0; i < 2000; ++i) {
        const double size = std::pow(10.0, exponent(random));
        const double edge = size * std::pow(10.0, -3.0 * unit(random));
        const double error = edge * std::pow(10.0, 2.0 - 5.0 * unit(random));
        const QuantizationGrid grid = choose_grid(box(Vec3d(-size), Vec3d(size * unit(random), 0.0, 0.0)), error, edge);
        ASSERT_TRUE(is_usable(grid));
        if (grid.bits == max_position_bits) continue;
        EXPECT_LE(grid.step(), edge / coarsest_steps_per_edge * 1.0001);
        const double moved = grid.step() * std::sqrt(3.0) / 2.0;
        EXPECT_TRUE(moved <= error / 4.0 * 1.0001 || grid.step() <= edge / finest_steps_per_edge * 1.0001)
            << "error " << error << " edge " << edge << " step " << grid.step();
        if (grid.bits == min_position_bits) continue;
        EXPECT_GT(2.01 * grid.step(), edge / finest_steps_per_edge) << "more bits than the finest step needs";
    }
}

TEST(QuantizationGrid, CoversItsBounds) {
    const Box bounds = box({-0.1, 1e6 + 0.3, 7.7}, {0.7, 1e6 + 0.9, 9.1});
    const QuantizationGrid grid = choose_grid(bounds, 0.01, 0.1);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(grid.origin[axis], bounds.min[axis]);
        EXPECT_GE(static_cast<double>(grid.origin[axis]) + grid.range, bounds.max[axis]);
    }
}

TEST(QuantizationGrid, LevelsOfOneAssetDifferInBitsAlone) {
    const Box bounds = box({-1, -2, -3}, {3, 2, 1});
    const QuantizationGrid fine = choose_grid(bounds, 1e-4, 0.01), coarse = choose_grid(bounds, 0.1, 0.5);
    EXPECT_EQ(fine.origin, coarse.origin);
    EXPECT_EQ(fine.range, coarse.range);
    EXPECT_GT(fine.bits, coarse.bits);
}

TEST(QuantizationGrid, IsUsableForDegenerateAndExtremeInput) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    const Box boxes[] = {Box{},
                         box(Vec3d(0), Vec3d(0)),
                         box(Vec3d(5), Vec3d(5)),
                         box(Vec3d(0), Vec3d(1e-30)),
                         box(Vec3d(0), Vec3d(1e-42)),
                         box(Vec3d(-1e30), Vec3d(1e30)),
                         box(Vec3d(-3e38), Vec3d(3e38)),
                         box(Vec3d(-1e300), Vec3d(1e300)),
                         box(Vec3d(nan), Vec3d(nan)),
                         box(Vec3d(0), Vec3d(inf))};
    for (const Box& bounds : boxes)
        for (const double error : {0.0, -1.0, 1e-45, 1e-3, 1e30, 1e300, nan, inf})
            for (const double edge : {0.0, 1e-300, 1.0, 1e300, nan})
                for (const auto choose : {choose_grid, choose_window})
                    EXPECT_TRUE(is_usable(choose(bounds, error, edge))) << error << " " << edge;
}

TEST(QuantizationWindow, HoldsItsBoundsExactlyAndItsStepIsAPowerOfTwo) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> exponent(-9.0, 9.0), unit(-1.0, 1.0);
    for (int i = 0; i < 2000; ++i) {
        const double size = std::pow(10.0, exponent(random)), far = size * std::pow(10.0, 3.0 * std::abs(unit(random)));
        const Vec3d low(far * unit(random), far * unit(random), far * unit(random));
        const Box bounds = box(low, low + Vec3d(size, 0.5 * size, 0.0));
        const double edge = size * std::pow(10.0, -4.0 * std::abs(unit(random)));
        const QuantizationGrid grid = choose_window(bounds, 0.1 * edge, edge);
        ASSERT_TRUE(is_usable(grid));
        int power = 0;
        EXPECT_EQ(std::frexp(grid.step(), &power), 0.5);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_LE(grid.origin[axis], bounds.min[axis]);
            EXPECT_GE(static_cast<double>(grid.origin[axis]) + grid.range, bounds.max[axis]);
            EXPECT_EQ(std::fmod(grid.origin[axis], grid.step()), 0.0);
        }
    }
}

TEST(QuantizationWindow, NeighboursOfOneStepShareTheirPoints) {
    const QuantizationGrid left = choose_window(box({-7.3, 0, 0}, {1.1, 2, 2}), 0.01, 0.3),
                           right = choose_window(box({1.1, -4, 0}, {5.9, 2, 2}), 0.01, 0.3);
    ASSERT_EQ(left.step(), right.step());
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(std::fmod(left.origin[axis] - right.origin[axis], left.step()), 0.0);
}

TEST(QuantizationGrid, KeepsEveryBitWhereNothingMeasuresTheStep) {
    EXPECT_EQ(choose_grid(box(Vec3d(0), Vec3d(1)), 0.0, 0.0).bits, max_position_bits);
}

}  // namespace
}  // namespace lodestream::codec
