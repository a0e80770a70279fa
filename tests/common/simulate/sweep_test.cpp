// The sweep's smaller version; tests/common/simulate/sweep_devices.cpp is the whole.
#include "common/simulate/sweep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "common/base/random.h"

namespace lodestream::simulate {
namespace {

constexpr std::size_t predictive = std::size(control::kinds) - 1;

TEST(Sweep, HasTwentyDifferentMotions) {
    std::set<std::string> names;
    for (const NamedTrace& trace : sweep_traces(4.0)) {
        names.insert(trace.name);
        EXPECT_NEAR(motion::duration_s(trace.trace), 4.0, 0.011) << trace.name;
    }
    EXPECT_EQ(names.size(), trace_count);
}

// What shares of frames the controllers keep the deadline in, over the devices.
using Kept = std::array<double, predictive + 1>;

void expect_predictive_keeps_most(const Kept& kept, const std::string& motion) {
    for (std::size_t kind = 0; kind < predictive; ++kind)
        EXPECT_GE(kept[predictive], kept[kind]) << motion << ", " << control::kind_name(control::kinds[kind]);
}

TEST(Sweep, PredictiveKeepsTheDeadlineAtLeastAsOftenAsEveryOtherOnEveryMotion) {
    const auto traces = sweep_traces(8.0);
    const auto flown = sweep({}, traces, 5000, 30);
    ASSERT_TRUE(flown);
    ASSERT_EQ(flown->size(), 30u);
    for (std::size_t t = 0; t < trace_count; ++t) {
        Kept kept{};
        for (const auto& device : *flown)
            for (std::size_t kind = 0; kind < kept.size(); ++kind) kept[kind] += device[t][kind].within_deadline / 30.0;
        expect_predictive_keeps_most(kept, traces[t].name);
        EXPECT_GE(kept[predictive], 0.99) << traces[t].name;
    }
}

// Motions of which no controller's constants know: headings by a function of the time, made anew for every seed.
using Heading = std::function<double(double t_s)>;
struct UnknownMotion {
    const char* name;
    double least_kept;
    Heading (*heading)(Random& random);
};

Heading drifting(Random& random) {
    return [&random, speed = 0.0, yaw = 0.0](double) mutable {
        speed = 0.98 * speed + 30.0 * random.normal();
        return yaw += speed * motion::sample_interval_s;
    };
}

Heading starts_and_stops(Random& random) {
    return [&random, speed = 0.0, yaw = 0.0, next_s = 0.0](double t_s) mutable {
        if (t_s >= next_s) {
            speed = random.uniform() < 0.4 ? 0.0 : random.uniform(-300.0, 300.0);
            next_s = t_s + random.uniform(0.05, 1.5);
        }
        return yaw += speed * motion::sample_interval_s;
    };
}

Heading shakes(Random& random) {
    const double slow = random.uniform(0.6, 20.0), fast = random.uniform(0.6, 40.0);  // radians/s
    return [slow, fast](double t_s) { return 40.0 * std::sin(slow * t_s) + 15.0 * std::sin(fast * t_s); };
}

Heading trembles(Random& random) {
    return [&random, yaw = 0.0](double t_s) mutable {
        return yaw += 0.3 * random.normal() + (std::fmod(t_s, 2.0) < 1.0 ? 1.0 : 0.0);
    };
}

// The view is elsewhere from one sample to the next.
Heading jumps(Random& random) {
    return [&random, yaw = 0.0, next_s = 0.0](double t_s) mutable {
        if (t_s < next_s) return yaw;
        next_s = t_s + random.uniform(0.1, 0.8);
        return yaw += random.uniform(-90.0, 90.0);
    };
}

const UnknownMotion unknown_motions[] = {{"drifting", 0.99, drifting},
                                         {"starts and stops", 0.99, starts_and_stops},
                                         {"shakes", 0.99, shakes},
                                         {"trembles", 0.99, trembles},
                                         {"jumps", 0.97, jumps}};

motion::Trace trace_of(const UnknownMotion& motion, std::uint64_t seed) {
    Random random(seed);
    const Heading heading = motion.heading(random);
    motion::Trace trace;
    for (double t_s = 0.0; t_s < 6.0; t_s += motion::sample_interval_s)
        trace.push_back({t_s, {std::nullopt, std::remainder(heading(t_s), 360.0), 0.0}});
    return trace;
}

TEST(Sweep, PredictiveKeepsTheDeadlineOnMotionsThatItWasNotMadeFor) {
    constexpr std::uint64_t seeds = 3, devices = 12;
    const SweepOptions options;
    for (const UnknownMotion& motion : unknown_motions) {
        Kept kept{};
        for (std::uint64_t seed = 1; seed <= seeds; ++seed)
            for (std::uint64_t device = 0; device < devices; ++device) {
                const auto flown =
                    fly_all(options, random_device(options.population, 7000 + device), trace_of(motion, seed));
                ASSERT_TRUE(flown);
                for (std::size_t kind = 0; kind < kept.size(); ++kind)
                    kept[kind] += (*flown)[kind].within_deadline / (seeds * devices);
            }
        expect_predictive_keeps_most(kept, motion.name);
        EXPECT_GE(kept[predictive], motion.least_kept) << motion.name;
    }
}

TEST(Sweep, RangesOfDevicesJoin) {
    const auto traces = sweep_traces(1.0);
    const auto all = sweep({}, traces, 0, 2), second = sweep({}, traces, 1, 1);
    ASSERT_TRUE(all && second);
    for (std::size_t kind = 0; kind <= predictive; ++kind)
        EXPECT_EQ((*all)[1][3][kind].average_fps, (*second)[0][3][kind].average_fps);
}

TEST(Sweep, SaysWhatCannotBeFlown) {
    SweepOptions options;
    options.ladder.clear();
    EXPECT_FALSE(sweep(options, sweep_traces(1.0), 0, 1));
}

}  // namespace
}  // namespace lodestream::simulate
