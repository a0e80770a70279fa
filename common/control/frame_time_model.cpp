#include "common/control/frame_time_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lodestream::control {

namespace {

using Vector = FrameTimeModel::Vector;
constexpr std::size_t size = FrameTimeModel::size;

constexpr double first_deviation = 0.5;    // of a cost from its first guess, as a share
constexpr double largest_deviation = 1.0;  // however long a cost was not seen
constexpr double common_drift = 0.02;      // of all costs together, a frame; doubled with each outlier on one side
constexpr int most_doublings = 4;
constexpr double single_drift = 0.004;    // of one cost, a frame
constexpr double measuring_noise = 0.05;  // of a frame's time, at least
constexpr double outlier_deviations = 3.0;
constexpr double least_share = 0.01, most_share = 1000.0;
constexpr double level_gain = 0.04;  // of a level's own correction, a frame
constexpr double level_leak = 0.02;  // back to none, a frame: costs and corrections cannot run away from each other
constexpr double least_level_factor = 0.5, most_level_factor = 2.0;
constexpr double first_spread = 0.04;
constexpr double spread_gain = 0.05;
constexpr double deviations_to_99_percent =
    2.9;  // of the mean absolute deviation, one-sided, for a normal distribution
constexpr double least_safety = 1.03, most_safety = 1.6;
constexpr double most_spread = (most_safety - 1.0) / deviations_to_99_percent;  // more would only take longer to go
constexpr double least_ms = 1e-6;

double usable(double value, double otherwise) {
    return std::isfinite(value) && value > 0.0 ? std::min(value, 1e9) : otherwise;
}

// Milliseconds of fixed, picture, triangles, seen, shaded, uploaded and background.
Vector parts(const FrameCosts& costs, const Work& work) {
    const double triangles_ms = work.triangles * costs.per_million_triangles_ms +
                                work.vertices * costs.per_million_vertices_ms +
                                work.extent_px * costs.per_million_extent_ms;
    const double shaded_ms =
        work.shaded_px * costs.per_million_shaded_ms + work.textured_px * costs.per_million_textured_ms;
    return {costs.fixed_ms,
            1e-6 * work.pixels * costs.per_million_pixels_ms,
            1e-6 * work.exposures * triangles_ms,
            1e-6 * work.exposures * work.seen_triangles * costs.per_million_seen_ms,
            1e-6 * work.exposures * shaded_ms,
            1e-6 * work.uploaded_triangles * costs.per_million_uploaded_ms,
            work.background_load * costs.background_ms};
}

double product(const Vector& a, const Vector& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < size; ++i) sum += a[i] * b[i];
    return sum;
}

void add_drift(FrameTimeModel& model) {
    const double common = std::ldexp(common_drift, std::min(std::abs(model.outliers), most_doublings));
    for (std::size_t i = 0; i < size; ++i)
        for (std::size_t j = 0; j < size; ++j)
            model.covariance[i][j] += common * common * model.share[i] * model.share[j];
    for (std::size_t i = 0; i < size; ++i)
        model.covariance[i][i] += single_drift * single_drift * model.share[i] * model.share[i];
}

// What a cost may be off never exceeds largest_deviation of it; otherwise a cost that is not seen for long, such as
// that of level changes, would take the blame for anything.
void bound_covariance(FrameTimeModel& model) {
    Vector scale{};
    for (std::size_t i = 0; i < size; ++i) {
        const double most = largest_deviation * std::max(model.share[i], first_deviation);
        scale[i] = std::min(1.0, most / std::sqrt(std::max(model.covariance[i][i], 1e-30)));
    }
    for (std::size_t i = 0; i < size; ++i)
        for (std::size_t j = 0; j < size; ++j) model.covariance[i][j] *= scale[i] * scale[j];
}

// Outliers on one side in a row, this surprise included.
int outliers_with(int before, double surprise_ms, double most_ms) {
    if (std::abs(surprise_ms) <= most_ms) return 0;
    const int side = surprise_ms > 0.0 ? 1 : -1;
    return before * side > 0 ? std::clamp(before + side, -most_doublings, most_doublings) : side;
}

// One step of the Kalman filter.
void correct(FrameTimeModel& model, const Vector& x, double measured_ms) {
    Vector gain{};
    for (std::size_t i = 0; i < size; ++i) gain[i] = product(model.covariance[i], x);
    const double predicted_ms = product(model.share, x);
    const double noise = std::max(measuring_noise, model.spread);
    const double noise_ms = noise * std::max(predicted_ms, least_ms);
    const double variance = product(gain, x) + noise_ms * noise_ms;
    const double most = outlier_deviations * std::sqrt(variance);
    model.outliers = outliers_with(model.outliers, measured_ms - predicted_ms, most);
    const double surprise_ms = std::clamp(measured_ms - predicted_ms, -most, most);
    for (std::size_t i = 0; i < size; ++i) {
        model.share[i] = std::clamp(model.share[i] + gain[i] / variance * surprise_ms, least_share, most_share);
        for (std::size_t j = 0; j < size; ++j) model.covariance[i][j] -= gain[i] * gain[j] / variance;
    }
}

}  // namespace

double frame_ms(const FrameCosts& costs, const Work& work) {
    const Vector ms = parts(costs, work);
    return std::accumulate(ms.begin(), ms.end(), 0.0);
}

FrameTimeModel make_model(const FrameCosts& first_guess) {
    const FrameCosts otherwise;
    FrameTimeModel model;
    model.first_guess = {usable(first_guess.fixed_ms, otherwise.fixed_ms),
                         usable(first_guess.per_million_triangles_ms, otherwise.per_million_triangles_ms),
                         usable(first_guess.per_million_pixels_ms, otherwise.per_million_pixels_ms),
                         usable(first_guess.per_million_uploaded_ms, otherwise.per_million_uploaded_ms),
                         usable(first_guess.background_ms, otherwise.background_ms),
                         usable(first_guess.per_million_shaded_ms, 0.0),
                         usable(first_guess.per_million_seen_ms, 0.0),
                         usable(first_guess.per_million_vertices_ms, 0.0),
                         usable(first_guess.per_million_textured_ms, 0.0),
                         usable(first_guess.per_million_extent_ms, 0.0)};
    model.share.fill(1.0);
    for (std::size_t i = 0; i < size; ++i) model.covariance[i][i] = first_deviation * first_deviation;
    model.level_factor.fill(1.0);
    model.spread = first_spread;
    return model;
}

double predict_ms(const FrameTimeModel& model, const Work& work) {
    const double factor = model.level_factor[std::min<std::size_t>(work.level, max_levels - 1)];
    const double ms = product(model.share, parts(model.first_guess, work)) * factor;
    return std::isfinite(ms) ? std::max(ms, least_ms) : max_frame_ms;
}

double safety_factor(const FrameTimeModel& model) {
    return std::clamp(1.0 + deviations_to_99_percent * model.spread, least_safety, most_safety);
}

FrameTimeModel learn(FrameTimeModel model, const Work& work, double measured_ms) {
    if (!std::isfinite(measured_ms) || !(measured_ms > 0.0)) return model;
    measured_ms = std::min(measured_ms, max_frame_ms);
    const double off = std::abs(measured_ms / predict_ms(model, work) - 1.0);
    const double most_off = std::min(outlier_deviations * std::max(model.spread, 0.01), most_spread);
    model.spread += spread_gain * (std::min(off, most_off) - model.spread);

    double& factor = model.level_factor[std::min<std::size_t>(work.level, max_levels - 1)];
    const Vector x = parts(model.first_guess, work);
    add_drift(model);
    bound_covariance(model);
    correct(model, x, measured_ms / factor);
    const double rest = std::clamp(measured_ms / predict_ms(model, work), 0.5, 2.0);
    factor = std::clamp(std::pow(factor, 1.0 - level_leak) * std::pow(rest, level_gain), least_level_factor,
                        most_level_factor);
    return model;
}

}  // namespace lodestream::control
