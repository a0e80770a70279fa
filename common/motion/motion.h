// Where a viewer looks over time: recorded as CSV, or built in. Heading and pitch as in glTF's axes: heading 0 and
// pitch 0 look along -z, heading turns to the left, pitch upwards.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "common/base/math.h"
#include "common/base/result.h"

namespace lodestream::motion {

inline constexpr std::size_t max_samples = 1'000'000;
inline constexpr double max_pitch_deg = 90.0;
inline constexpr double sensor_interval_s = 0.01;  // a speed is measured over the last such stretch of time

struct Pose {
    std::optional<Vec3d> position;  // metres; absent: the asset's default viewpoint
    double yaw_deg = 0.0;           // relative to the default view's heading where the position is absent
    double pitch_deg = 0.0;         // likewise
};

// From `eye` towards `target`, by absolute angles. pre: they differ
Pose looking_at(const Vec3d& eye, const Vec3d& target);

struct Sample {
    double t_s = 0.0;
    Pose pose;
};

// At least one sample, times rising strictly.
using Trace = std::vector<Sample>;

// Rows `t_s,x,y,z,yaw_deg,pitch_deg`, the first of which may be that heading; empty x, y, z keep the default viewpoint.
// Errors: invalid_input (the line and what is wrong with it), limit_exceeded (more than max_samples rows).
Result<Trace> parse_csv(std::string_view text);

double duration_s(const Trace& trace);  // from the first sample to the last

// Between two samples everything is linear, headings the short way round; before the first and after the last the pose
// is held. A position that only one of the two samples has is that sample's until the next.
Pose pose_at(const Trace& trace, double t_s);

Vec3d direction(const Pose& pose);  // unit length

// How fast the direction turned during the last sensor_interval_s, degrees/s; what a head tracker reports.
double speed_deg_s(const Trace& trace, double t_s);

// The motions built in, from the ISBLC paper's scenario (§4: sudden acceleration, stop and reversal) and beyond.
enum class Kind { still, start, stop, reversal, nod, circle, mix };
inline constexpr Kind kinds[] = {Kind::still, Kind::start,  Kind::stop, Kind::reversal,
                                 Kind::nod,   Kind::circle, Kind::mix};
const char* kind_name(Kind kind);  // "still", "start", …
Result<Kind> parse_kind(std::string_view name);

inline constexpr double sample_interval_s = 0.01;  // of what is built in

struct BuiltIn {
    Kind kind = Kind::mix;
    double seconds = 8.0;          // [1, 600]
    double fastest_deg_s = 240.0;  // (0, 1e4]: the highest speed reached; `mix` stays below it
    std::uint64_t seed = 1;        // of `mix`: looks here and there with pauses between, as a head does
};

// Errors: invalid_input (outside the ranges above).
Result<Trace> built_in(const BuiltIn& what);

}  // namespace lodestream::motion
