#include "common/control/budget_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/base/random.h"
#include "common/control/control.h"

namespace lodestream::control {
namespace {

constexpr double deadline_ms = 1000.0 / 60.0;
constexpr std::uint32_t width = 800, height = 600;

// A device with costs of its own, of which the loop knows nothing but the frames.
struct Device {
    FrameCosts costs{1.0, 50.0, 1.0, 50.0, 5.0, 3.0};
    double slower = 1.0;
    double noise = 0.0;
    Random random{3};

    double frame_ms(const Work& work) {
        const double ms = costs.fixed_ms + 1e-6 * (work.triangles * costs.per_million_triangles_ms +
                                                   work.pixels * costs.per_million_pixels_ms +
                                                   work.shaded_px * costs.per_million_shaded_ms);
        return ms * slower * (1.0 + noise * (2.0 * random.uniform() - 1.0));
    }
    double triangles_per_second() const {
        const double left_ms = deadline_ms / slower - costs.fixed_ms -
                               1e-6 * width * height * (costs.per_million_pixels_ms + costs.per_million_shaded_ms);
        return 60e6 * left_ms / costs.per_million_triangles_ms;
    }
};

struct Loop {
    Device device;
    FrameCosts first_guess;
    BudgetLoopState state;
    double level_share = 1.0;  // of the budget, drawn
    std::vector<double> asked_at_s;
    double budget = 1e5, t_s = 0.0;
    std::uint32_t window = width;

    void fly(double seconds) {
        for (const double end_s = t_s + seconds; t_s < end_s;) {
            Work work;
            work.triangles = work.seen_triangles = std::round(level_share * budget);
            work.pixels = work.shaded_px = width * height;
            const double ms = device.frame_ms(work);
            const double interval_s = std::max(ms, deadline_ms) / 1000.0;
            t_s += interval_s;
            see({work, ms, interval_s, window, height});
        }
    }
    void see(const DrawnFrame& frame) {
        BudgetLoopStep taken = follow(std::move(state), frame, first_guess, deadline_ms);
        state = std::move(taken.state);
        if (!taken.wish) return;
        asked_at_s.push_back(t_s);
        budget = taken.wish->triangles_per_second / 60.0;
    }
};

TEST(BudgetLoop, FindsWhatADeviceDrawsAndThenKeepsStill) {
    Loop loop;
    loop.fly(30.0);
    const std::size_t asked = loop.asked_at_s.size();
    EXPECT_LE(asked, 5u);
    EXPECT_NEAR(60.0 * loop.budget / loop.device.triangles_per_second(), 0.88, 0.25) << "with what safety takes";
    loop.fly(300.0);
    EXPECT_EQ(loop.asked_at_s.size(), asked);
}

TEST(BudgetLoop, FollowsADeviceThatThrottlesAndOneThatRecovers) {
    Loop loop;
    loop.device.noise = 0.05;
    loop.fly(30.0);
    const double before = loop.budget;
    loop.device.slower = 2.0;
    loop.fly(20.0);
    EXPECT_LT(loop.budget, 0.65 * before);
    EXPECT_GT(loop.budget, 0.25 * before);
    const double settled_s = loop.asked_at_s.back();
    EXPECT_LT(settled_s, 45.0);
    loop.device.slower = 1.0;
    loop.fly(20.0);
    EXPECT_GT(loop.budget, 0.75 * before);
    EXPECT_LT(loop.budget, 1.3 * before);
}

TEST(BudgetLoop, NoiseAsksForNothing) {
    Loop loop;
    loop.device.noise = 0.1;
    loop.fly(30.0);
    const std::size_t asked = loop.asked_at_s.size();
    loop.fly(600.0);
    EXPECT_EQ(loop.asked_at_s.size(), asked);
}

TEST(BudgetLoop, ACoarseLevelDoesNotMakeADeviceLookSlow) {
    Loop loop;
    loop.fly(30.0);
    const double before = loop.budget;
    loop.level_share = 0.02;
    loop.fly(60.0);
    EXPECT_GT(loop.budget, 0.7 * before);
    EXPECT_LT(loop.budget, 1.4 * before);
}

TEST(BudgetLoop, AnotherWindowAsksAgainOnce) {
    Loop loop;
    loop.fly(30.0);
    const std::size_t asked = loop.asked_at_s.size();
    loop.window = 1'920;
    loop.fly(30.0);
    EXPECT_EQ(loop.asked_at_s.size(), asked + 1);
    EXPECT_EQ(loop.state.planned.width, 1'920u);
}

// Also an alternation as fast as frames are.
TEST(BudgetLoop, IsSpacedAndFiniteWhateverIsMeasured) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
    const std::vector<double> times{nan, infinite, -infinite, 0.0, -5.0, 1e-9, 16.0, 1e9, 1e300};
    Random random(8);
    Loop loop;
    for (int i = 0; i < 20'000; ++i) {
        const auto any = [&] { return times[random.next() % times.size()]; };
        Work work;
        work.level = static_cast<std::uint32_t>(random.next() % max_levels);
        work.triangles = random.log_uniform(1.0, 1e9);
        work.pixels = random.log_uniform(1.0, 1e9);
        const double interval_s = i % 5 == 0 ? any() : random.uniform(0.0, 0.05);
        if (interval_s > 0.0 && std::isfinite(interval_s)) loop.t_s += std::min(interval_s, max_interval_s);
        loop.see({work, any(), interval_s, static_cast<std::uint32_t>(random.next()), height});
        ASSERT_TRUE(std::isfinite(loop.budget) && loop.budget > 0.0);
        ASSERT_GE(loop.state.planned.triangles_per_second, 1.0);
        ASSERT_LE(loop.state.planned.triangles_per_second, fast_as_measured);
    }
    for (std::size_t i = 1; i < loop.asked_at_s.size(); ++i)
        EXPECT_GE(loop.asked_at_s[i] - loop.asked_at_s[i - 1], replan_interval_s - 1e-6);
}

// A plan that changes the level, which changes the frame, is what could swing.
TEST(BudgetLoop, NeverSwings) {
    Random random(21);
    for (int round = 0; round < 200; ++round) {
        Loop loop;
        loop.device.costs = {random.log_uniform(0.1, 10.0), random.log_uniform(1.0, 1'000.0),
                             random.log_uniform(0.1, 10.0), 1.0, 1.0};
        loop.device.noise = random.uniform(0.0, 0.05);
        loop.budget = random.log_uniform(1.0, 1e7);
        loop.fly(60.0);
        const std::size_t asked = loop.asked_at_s.size();
        loop.fly(120.0);
        EXPECT_LE(loop.asked_at_s.size(), asked + 1) << round;
    }
}

}  // namespace
}  // namespace lodestream::control
