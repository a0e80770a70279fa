#include "common/simulate/sweep.h"

#include <cmath>

namespace lodestream::simulate {

namespace {

constexpr double slow_deg_s = 60.0, fast_deg_s = 240.0;
constexpr std::uint64_t mixes = 9;

NamedTrace named(motion::Kind kind, double seconds, double fastest_deg_s, std::uint64_t seed, const std::string& what) {
    return {motion::kind_name(kind) + (", " + what), *motion::built_in({kind, seconds, fastest_deg_s, seed})};
}

// What a probe would say of the device: its costs, each a little wrong.
control::FrameCosts probed(const Device& device, double error) {
    Random random(~device.seed);
    control::FrameCosts costs = device.costs;
    for (double* cost : {&costs.fixed_ms, &costs.per_million_triangles_ms, &costs.per_million_pixels_ms,
                         &costs.per_million_shaded_ms, &costs.per_million_uploaded_ms, &costs.background_ms})
        *cost *= std::exp(error * random.normal());
    return costs;
}

Result<control::FlightSummary> fly_one(const control::Flight& flight, const Device& device,
                                       const motion::Trace& trace) {
    DeviceState state = switched_on(device);
    const double deadline = control::deadline_ms(flight.options);
    const auto frames = control::fly(flight, trace, [&](const control::FrameRequest& request) {
        const control::Level& level = flight.ladder[request.level];
        const auto triangles = static_cast<double>(level.triangles);
        DrawnFrame drawn = draw(device, state,
                                {request.level, triangles, static_cast<double>(request.poses.size()), flight.pixels,
                                 request.switched ? triangles : 0.0, 0.0, flight.pixels, triangles},
                                deadline);
        state = drawn.state;
        return Result<control::FrameOutcome>({drawn.frame_ms, drawn.background_load, level.error_px});
    });
    if (!frames) return frames.error();
    return control::summarize(*frames, flight.options);
}

}  // namespace

std::array<NamedTrace, trace_count> sweep_traces(double seconds) {
    std::array<NamedTrace, trace_count> traces;
    std::size_t next = 0;
    traces[next++] = named(motion::Kind::still, seconds, fast_deg_s, 1, "0 °/s");
    for (const motion::Kind kind :
         {motion::Kind::start, motion::Kind::stop, motion::Kind::reversal, motion::Kind::nod, motion::Kind::circle})
        for (const double speed : {slow_deg_s, fast_deg_s})
            traces[next++] = named(kind, seconds, speed, 1, std::to_string(std::lround(speed)) + " °/s");
    for (std::uint64_t seed = 1; seed <= mixes; ++seed)
        traces[next++] = named(motion::Kind::mix, seconds, fast_deg_s, seed, "seed " + std::to_string(seed));
    return traces;
}

Result<PerController> fly_all(const SweepOptions& options, const Device& device, const motion::Trace& trace) {
    control::Flight flight{control::Kind::none, options.ladder, {}, options.population.pixels};
    flight.options.target_fps = options.target_fps;
    flight.options.predictive.first_guess = probed(device, options.probe_error);
    flight.options.speed = control::speed_options(options.ladder.size());
    PerController out;
    for (std::size_t i = 0; i < out.size(); ++i) {
        flight.kind = control::kinds[i];
        const auto flown = fly_one(flight, device, trace);
        if (!flown) return flown.error();
        out[i] = *flown;
    }
    return out;
}

Result<std::vector<std::array<PerController, trace_count>>> sweep(const SweepOptions& options,
                                                                  const std::array<NamedTrace, trace_count>& traces,
                                                                  std::uint64_t first, std::uint64_t count) {
    std::vector<std::array<PerController, trace_count>> out(count);
    for (std::uint64_t i = 0; i < count; ++i) {
        const Device device = random_device(options.population, first + i);
        for (std::size_t t = 0; t < traces.size(); ++t) {
            const auto flown = fly_all(options, device, traces[t].trace);
            if (!flown) return flown.error();
            out[i][t] = *flown;
        }
    }
    return out;
}

}  // namespace lodestream::simulate
