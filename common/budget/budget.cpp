#include "common/budget/budget.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lodestream::budget {

namespace {

// Table 2: a display's pixels and the upper figure of the fewest polygons a frame for good quality on it.
struct DisplayRow {
    double pixels;
    double triangles;
};
constexpr std::array<DisplayRow, 3> table_2{
    {{800.0 * 600.0, 8'000.0}, {1024.0 * 768.0, 12'000.0}, {1280.0 * 1024.0, 26'000.0}}};

std::optional<std::string> not_positive(const char* field, double value) {
    if (std::isfinite(value) && value > 0.0) return std::nullopt;
    return std::string(field) + " must be a finite number > 0, got " + std::to_string(value);
}

template <class T>
std::optional<std::string> not_positive(const char* field, const std::optional<T>& value) {
    return value ? not_positive(field, static_cast<double>(*value)) : std::nullopt;
}

std::uint64_t whole_triangles(double value) {
    return static_cast<std::uint64_t>(std::floor(std::clamp(value, 0.0, max_triangles)));
}

// floor(NPP * DLR), forgiving the last bit of the product: 0.0882352… * 1,000,000 must not lose a triangle to rounding.
std::uint64_t current_polygons(double previous, double dlr) {
    const double product = previous * dlr;
    return whole_triangles(product * (1.0 + 1e-12));
}

double clamped_fps(double target_fps) {
    return std::clamp(target_fps, min_target_fps, max_target_fps);
}

std::uint64_t previous_polygons(const Request& request, const AssetCost& asset) {
    if (request.reference.triangles) return *request.reference.triangles;
    const double affordable = reference_triangles_per_second / clamped_fps(request.preference.target_fps);
    return std::min<std::uint64_t>(whole_triangles(affordable), std::max<std::uint64_t>(asset.triangles, 1));
}

// UP: what the user asks for, the lesser of a count and a share of what the device can show.
std::optional<double> wanted(const Preference& preference, std::uint64_t ncp) {
    std::optional<double> up;
    if (preference.triangles) up = static_cast<double>(*preference.triangles);
    if (preference.quality < 1.0)
        up = std::min(up.value_or(max_triangles), preference.quality * static_cast<double>(ncp));
    return up;
}

double device_share(const Request& request) {
    return std::min(capacity_mhz(request.device) / request.reference.capacity_mhz, std::numeric_limits<double>::max());
}

// The least of what several limits allow, and whose it was.
struct Least {
    double value = 0.0;
    LimitedBy by = LimitedBy::device;
    void limit(double allowed, LimitedBy limited_by) {
        if (allowed < value) *this = {allowed, limited_by};
    }
};

double memory_for_level(const DeviceReport& device) {
    return *device.memory_mb * 1e6 * memory_share_for_level;
}

double affordable_bytes(const Network& network) {
    const double transfer_s = std::max(0.0, network.max_wait_s - network.rtt_ms / 1000.0);
    return transfer_s * network.downlink_mbps * 1e6 / 8.0;
}

}  // namespace

const char* limited_by_name(LimitedBy limit) {
    switch (limit) {
        case LimitedBy::device:
            return "device";
        case LimitedBy::user:
            return "user";
        case LimitedBy::display:
            return "display";
        case LimitedBy::network:
            return "network";
        case LimitedBy::memory:
            return "memory";
        case LimitedBy::asset:
            return "asset";
    }
    return "device";
}

double capacity_mhz(const DeviceReport& device) {
    if (device.triangles_per_second)
        return *device.triangles_per_second / reference_triangles_per_second * reference_capacity_mhz;
    return device.cpu_mhz * (1.0 + (device.gpu == Gpu::discrete ? gpu_uplift_discrete : 0.0));
}

double triangles_for_display(double pixels) {
    if (!(pixels > 0.0)) return 0.0;
    if (pixels <= table_2.front().pixels) return pixels * table_2.front().triangles / table_2.front().pixels;
    std::size_t upper = 1;
    while (upper + 1 < table_2.size() && pixels > table_2[upper].pixels) ++upper;
    const DisplayRow &a = table_2[upper - 1], &b = table_2[upper];
    return a.triangles + (pixels - a.pixels) * (b.triangles - a.triangles) / (b.pixels - a.pixels);
}

double triangles_within_bytes(const AssetCost& asset, double bytes) {
    const auto& sizes = asset.sizes;
    if (sizes.empty()) return std::numeric_limits<double>::infinity();
    const auto triangles_at = [&](std::size_t i) { return static_cast<double>(sizes[i].triangles); };
    const auto bytes_at = [&](std::size_t i) { return static_cast<double>(sizes[i].bytes) * asset.bytes_factor; };
    if (sizes.size() == 1) return triangles_at(0) * bytes / std::max(bytes_at(0), 1.0);

    std::size_t finer = 0;
    while (finer + 2 < sizes.size() && bytes < bytes_at(finer + 1)) ++finer;
    const double byte_span = std::max(bytes_at(finer) - bytes_at(finer + 1), 1.0);
    const double triangle_span = std::max(triangles_at(finer) - triangles_at(finer + 1), 0.0);
    return triangles_at(finer + 1) + (bytes - bytes_at(finer + 1)) * triangle_span / byte_span;
}

double network_bytes(const Request& request) {
    return request.network ? affordable_bytes(*request.network) : std::numeric_limits<double>::infinity();
}

double network_excess(const Request& request, const AssetCost& asset, std::uint64_t bytes) {
    if (!request.network) return 0.0;
    const auto fixed = static_cast<double>(asset.fixed_bytes);
    return (static_cast<double>(bytes) - fixed) / std::max(affordable_bytes(*request.network) - fixed, 1.0);
}

Status validate(const Request& request) {
    const DeviceReport& device = request.device;
    std::optional<std::string> wrong;
    const auto check = [&](std::optional<std::string> problem) {
        if (!wrong) wrong = std::move(problem);
    };
    // A measured rate stands in for the clock, which such a device need not tell.
    if (!device.triangles_per_second || device.cpu_mhz != 0.0) check(not_positive("device.cpu_mhz", device.cpu_mhz));
    check(not_positive("device.cpu_cores", static_cast<double>(device.cpu_cores)));
    check(not_positive("device.memory_mb", device.memory_mb));
    check(not_positive("device.triangles_per_second", device.triangles_per_second));
    check(not_positive("device.points_per_second", device.points_per_second));
    check(not_positive("device.flat_triangles_per_second", device.flat_triangles_per_second));
    if (request.display) {
        check(not_positive("display.width", static_cast<double>(request.display->width)));
        check(not_positive("display.height", static_cast<double>(request.display->height)));
    }
    check(not_positive("preference.triangles", request.preference.triangles));
    check(not_positive("preference.quality", request.preference.quality));
    check(not_positive("preference.target_fps", request.preference.target_fps));
    if (request.network) {
        check(not_positive("network.downlink_mbps", request.network->downlink_mbps));
        check(not_positive("network.max_wait_s", request.network->max_wait_s));
        if (!std::isfinite(request.network->rtt_ms) || request.network->rtt_ms < 0.0)
            check("network.rtt_ms must be a finite number >= 0, got " + std::to_string(request.network->rtt_ms));
    }
    check(not_positive("reference.capacity_mhz", request.reference.capacity_mhz));
    check(not_positive("reference.triangles", request.reference.triangles));
    if (wrong) return invalid_input(*wrong);
    return Nothing{};
}

bool gouraud_costs_no_more(const DeviceReport& device) {
    return device.triangles_per_second && device.flat_triangles_per_second &&
           *device.flat_triangles_per_second <= least_flat_gain * *device.triangles_per_second;
}

Result<Budget> derive_budget(const Request& request, const AssetCost& asset) {
    if (Status valid = validate(request); !valid) return valid.error();

    Budget budget;
    budget.capacity_mhz = capacity_mhz(request.device);
    budget.dlr = device_share(request);
    budget.ncp = current_polygons(static_cast<double>(previous_polygons(request, asset)), budget.dlr);

    Least least{static_cast<double>(budget.ncp)};
    if (const std::optional<double> up = wanted(request.preference, budget.ncp)) {
        budget.rup = *up / static_cast<double>(std::max<std::uint64_t>(budget.ncp, 1));
        if (*budget.rup < 1.0) least.limit(*up, LimitedBy::user);
    }
    if (request.display)
        least.limit(triangles_for_display(static_cast<double>(request.display->width) * request.display->height),
                    LimitedBy::display);
    if (request.network)
        least.limit(triangles_within_bytes(asset, network_bytes(request) - static_cast<double>(asset.fixed_bytes)),
                    LimitedBy::network);
    if (request.device.memory_mb)
        least.limit(memory_for_level(request.device) / drawn_bytes_per_triangle, LimitedBy::memory);
    // The asset binds also where the device's share was worked out from the asset's own count and is all of it.
    const auto all = static_cast<double>(asset.triangles);
    if (all <= least.value) least = {all, LimitedBy::asset};

    budget.limited_by = least.by;
    budget.feasible = least.value >= 1.0 || asset.triangles == 0;
    budget.triangles = asset.triangles == 0 ? 0 : std::max<std::uint64_t>(1, whole_triangles(least.value));
    return budget;
}

Result<PointBudget> derive_point_budget(const Request& request, const PointCost& cost) {
    if (Status valid = validate(request); !valid) return valid.error();
    AssetCost asset;
    asset.triangles = cost.triangles > 0 ? cost.triangles : std::numeric_limits<std::uint64_t>::max();
    const double previous = static_cast<double>(previous_polygons(request, asset));
    Least least{request.device.points_per_second
                    ? *request.device.points_per_second / clamped_fps(request.preference.target_fps)
                    : std::min(previous * device_share(request) * points_per_triangle, max_triangles)};
    if (const std::optional<double> up = wanted(request.preference, whole_triangles(least.value)))
        least.limit(*up, LimitedBy::user);
    least.limit(static_cast<double>(cost.shown), LimitedBy::display);
    const double sent_bytes = network_bytes(request) - static_cast<double>(cost.fixed_bytes);
    least.limit(sent_bytes / static_cast<double>(std::max<std::uint64_t>(cost.bytes_per_point, 1)), LimitedBy::network);
    if (request.device.memory_mb)
        least.limit(memory_for_level(request.device) / drawn_bytes_per_point, LimitedBy::memory);
    const auto all = static_cast<double>(cost.points);
    if (all <= least.value) least = {all, LimitedBy::asset};
    return PointBudget{cost.points == 0 ? 0 : std::max<std::uint64_t>(1, whole_triangles(least.value)), least.by,
                       least.value >= 1.0 || cost.points == 0};
}

Operations with_shading(std::uint64_t criterion, std::uint64_t gouraud, std::uint64_t flat) {
    return {criterion, criterion + flat_operations * flat + gouraud_operations * gouraud};
}

}  // namespace lodestream::budget
