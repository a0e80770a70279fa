#include "common/simplify/regions.h"

#include <gtest/gtest.h>

#include <random>
#include <thread>

namespace lodestream::simplify {
namespace {

std::vector<Vec3f> random_points(std::size_t count) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> within(-1.0f, 1.0f);
    std::vector<Vec3f> points;
    for (std::size_t i = 0; i < count; ++i) points.emplace_back(within(random), within(random), within(random));
    return points;
}

std::vector<std::uint32_t> every_second(std::size_t count) {
    std::vector<std::uint32_t> positions;
    for (std::uint32_t p = 0; p < count; p += 2) positions.push_back(p);
    return positions;
}

void expect_parts(const Regions& regions, const std::vector<std::uint32_t>& positions) {
    std::vector<std::uint32_t> all = regions.positions;
    std::sort(all.begin(), all.end());
    EXPECT_EQ(all, positions);
    for (std::size_t r = 0; r < regions.size(); ++r) {
        EXPECT_TRUE(std::is_sorted(regions.in(r).begin(), regions.in(r).end()));
        for (const std::uint32_t p : regions.in(r)) EXPECT_EQ(regions.of[p], r);
    }
}

TEST(Regions, HoldEveryPositionOnceAndAreAlikeInSize) {
    const std::vector<Vec3f> points = random_points(40000);
    const std::vector<std::uint32_t> positions = every_second(points.size());
    for (const std::size_t count : {1u, 2u, 3u, 6u, 17u}) {
        const Regions regions = divide(positions, points, count, 1, {});
        ASSERT_EQ(regions.size(), count);
        expect_parts(regions, positions);
        const double fair = static_cast<double>(positions.size()) / static_cast<double>(count);
        for (std::size_t r = 0; r < count; ++r) {
            EXPECT_GT(static_cast<double>(regions.in(r).size()), 0.7 * fair) << r << " of " << count;
            EXPECT_LT(static_cast<double>(regions.in(r).size()), 1.3 * fair) << r << " of " << count;
        }
    }
}

TEST(Regions, ArePartedElsewhereInTheNextRound) {
    const std::vector<Vec3f> points = random_points(20000);
    const std::vector<std::uint32_t> positions = every_second(points.size());
    const Regions first = divide(positions, points, 2, 0, {}), second = divide(positions, points, 2, 1, {});
    std::size_t together = 0;  // of each region those that are in the same one again
    for (const std::uint32_t p : positions) together += first.of[p] == second.of[p];
    const double share = static_cast<double>(together) / static_cast<double>(positions.size());
    EXPECT_GT(std::min(share, 1 - share), 0.05);
}

TEST(Regions, AreTheSameForEveryExecutor) {
    const std::vector<Vec3f> points = random_points(100000);
    const std::vector<std::uint32_t> positions = every_second(points.size());
    const Executor threads = [](std::size_t count, const std::function<void(std::size_t)>& task) {
        std::vector<std::jthread> all;
        for (std::size_t k = count; k-- > 0;) all.emplace_back([&task, k] { task(k); });
    };
    EXPECT_EQ(divide(positions, points, 8, 2, {}).positions, divide(positions, points, 8, 2, threads).positions);
}

TEST(Regions, TakePointsThatNoPlaneParts) {
    std::vector<Vec3f> points(1000, Vec3f{2.0f});
    expect_parts(divide(every_second(points.size()), points, 4, 0, {}), every_second(points.size()));
    points[0] = Vec3f{1e16f};  // the others are not to fall into one region for it
    expect_parts(divide(every_second(points.size()), points, 4, 3, {}), every_second(points.size()));
    expect_parts(divide({}, {}, 3, 0, {}), {});
}

}  // namespace
}  // namespace lodestream::simplify
