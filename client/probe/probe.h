// `lodestream-client probe`: what this device can do, measured in at most probe_limit_s, as a device file that a plan
// takes in place of clock and GPU.
#pragma once

#include <optional>
#include <string>

#include "client/probe/graphics.h"
#include "client/probe/machine.h"
#include "client/probe/statistics.h"
#include "common/base/result.h"
#include "common/budget/budget.h"

namespace lodestream::probe {

inline constexpr double probe_limit_s = 3.0;
inline constexpr double disturbed_above_cores = 0.15;  // kept busy by others while we measured

struct Report {
    Machine machine;
    Graphics graphics;
    Rate cpu_single;  // operations as of measure_cpu()
    Rate cpu_all;     // all cores together
    std::string renderer;
    bool software_renderer = false;
    std::optional<double> other_cores;  // busy with other processes; absent: the system does not say
    double seconds = 0.0;               // that the probe took
};

// Errors: unavailable (no OpenGL ES 3), those of the renderer.
Result<Report> measure();

bool disturbed(const Report& report);

// triangles_per_second is the lower of the two rates: a level may be all of either.
budget::DeviceReport device_report(const Report& report);

// A device file: {"device":…,"display":…,"measured":{…}}, readable by `view --device` and as a plan request's members.
std::string to_json(const Report& report);
std::string to_text(const Report& report);

}  // namespace lodestream::probe
