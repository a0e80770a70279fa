#include "common/simulate/device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/control/motion_blur.h"

namespace lodestream::simulate {
namespace {

constexpr double deadline_ms = 1000.0 / 60.0;
const control::Work work{0, 50'000, 2.0, 500'000, 0.0, 0.0, 500'000};

// Nothing but costs.
Device quiet() {
    Device device;
    device.noise = device.spikes_per_frame = device.decodes_per_s = 0.0;
    device.throttled_factor = 1.0;
    return device;
}

std::vector<DrawnFrame> frames(const Device& device, int count) {
    std::vector<DrawnFrame> out;
    DeviceState state = switched_on(device);
    for (int i = 0; i < count; ++i) {
        out.push_back(draw(device, state, work, deadline_ms));
        state = out.back().state;
    }
    return out;
}

TEST(Device, AFrameIsTheSumOfItsCosts) {
    Device device = quiet();
    device.costs = {1.0, 40.0, 2.0, 20.0, 5.0, 6.0};
    // 1 + 0.5 * 2 + 2 * (0.05 * 40 + 0.5 * 6) + 0
    EXPECT_NEAR(frames(device, 1)[0].frame_ms, 12.0, 1e-12);
    control::Work change = work;
    change.uploaded_triangles = 50'000;
    EXPECT_NEAR(draw(device, switched_on(device), change, deadline_ms).frame_ms, 13.0, 1e-12);
}

TEST(Device, TheSameSeedGivesTheSameFrames) {
    Device device;
    const auto a = frames(device, 300), b = frames(device, 300);
    device.seed = 2;
    const auto c = frames(device, 300);
    bool differs = false;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ASSERT_EQ(a[i].frame_ms, b[i].frame_ms);
        differs = differs || a[i].frame_ms != c[i].frame_ms;
    }
    EXPECT_TRUE(differs);
}

TEST(Device, NoiseAndSpikesAreAsAskedFor) {
    Device device = quiet();
    device.noise = 0.05;
    device.spikes_per_frame = 0.01;
    device.spike_factor = 3.0;
    const double expected = frames(quiet(), 1)[0].frame_ms;
    const auto drawn = frames(device, 10'000);
    double squares = 0.0;
    int spikes = 0;
    for (const DrawnFrame& frame : drawn) {
        if (frame.frame_ms > 2.0 * expected)
            ++spikes;
        else
            squares += std::pow(std::log(frame.frame_ms / expected), 2.0);
    }
    EXPECT_NEAR(spikes, 100, 35);
    EXPECT_NEAR(std::sqrt(squares / 10'000), 0.05, 0.003);
}

TEST(Device, GetsHotUnderLoadAndCoolsDown) {
    Device device = quiet();
    device.throttled_factor = 1.5;
    device.heat_up_s = 1.0;
    device.costs.fixed_ms = 30.0;
    const auto hot = frames(device, 600);
    EXPECT_NEAR(hot.back().frame_ms / hot.front().frame_ms, 1.5, 0.01);
    DeviceState state = hot.back().state;
    for (int i = 0; i < 600; ++i) state = draw(device, state, {}, 1000.0).state;
    EXPECT_NEAR(draw(device, state, work, deadline_ms).frame_ms, hot.front().frame_ms, 1e-6);
}

TEST(Device, DecodesComeAnnouncedAndCostTheirTime) {
    Device device = quiet();
    device.decodes_per_s = 2.0;
    device.decode_s = 0.2;
    device.costs.background_ms = 4.0;
    const auto drawn = frames(device, 2000);
    const double alone = frames(quiet(), 1)[0].frame_ms;
    int decoding = 0;
    for (std::size_t i = 1; i < drawn.size(); ++i) {
        EXPECT_NEAR(drawn[i].frame_ms - alone, 4.0 * drawn[i - 1].background_load, 1e-9);
        decoding += drawn[i - 1].background_load > 0.0 ? 1 : 0;
    }
    EXPECT_GT(decoding, 200);
    EXPECT_LT(decoding, 1200);
}

TEST(Device, CalibratedDrawsAtTheMeasuredRates) {
    Device device = calibrated(5e6, 1e8, 0.5);
    device.noise = device.spikes_per_frame = device.decodes_per_s = 0.0;
    // 0.5 + 2 * (50'000 / 5e6 + 500'000 / 1e8) s
    EXPECT_NEAR(frames(device, 1)[0].frame_ms, 30.5, 1e-9);
}

TEST(Device, EveryRandomOneCanShowTheCoarsestLevelInTime) {
    const Population population;
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        Device device = random_device(population, seed);
        device.noise = device.spikes_per_frame = 0.0;
        const control::Work coarsest{0,
                                     population.coarsest_triangles,
                                     control::max_exposures * 1.0,
                                     population.pixels,
                                     0.0,
                                     0.0,
                                     population.pixels};
        const double ms = draw(device, switched_on(device), coarsest, population.deadline_ms).frame_ms;
        EXPECT_LE(ms, 0.75 * population.deadline_ms + 1e-9);
        EXPECT_GE(ms, 0.40 * population.deadline_ms - 1e-9);
    }
}

}  // namespace
}  // namespace lodestream::simulate
