// Straight lines through measured points.
#pragma once

#include <vector>

namespace lodestream::bench {

struct Sample {
    double x = 0.0;
    double y = 0.0;
};

struct Line {
    double intercept = 0.0;
    double slope = 0.0;
    double r_squared = 0.0;  // share of y's variance that the line explains; 1 where y does not vary
};

// Least squares. pre: two different x at least
Line fit_line(const std::vector<Sample>& samples);

// Sorted order statistics by nearest rank; `share` in [0, 1]. pre: not empty
double percentile(std::vector<double> values, double share);

}  // namespace lodestream::bench
