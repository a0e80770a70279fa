// The frame-rate part of a report's data: the ISBLC paper's scenario flown by every controller with the real renderer,
// what motion blur costs and hides, and the sweep over simulated devices.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/budget/budget.h"
#include "common/control/flight.h"

namespace lodestream::report {

struct FlightResult {
    std::string controller;
    control::FlightSummary summary;
    std::vector<control::FlownFrame> frames;
    double image_error_percent = 0.0;   // against the finest level at the same moments, mean over sampled frames
    std::optional<double> other_cores;  // kept busy by other processes meanwhile
};

// Frames of a fast turn with a number of exposures.
struct BlurResult {
    std::uint32_t exposures = 1;
    double frame_ms = 0.0;              // of the finest level
    double coarse_error_percent = 0.0;  // of the coarsest level's picture against the finest's, both so blurred
};

// A controller over all simulated devices on one motion.
struct SweepRow {
    std::string motion;
    std::string controller;
    double within_deadline = 0.0;  // share of the frames, mean over the devices
    double worst_device = 0.0;     // the least of them
    double deviation_fps = 0.0;
    double switches = 0.0;
    double error_px = 0.0;
};

// How a controller's flights over all devices and motions are distributed: the share of frames within the deadline, the
// least to the most in even steps.
struct SweepDistribution {
    std::string controller;
    std::vector<double> within_deadline;
};

struct FrameRateResult {
    std::string asset;
    std::string motion;
    double target_fps = 0.0;
    budget::Display screen;
    double fov_y_deg = 0.0;
    std::vector<control::Level> ladder;
    std::vector<FlightResult> flights;  // in the order of control::kinds
    std::vector<BlurResult> blur;
    std::uint64_t devices = 0;  // simulated
    std::vector<SweepRow> sweep;
    std::vector<SweepDistribution> distributions;
};

}  // namespace lodestream::report
