// Many simulated devices under every controller on many motions: who keeps the deadline.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/control/flight.h"
#include "common/motion/motion.h"
#include "common/simulate/device.h"

namespace lodestream::simulate {

struct NamedTrace {
    std::string name;  // "nod, 240 degrees/s"
    motion::Trace trace;
};

inline constexpr std::size_t trace_count = 20;

// Every built-in motion, slow and fast, and mixes of nine seeds. pre: seconds within built_in()'s range
std::array<NamedTrace, trace_count> sweep_traces(double seconds);

struct SweepOptions {
    std::vector<control::Level> ladder = {{200'000, 0.0}, {100'000, 0.3}, {50'000, 0.7}, {25'000, 1.5}, {12'500, 3.0}};
    Population population{200'000, 12'500, 5e5, 1000.0 / 60.0};
    double target_fps = 60.0;
    double probe_error = 0.15;  // standard deviation of what the probe says of each cost, as a share
};

// The controllers in the order of control::kinds.
using PerController = std::array<control::FlightSummary, std::size(control::kinds)>;

// One device on one motion, the same chance for every controller. Errors: those of control::fly().
Result<PerController> fly_all(const SweepOptions& options, const Device& device, const motion::Trace& trace);

// Devices first … first + count - 1 by their seeds; [device][trace]. Pure, so that ranges may run at once.
Result<std::vector<std::array<PerController, trace_count>>> sweep(const SweepOptions& options,
                                                                  const std::array<NamedTrace, trace_count>& traces,
                                                                  std::uint64_t first, std::uint64_t count);

}  // namespace lodestream::simulate
