#include "tests/bench/fit.h"

#include <algorithm>
#include <cmath>

namespace lodestream::bench {

Line fit_line(const std::vector<Sample>& samples) {
    const double n = static_cast<double>(samples.size());
    double mean_x = 0, mean_y = 0;
    for (const Sample& s : samples) {
        mean_x += s.x / n;
        mean_y += s.y / n;
    }
    double xx = 0, xy = 0, yy = 0;
    for (const Sample& s : samples) {
        xx += (s.x - mean_x) * (s.x - mean_x);
        xy += (s.x - mean_x) * (s.y - mean_y);
        yy += (s.y - mean_y) * (s.y - mean_y);
    }
    const double slope = xy / xx;
    return {mean_y - slope * mean_x, slope, yy > 0 ? slope * xy / yy : 1.0};
}

double percentile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
    return values[std::clamp<std::size_t>(rank, 1, values.size()) - 1];
}

}  // namespace lodestream::bench
