#include "client/probe/statistics.h"

#include <algorithm>
#include <cmath>

namespace lodestream::probe {

namespace {

constexpr double deviation_of_median_deviation = 1.4826;  // of a normal distribution
constexpr double median_over_mean = 1.2533;               // standard errors, likewise
constexpr double for_19_of_20 = 1.96;

// Half of the interval that holds the median in 19 of 20 cases.
double off_by(std::vector<double> values, double median_of_them) {
    const double root = std::sqrt(static_cast<double>(values.size()));
    for (double& value : values) value = std::abs(value - median_of_them);
    return for_19_of_20 * median_over_mean * deviation_of_median_deviation * median(std::move(values)) / root;
}

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
    rate.uncertainty_percent =
        std::min(100.0 * off_by(std::move(per_second), rate.per_second) / rate.per_second, 100.0);
    return rate;
}

Rate widened(Rate rate, double percent) {
    rate.uncertainty_percent = std::min(std::hypot(rate.uncertainty_percent, percent), 100.0);
    return rate;
}

Timing timing_of(std::span<const TimedRun> runs) {
    if (runs.empty()) return {};
    std::vector<double> ms;
    for (const TimedRun& run : runs) ms.push_back(run.ms);
    std::sort(ms.begin(), ms.end());
    const auto quantile = [&](double share) {
        return ms[static_cast<std::size_t>(std::floor(share * static_cast<double>(ms.size() - 1)))];
    };
    const double fast = quantile(fast_share);
    const auto calm = std::count_if(runs.begin(), runs.end(),
                                    [](const TimedRun& run) { return run.waited_ms <= calm_share * run.ms; });
    return {fast, std::max(fast - ms.front(), quantile(0.25) - fast), ms.size(), static_cast<std::size_t>(calm)};
}

Rate marginal_rate(double amount, const Timing& with, const Timing& without) {
    const double more_ms = with.ms - without.ms;
    Rate rate{0.0, 100.0, std::min(with.runs, without.runs)};
    if (!(more_ms > 0.0)) return rate;
    rate.per_second = 1000.0 * amount / more_ms;
    if (rate.runs >= 2)
        rate.uncertainty_percent = std::min(100.0 * std::hypot(with.off_ms, without.off_ms) / more_ms, 100.0);
    return rate;
}

}  // namespace lodestream::probe
