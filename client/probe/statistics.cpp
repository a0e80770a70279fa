#include "client/probe/statistics.h"

#include <algorithm>
#include <cmath>

namespace lodestream::probe {

namespace {

constexpr double deviation_of_median_deviation = 1.4826;  // of a normal distribution
constexpr double median_over_mean = 1.2533;               // standard errors, likewise
constexpr double for_19_of_20 = 1.96;

}  // namespace

double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    const std::size_t half = values.size() / 2;
    return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

Rate rate_of(std::vector<double> per_second) {
    Rate rate{median(per_second), 0.0, per_second.size()};
    if (per_second.size() < 2 || !(rate.per_second > 0.0)) {
        rate.uncertainty_percent = 100.0;
        return rate;
    }
    for (double& value : per_second) value = std::abs(value - rate.per_second);
    const double deviation = deviation_of_median_deviation * median(std::move(per_second));
    const double error = for_19_of_20 * median_over_mean * deviation / std::sqrt(static_cast<double>(rate.runs));
    rate.uncertainty_percent = std::min(100.0 * error / rate.per_second, 100.0);
    return rate;
}

}  // namespace lodestream::probe
