// What no controller may be thrown by: every output stays finite and in range, and after the disturbance it settles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "common/base/random.h"
#include "common/control/control.h"

namespace lodestream::control {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double day_s = 86'400.0;
const std::vector<Level> ladder{{200'000, 0.0}, {100'000, 0.3}, {50'000, 0.7}, {25'000, 1.5}, {12'500, 3.0}};

void expect_finite(const State& state) {
    EXPECT_LT(state.level, ladder.size());
    EXPECT_TRUE(std::isfinite(state.speed_deg_s));
    EXPECT_TRUE(std::isfinite(state.error_px));
    const PredictiveState& p = state.predictive;
    EXPECT_TRUE(std::isfinite(p.model.spread));
    for (std::size_t i = 0; i < FrameTimeModel::size; ++i) {
        EXPECT_TRUE(std::isfinite(p.model.share[i]));
        for (std::size_t j = 0; j < FrameTimeModel::size; ++j) EXPECT_TRUE(std::isfinite(p.model.covariance[i][j]));
    }
    for (const double factor : p.model.level_factor) EXPECT_TRUE(std::isfinite(factor));
    for (const double since_s : p.since_switches_s) EXPECT_TRUE(std::isfinite(since_s));
    EXPECT_TRUE(std::isfinite(p.since_switch_s));
}

// A device with 3 % of noise; level 1 fits when still, level 3 when turning fast.
class Flight {
  public:
    explicit Flight(Kind kind) : kind_(kind) {}

    // One step with what is given; the answer is checked, and the device draws it.
    Decision step(Measurement now) {
        Step taken = control::step(kind_, ladder, options_, std::move(state_), now);
        state_ = std::move(taken.state);
        expect_finite(state_);
        const Decision& decision = taken.decision;
        EXPECT_LT(decision.level, ladder.size());
        EXPECT_GE(decision.exposures, 1u);
        EXPECT_LE(decision.exposures, max_exposures);
        if (decision.predicted_ms) {
            EXPECT_TRUE(std::isfinite(*decision.predicted_ms));
            EXPECT_GT(*decision.predicted_ms, 0.0);
        }
        drawn_ms_ = frame_ms(decision);
        clock_s_ += std::isnan(now.interval_s) ? 0.0 : std::clamp(now.interval_s, 0.0, max_interval_s);
        if (decision.switched) switch_times_s_.push_back(clock_s_);
        return decision;
    }
    // As step(), with the time and the frame of an undisturbed device.
    Decision draw(double speed_deg_s, double budget_triangles = infinity) {
        return step({std::max(drawn_ms_, 1000.0 / 60.0) / 1000.0, speed_deg_s, 5e5, drawn_ms_, 0.0, budget_triangles});
    }
    // Frames until the last switch of many even ones.
    std::uint32_t settles_after(double speed_deg_s) {
        std::uint32_t last = 0;
        for (std::uint32_t i = 1; i <= 2000; ++i)
            if (draw(speed_deg_s).switched) last = i;
        return last;
    }
    std::size_t most_switches_in_a_second() const {
        std::size_t most = 0;
        for (auto begin = switch_times_s_.begin(); begin != switch_times_s_.end(); ++begin) {
            const auto end = std::upper_bound(begin, switch_times_s_.end(), *begin + 1.0 - 1e-9);
            most = std::max(most, static_cast<std::size_t>(end - begin));
        }
        return most;
    }
    double last_ms() const { return drawn_ms_; }

  private:
    double frame_ms(const Decision& decision) {
        const auto triangles = static_cast<double>(ladder[decision.level].triangles);
        const double ms =
            1.0 + decision.exposures * (triangles * 1e-4 + 2.0) + (decision.switched ? triangles * 5e-5 : 0);
        return ms * std::exp(0.03 * random_.normal());
    }

    Kind kind_;
    Options options_;
    State state_;
    Random random_{11};
    double drawn_ms_ = nan;
    double clock_s_ = 0.0;
    std::vector<double> switch_times_s_;
};

using Disturbance = std::function<void(Flight&)>;

// Every controller through the disturbance; those that promise to settle do.
void expect_stable(const Disturbance& disturb) {
    for (const Kind kind : kinds) {
        SCOPED_TRACE(kind_name(kind));
        Flight flight(kind);
        for (int i = 0; i < 60; ++i) flight.draw(0.0);
        disturb(flight);
        const std::uint32_t frames = flight.settles_after(20.0);
        if (kind == Kind::predictive) {
            EXPECT_LE(frames, settle_frames);
            EXPECT_LE(flight.most_switches_in_a_second(), max_switches_per_s);
        } else if (kind != Kind::reactive) {  // whose accepted error never comes to rest between two levels
            EXPECT_LE(frames, ladder.size());
        }
    }
}

TEST(Stiff, SpeedStepsOfAMillionDegrees) {
    expect_stable([](Flight& flight) {
        for (int i = 0; i < 600; ++i) flight.draw(i % 20 < 10 ? 1e6 : 0.0);
    });
}

TEST(Stiff, SpeedAlternatesBetweenZeroAndTheMostEveryFrame) {
    expect_stable([](Flight& flight) {
        for (int i = 0; i < 600; ++i) flight.draw(i % 2 == 0 ? 0.0 : 1e300);
    });
}

TEST(Stiff, SamplesThatAreNotNumbersOrMissing) {
    expect_stable([](Flight& flight) {
        const double odd[] = {nan, infinity, -infinity, -1.0, 0.0, 1e308};
        for (const double a : odd)
            for (const double b : odd)
                for (const double c : odd) {
                    flight.step({a, b, c, nan, a, b});
                    flight.step({1.0 / 60.0, c, 5e5, a, b, c});
                    flight.step({b, 30.0, a, c, c, infinity});
                }
    });
}

TEST(Stiff, AClockThatGoesBackwards) {
    expect_stable([](Flight& flight) {
        for (int i = 0; i < 600; ++i) flight.step({i % 3 == 0 ? -5.0 : 0.016, i % 100 * 2.0, 5e5, flight.last_ms()});
    });
}

TEST(Stiff, AClockThatStandsStill) {
    expect_stable([](Flight& flight) {
        for (int i = 0; i < 600; ++i) flight.step({0.0, i % 100 * 2.0, 5e5, flight.last_ms()});
    });
}

TEST(Stiff, FramesThatTakeNoTimeOrADay) {
    expect_stable([](Flight& flight) {
        for (int i = 0; i < 300; ++i) {
            flight.step({0.0, 0.0, 5e5, 0.0});
            flight.step({day_s, 50.0, 5e5, day_s * 1000.0});
        }
    });
}

TEST(Stiff, ManyFramesOfADayThenNone) {
    expect_stable([](Flight& flight) {
        for (int i = 0; i < 100; ++i) flight.step({day_s, 0.0, 5e5, day_s * 1000.0});
        for (int i = 0; i < 100; ++i) flight.step({1e-9, 0.0, 5e5, 1e-9});
    });
}

TEST(Stiff, BudgetsThatJumpAMillionfold) {
    expect_stable([](Flight& flight) {
        for (int i = 0; i < 600; ++i) flight.draw(0.0, i % 2 == 0 ? 1.0 : 1e6);
    });
}

TEST(Stiff, AnythingAtAll) {
    expect_stable([](Flight& flight) {
        Random random(5);
        const auto any = [&] { return random.uniform() < 0.1 ? nan : random.log_uniform(1e-12, 1e12); };
        for (int i = 0; i < 3000; ++i) flight.step({any(), any(), any(), any(), any(), any()});
    });
}

}  // namespace
}  // namespace lodestream::control
