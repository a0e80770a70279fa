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

// The value that a share of all does not exceed, by nearest rank; 0: the least. pre: not empty
double percentile(std::vector<double> values, double share);

}  // namespace lodestream::bench
