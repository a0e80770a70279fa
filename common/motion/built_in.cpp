#include <algorithm>
#include <cmath>
#include <functional>

#include "common/base/random.h"
#include "common/motion/motion.h"

namespace lodestream::motion {

namespace {

constexpr double ramp_s = 0.15;      // a head reaches its speed and stops within about that
constexpr double nod_deg = 25.0;     // up and down from the horizon
constexpr double circle_deg = 15.0;  // radius of what the gaze draws
constexpr double mix_longest_turn_deg = 160.0;
constexpr double mix_pitch_deg = 20.0;  // looks stay within
constexpr double longest_s = 600.0;
constexpr double fastest_allowed_deg_s = 1e4;

// 0 before 0, 1 after 1, without a jump in speed or acceleration's sign.
double smooth_step(double x) {
    const double t = std::clamp(x, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

double rise(double t_s, double at_s) {
    return smooth_step((t_s - at_s) / ramp_s);
}

Trace sampled(double seconds, const std::function<Pose(double)>& pose) {
    Trace trace;
    const auto steps = static_cast<std::size_t>(std::ceil(seconds / sample_interval_s));
    for (std::size_t i = 0; i <= steps; ++i) {
        const double t_s = static_cast<double>(i) * sample_interval_s;
        trace.push_back({t_s, pose(t_s)});
    }
    return trace;
}

// Headings from a speed over time, summed up step by step.
Trace turning(double seconds, const std::function<double(double)>& speed_deg_s) {
    double yaw_deg = 0.0;
    return sampled(seconds, [&](double t_s) {
        yaw_deg += speed_deg_s(t_s) * sample_interval_s;
        return Pose{std::nullopt, yaw_deg, 0.0};
    });
}

Trace nod(const BuiltIn& what) {
    const double rate = what.fastest_deg_s / nod_deg;  // radians/s of the sine
    return sampled(what.seconds, [&](double t_s) { return Pose{std::nullopt, 0.0, nod_deg * std::sin(rate * t_s)}; });
}

Trace circle(const BuiltIn& what) {
    const double rate = what.fastest_deg_s / circle_deg;
    return sampled(what.seconds, [&](double t_s) {
        return Pose{std::nullopt, circle_deg * std::sin(rate * t_s), circle_deg * (1.0 - std::cos(rate * t_s))};
    });
}

// A turn from one look to the next: the speed rises and falls as a bell whose top is 1.5 times the mean.
struct Turn {
    double begin_s, end_s;
    double from_yaw, to_yaw, from_pitch, to_pitch;
};

Turn next_turn(const Turn& last, const BuiltIn& what, Random& random) {
    Turn turn{last.end_s + random.log_uniform(0.2, 1.5), 0.0, last.to_yaw, 0.0, last.to_pitch, 0.0};
    const double reach = std::min(mix_longest_turn_deg, what.fastest_deg_s);
    const double yaw = (random.uniform() < 0.5 ? -1.0 : 1.0) * random.log_uniform(0.1 * reach, reach);
    turn.to_yaw = last.to_yaw + yaw;
    turn.to_pitch = std::clamp(last.to_pitch + random.normal() * 10.0, -mix_pitch_deg, mix_pitch_deg);
    const double angle = std::hypot(yaw, turn.to_pitch - turn.from_pitch);
    const double fastest = what.fastest_deg_s * random.uniform(0.3, 1.0);
    turn.end_s = turn.begin_s + 1.5 * angle / fastest;
    return turn;
}

Trace mix(const BuiltIn& what) {
    Random random(what.seed);
    Turn turn{0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    return sampled(what.seconds, [&](double t_s) {
        while (t_s >= turn.end_s) turn = next_turn(turn, what, random);
        const double share = smooth_step((t_s - turn.begin_s) / (turn.end_s - turn.begin_s));
        return Pose{std::nullopt, turn.from_yaw + (turn.to_yaw - turn.from_yaw) * share,
                    turn.from_pitch + (turn.to_pitch - turn.from_pitch) * share};
    });
}

Trace make(const BuiltIn& what) {
    const double v = what.fastest_deg_s, end = what.seconds;
    switch (what.kind) {
        case Kind::still:
            return turning(end, [](double) { return 0.0; });
        case Kind::start:
            return turning(end, [=](double t) { return v * rise(t, 0.3 * end); });
        case Kind::stop:
            return turning(end, [=](double t) { return v * (1.0 - rise(t, 0.6 * end)); });
        case Kind::reversal:
            return turning(end, [=](double t) {
                return v * (rise(t, 0.1 * end) - 2.0 * rise(t, 0.4 * end) + rise(t, 0.8 * end));
            });
        case Kind::nod:
            return nod(what);
        case Kind::circle:
            return circle(what);
        case Kind::mix:
            break;
    }
    return mix(what);
}

}  // namespace

Result<Trace> built_in(const BuiltIn& what) {
    if (!(what.seconds >= 1.0 && what.seconds <= longest_s)) return invalid_input("a built-in motion lasts 1 to 600 s");
    if (!(what.fastest_deg_s > 0.0 && what.fastest_deg_s <= fastest_allowed_deg_s))
        return invalid_input("a built-in motion's fastest speed must be above 0 and at most 10000 degrees/s");
    return make(what);
}

}  // namespace lodestream::motion
