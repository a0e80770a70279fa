// A rate from repeated runs, with how far it may be off.
#pragma once

#include <cstddef>
#include <vector>

namespace lodestream::probe {

struct Rate {
    double per_second = 0.0;           // median of the runs
    double uncertainty_percent = 0.0;  // half of the interval that holds the median in 19 of 20 cases, of the median
    std::size_t runs = 0;
};

// From runs' rates. The spread is the median absolute deviation, which single disturbed runs do not move. 100 % off
// for fewer than two runs and for a median of 0, which say nothing.
Rate rate_of(std::vector<double> per_second);

double median(std::vector<double> values);  // 0 for none

}  // namespace lodestream::probe
