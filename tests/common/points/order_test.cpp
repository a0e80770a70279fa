#include "common/points/order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/base/random.h"
#include "common/points/resample.h"
#include "tests/support/meshes.h"
#include "tests/support/threads.h"

namespace lodestream::points {
namespace {

PointCloud random_sphere(std::size_t count) {
    Random random(1);
    PointCloud cloud;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3d p = normalize(Vec3d(random.normal(), random.normal(), random.normal()));
        cloud.positions.emplace_back(p);
        cloud.normals.emplace_back(p);
    }
    return cloud;
}

double nearest_to(const Vec3f& p, const PointCloud& cloud, std::size_t first, std::size_t last) {
    double nearest = 1e30;
    for (std::size_t i = first; i < last; ++i) {
        const double apart = glm::length(Vec3d(cloud.positions[i]) - Vec3d(p));
        if (dot(cloud.normals[i], p) >= 0.0f) nearest = std::min(nearest, apart);
    }
    return nearest;
}

TEST(Order, BudgetsOfZeroOneAndMoreThanThereAre) {
    const PointCloud cloud = random_sphere(500);
    EXPECT_TRUE(order(cloud, 0).cloud.positions.empty());
    EXPECT_EQ(order(cloud, 1).cloud.positions.size(), 1u);
    EXPECT_EQ(order(cloud, ~0ull).cloud.positions.size(), 500u);
    EXPECT_TRUE(order({}, 10).cloud.positions.empty());
}

TEST(Order, IsAChoiceOfTheGivenPoints) {
    PointCloud cloud = random_sphere(2000);
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) cloud.colors.emplace_back(i % 256, i / 256, 0, 255);
    const OrderedCloud ordered = order(cloud, 2000);
    std::vector<bool> used(cloud.positions.size(), false);
    for (std::size_t i = 0; i < ordered.cloud.positions.size(); ++i) {
        const std::size_t id = ordered.cloud.colors[i].r + 256u * ordered.cloud.colors[i].g;
        ASSERT_EQ(ordered.cloud.positions[i], cloud.positions[id]);
        ASSERT_EQ(ordered.cloud.normals[i], cloud.normals[id]);
        ASSERT_FALSE(used[id]);
        used[id] = true;
    }
}

TEST(Order, ShorterBudgetIsAPrefix) {
    const PointCloud cloud = random_sphere(3000);
    const OrderedCloud all = order(cloud, 3000), some = order(cloud, 700);
    ASSERT_EQ(some.cloud.positions.size(), 700u);
    EXPECT_TRUE(std::equal(some.cloud.positions.begin(), some.cloud.positions.end(), all.cloud.positions.begin()));
}

TEST(Order, SpacingsFallAndBoundHoles) {
    const PointCloud cloud = random_sphere(20'000);
    const OrderedCloud ordered = order(cloud, 4000);
    EXPECT_TRUE(std::is_sorted(ordered.spacings.rbegin(), ordered.spacings.rend()));
    for (const std::size_t count : {10u, 100u, 500u, 4000u}) {
        double hole = 0.0;
        for (std::size_t i = 0; i < cloud.positions.size(); i += 7)
            hole = std::max(hole, nearest_to(cloud.positions[i], ordered.cloud, 0, count));
        EXPECT_LT(hole, 1.35 * ordered.spacings[count - 1]) << count;
    }
}

TEST(Order, PointsOfAPrefixKeepTheirDistance) {
    const OrderedCloud ordered = order(random_sphere(20'000), 4000);
    for (const std::size_t count : {10u, 100u, 500u, 4000u})
        for (std::size_t i = 0; i < count; i += 3)
            ASSERT_GE(nearest_to(ordered.cloud.positions[i], ordered.cloud, 0, i), 0.999 * ordered.spacings[count - 1]);
}

// Half as many points leave holes about √2 times as wide: nowhere is a whole pass missing on one side.
TEST(Order, EveryPrefixIsSpreadOverTheWholeSurface) {
    const OrderedCloud ordered = order(random_sphere(30'000), 8000);
    for (std::size_t count = 400; count < 8000; count += 379) {
        std::array<int, 8> octants{};
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3f& p = ordered.cloud.positions[i];
            ++octants[(p.x > 0) + 2u * (p.y > 0) + 4u * (p.z > 0)];
        }
        const auto [least, most] = std::minmax_element(octants.begin(), octants.end());
        EXPECT_LT(*most, 1.35 * *least) << count;
    }
}

TEST(Order, BothSidesOfAThinSheetAreKept) {
    PointCloud cloud;
    for (int k = 0; k < 10'000; ++k) {
        const float x = static_cast<float>(k % 100), z = static_cast<float>(k / 100 % 100);
        for (const float side : {-1.0f, 1.0f}) {
            cloud.positions.emplace_back(x, 0.01f * side, z);
            cloud.normals.emplace_back(0.0f, side, 0.0f);
        }
    }
    const OrderedCloud ordered = order(cloud, 400);
    const auto up = std::count_if(ordered.cloud.normals.begin(), ordered.cloud.normals.end(),
                                  [](const Vec3f& n) { return n.y > 0.0f; });
    EXPECT_NEAR(static_cast<double>(up), 200.0, 40.0);
}

TEST(Order, PointsInOnePlaceAreOne) {
    PointCloud cloud;
    cloud.positions.assign(1000, Vec3f(3, 2, 1));
    EXPECT_EQ(order(cloud, 1000).cloud.positions.size(), 1u);
}

TEST(Order, CloudWithoutNormals) {
    PointCloud cloud = random_sphere(1000);
    cloud.normals.clear();
    const OrderedCloud ordered = order(cloud, 300);
    EXPECT_EQ(ordered.cloud.positions.size(), 300u);
    EXPECT_TRUE(ordered.cloud.normals.empty());
}

TEST(Order, HugeAndTinyCloudsAreOrderedAlike) {
    const PointCloud cloud = random_sphere(3000);
    const OrderedCloud same = order(cloud, 1000);
    for (const float factor : {0x1p30f, 0x1p-30f}) {
        PointCloud other = cloud;
        for (Vec3f& p : other.positions) p *= factor;
        const OrderedCloud ordered = order(other, 1000);
        for (std::size_t i = 0; i < 1000; ++i)
            ASSERT_EQ(ordered.cloud.positions[i], same.cloud.positions[i] * factor) << i;
    }
}

TEST(Order, TenMillionPoints) {
    Random random(2);
    PointCloud cloud;
    cloud.positions.reserve(10'000'000);
    for (int i = 0; i < 10'000'000; ++i)
        cloud.positions.emplace_back(random.uniform(), random.uniform(), std::round(random.uniform()));
    const OrderedCloud ordered = order(cloud, 100'000);
    EXPECT_EQ(ordered.cloud.positions.size(), 100'000u);
    EXPECT_LT(ordered.spacings.back(), 0.01f);
}

TEST(Order, IsTheSameForEveryExecutor) {
    const PointCloud cloud = random_sphere(120'000);
    const OrderedCloud alone = order(cloud, 60'000);
    const simplify::Executor backwards = [](std::size_t count, const std::function<void(std::size_t)>& task) {
        for (std::size_t k = count; k-- > 0;) task(k);
    };
    for (const simplify::Executor& executor : {backwards, simplify::Executor(testing::on_threads)}) {
        const OrderedCloud ordered = order(cloud, 60'000, executor);
        EXPECT_EQ(ordered.cloud.positions, alone.cloud.positions);
        EXPECT_EQ(ordered.spacings, alone.spacings);
    }
}

}  // namespace
}  // namespace lodestream::points
