#include "common/simplify/edge_queue.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace lodestream::simplify {
namespace {

std::vector<int> emptied(EdgeQueue& queue) {
    std::vector<int> order;
    for (; queue.find_front(); queue.pop()) order.push_back(queue.front().idx());
    return order;
}

TEST(EdgeQueue, TakesOutTheCheapestFirstToWithinASixteenth) {
    std::mt19937 random(7);
    std::vector<float> costs;
    EdgeQueue queue;
    for (int i = 0; i < 5000; ++i) {
        costs.push_back(std::ldexp(static_cast<float>(random() % 1000 + 1), static_cast<int>(random() % 200) - 120));
        queue.push(EdgeHandle(i), costs.back());
    }
    float dearest = 0;
    std::size_t taken = 0;
    for (; queue.find_front(); queue.pop(), ++taken) {
        const float cost = costs[static_cast<std::size_t>(queue.front().idx())];
        EXPECT_LE(cost, queue.front_cost());
        EXPECT_GE(cost * (1 + 1 / 16.0f), dearest);
        dearest = std::max(dearest, cost);
    }
    EXPECT_EQ(taken, costs.size());
}

TEST(EdgeQueue, FindsACheaperEdgeThatIsPutInLater) {
    EdgeQueue queue;
    queue.push(EdgeHandle(1), 8.0f);
    ASSERT_TRUE(queue.find_front());
    queue.push(EdgeHandle(2), 1.0f);
    EXPECT_EQ(emptied(queue), (std::vector<int>{2, 1}));
    EXPECT_FALSE(queue.find_front());
}

TEST(EdgeQueue, HoldsCostsOfNothingAndTheLargestThereAre) {
    EdgeQueue queue;
    queue.push(EdgeHandle(1), std::numeric_limits<float>::max());
    queue.push(EdgeHandle(2), 0.0f);
    queue.push(EdgeHandle(3), std::numeric_limits<float>::denorm_min());
    ASSERT_TRUE(queue.find_front());
    EXPECT_GT(queue.front_cost(), 0.0f);
    EXPECT_EQ(emptied(queue).back(), 1);
}

TEST(EdgeQueue, TakesEdgesInAgainAfterTheyWereTakenOut) {
    EdgeQueue queue;
    for (int round = 0; round < 3; ++round) {
        for (int i = 0; i < 10; ++i) queue.push(EdgeHandle(i), static_cast<float>(10 - i));
        EXPECT_EQ(emptied(queue), (std::vector<int>{9, 8, 7, 6, 5, 4, 3, 2, 1, 0}));
    }
}

}  // namespace
}  // namespace lodestream::simplify
