// A rate from repeated runs, with how far it may be off.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lodestream::probe {

struct Rate {
    double per_second = 0.0;
    double uncertainty_percent = 0.0;  // of per_second, to either side
    std::size_t runs = 0;
};

// The median of runs' rates, and half of the interval that holds it in 19 of 20 cases. The spread is the median
// absolute deviation, which single disturbed runs do not move. 100 % off for fewer than two runs and for a median of 0,
// which say nothing.
Rate rate_of(std::vector<double> per_second);

// The same rate, where what one process measures is off by `percent` from another's beside what its own runs show.
Rate widened(Rate rate, double percent);

double median(std::vector<double> values);  // 0 for none

// One run of what is timed.
struct TimedRun {
    double ms = 0.0;
    double waited_ms = 0.0;  // for a core that others had, of all threads
};

inline constexpr double calm_share = 0.03;  // of a run's time that its threads may have waited
inline constexpr double fast_share = 0.1;   // of the runs that are taken to be undisturbed, whatever happens

// Others only ever make a run longer, so what a run takes is told by the fast ones.
struct Timing {
    double ms = 0.0;       // the fast_share quantile
    double off_ms = 0.0;   // to the least, or to the lower quartile where that is farther
    std::size_t runs = 0;  // all
    std::size_t calm = 0;  // of them, those that did not wait
};

// 0 runs: all 0.
Timing timing_of(std::span<const TimedRun> runs);

// What takes so much longer, in a second; off by as much as both timings are. 100 % off where the times do not tell and
// for single runs.
Rate marginal_rate(double amount, const Timing& with, const Timing& without);

}  // namespace lodestream::probe
