#include "common/simulate/device.h"

#include <algorithm>
#include <cmath>

#include "common/control/motion_blur.h"

namespace lodestream::simulate {

namespace {

constexpr double throttles_above = 0.5;
constexpr double least_noise_factor = 0.5, most_noise_factor = 2.0;
constexpr double fixed_share = 0.1;
constexpr double picture_share = 0.2;  // of what pixels take: once, not for each exposure

double busy_ms(const control::FrameCosts& costs, const control::Work& work) {
    control::Work alone = work;
    alone.background_load = 0.0;
    return control::frame_ms(costs, alone);
}

double throttle(const Device& device, double heat) {
    const double share = std::clamp((heat - throttles_above) / (1.0 - throttles_above), 0.0, 1.0);
    return 1.0 + (device.throttled_factor - 1.0) * share;
}

double chance_factor(const Device& device, Random& random) {
    const double noise = std::clamp(std::exp(device.noise * random.normal()), least_noise_factor, most_noise_factor);
    return random.uniform() < device.spikes_per_frame ? noise * device.spike_factor : noise;
}

void pass_time(const Device& device, DeviceState& state, double busy_s, double interval_s) {
    const double target = busy_s / interval_s;
    state.heat += (target - state.heat) * (1.0 - std::exp(-interval_s / device.heat_up_s));
    state.decoding_left_s = std::max(state.decoding_left_s - interval_s, 0.0);
    if (state.random.uniform() < device.decodes_per_s * interval_s) state.decoding_left_s += device.decode_s;
}

}  // namespace

DeviceState switched_on(const Device& device) {
    return {0.0, 0.0, Random(device.seed)};
}

DrawnFrame draw(const Device& device, DeviceState state, const control::Work& work, double deadline_ms) {
    DrawnFrame out;
    const double decoding = state.decoding_left_s > 0.0 ? device.costs.background_ms : 0.0;
    out.frame_ms =
        (busy_ms(device.costs, work) + decoding) * throttle(device, state.heat) * chance_factor(device, state.random);
    const double interval_ms = std::max(out.frame_ms, deadline_ms);
    pass_time(device, state, out.frame_ms / 1000.0, interval_ms / 1000.0);
    out.background_load = state.decoding_left_s > 0.0 ? 1.0 : 0.0;
    out.state = state;
    return out;
}

Device calibrated(double triangles_per_second, double pixels_per_second, double fixed_ms) {
    Device device;
    device.costs.fixed_ms = fixed_ms;
    device.costs.per_million_seen_ms = 0.0;
    device.costs.per_million_triangles_ms = 1e9 / triangles_per_second;
    device.costs.per_million_pixels_ms = 0.0;
    device.costs.per_million_shaded_ms = 1e9 / pixels_per_second;
    device.costs.per_million_uploaded_ms = device.costs.per_million_triangles_ms;
    return device;
}

Device random_device(const Population& population, std::uint64_t seed) {
    Random random(seed);
    Device device;
    device.seed = random.next();
    const double least_ms = population.deadline_ms * random.uniform(0.40, 0.75);
    const double for_pixels = random.uniform(0.2, 0.7);  // of what the coarsest level takes
    const double for_shaded = (1.0 - picture_share) * for_pixels;
    const double exposures = control::max_exposures;
    device.costs.fixed_ms = fixed_share * least_ms;
    device.costs.per_million_seen_ms = 0.0;
    device.costs.per_million_pixels_ms = picture_share * for_pixels * least_ms / (population.pixels * 1e-6);
    device.costs.per_million_shaded_ms = for_shaded * least_ms / (exposures * population.pixels * 1e-6);
    device.costs.per_million_triangles_ms =
        (1.0 - for_pixels - fixed_share) * least_ms / (exposures * population.coarsest_triangles * 1e-6);
    device.costs.per_million_uploaded_ms = device.costs.per_million_triangles_ms * random.uniform(0.2, 1.0);
    device.costs.background_ms = population.deadline_ms * random.uniform(0.02, 0.15);
    device.noise = random.uniform(0.01, 0.06);
    device.spikes_per_frame = random.uniform(0.0, 0.004);
    device.spike_factor = random.uniform(1.2, 2.5);
    device.throttled_factor = random.uniform(1.0, 1.5);
    device.heat_up_s = random.log_uniform(3.0, 60.0);
    device.decodes_per_s = random.uniform(0.0, 0.5);
    device.decode_s = random.log_uniform(0.03, 0.6);
    return device;
}

}  // namespace lodestream::simulate
