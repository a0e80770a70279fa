// A device that draws frames in simulated time: what a frame costs by triangles, pixels, level changes and decoding,
// with seeded noise, spikes, thermal throttling and slow decodes. The same seed gives the same frames everywhere.
#pragma once

#include <cstdint>

#include "common/base/random.h"
#include "common/control/frame_time_model.h"

namespace lodestream::simulate {

struct Device {
    control::FrameCosts costs;        // of a cool, idle device
    double noise = 0.03;              // standard deviation of a frame's time, as a share
    double spikes_per_frame = 0.002;  // chance of a frame that takes spike_factor as long
    double spike_factor = 1.6;
    double throttled_factor = 1.3;  // slower by that when hot; 1: never throttles
    double heat_up_s = 20.0;        // of full load until it is hot; as long to cool down
    double decodes_per_s = 0.2;     // levels that arrive and are decoded beside the frames
    double decode_s = 0.1;          // each
    std::uint64_t seed = 1;
};

struct DeviceState {
    double heat = 0.0;             // [0, 1]; throttles above one half
    double decoding_left_s = 0.0;  // of the decode under way
    Random random;
};

DeviceState switched_on(const Device& device);

struct DrawnFrame {
    DeviceState state;
    double frame_ms = 0.0;
    double background_load = 0.0;  // that the next frame will have
};

// Draws one frame; the device is busy for frame_ms of the interval max(frame_ms, deadline_ms). `work.background_load`
// is not read: the device knows what it decodes. Finite and > 0 for any finite work.
DrawnFrame draw(const Device& device, DeviceState state, const control::Work& work, double deadline_ms);

// Measured rates to a device: triangles/s Gouraud, pixels/s, and a fixed cost a frame; a level change is taken to cost
// what drawing the level once does. pre: all > 0
Device calibrated(double triangles_per_second, double pixels_per_second, double fixed_ms);

// One of many: a device that, with the coarsest level and all exposures, has 40 to 75 % of the deadline to do. Its
// rates, noise, spikes, heat and decodes are drawn from the seed.
struct Population {
    double finest_triangles = 1e5;
    double coarsest_triangles = 1e4;
    double pixels = 5e5;
    double deadline_ms = 1000.0 / 60.0;
};
Device random_device(const Population& population, std::uint64_t seed);

}  // namespace lodestream::simulate
