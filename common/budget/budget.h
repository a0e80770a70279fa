// The polygon budget: how many triangles a device gets, and what limited it.
// Source: hybrid-rendering paper §3, equations 1–3, Tables 1 and 2 (seeds-digest §1).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/math.h"
#include "common/base/result.h"

namespace lodestream::budget {

inline constexpr double gpu_uplift_discrete = 0.382;           // Table 1: 2460 MHz * 1.382 = 3400 MHz
inline constexpr double reference_capacity_mhz = 3400.0;       // Table 1: the desktop
inline constexpr double reference_triangles_per_second = 1e6;  // Table 1: what the desktop draws
inline constexpr double min_target_fps = 1.0;
inline constexpr double max_target_fps = 1000.0;
inline constexpr double memory_share_for_level = 0.25;    // of the device's memory
inline constexpr double drawn_bytes_per_triangle = 64.0;  // vertex and index buffers plus the decoder's working set
inline constexpr double points_per_triangle = 0.5;        // drawn in the same time, where points were not measured
inline constexpr double drawn_bytes_per_point = 64.0;     // its vertex and the decoder's working set
inline constexpr double max_triangles = 4294967295.0;     // triangle counts are 32 bits wide in every mesh

enum class Gpu { none, discrete };

// What a client says of itself. Every field but cpu_mhz is optional.
struct DeviceReport {
    std::string name;             // free text, for tables
    double cpu_mhz = 0.0;         // > 0
    std::uint32_t cpu_cores = 1;  // >= 1; told to the operator, not part of the papers' capacity
    Gpu gpu = Gpu::none;
    std::optional<double> memory_mb;             // > 0; bounds what a level may occupy when drawn
    std::optional<double> triangles_per_second;  // > 0; measured, replaces the capacity derived from clock and GPU
    std::optional<double> points_per_second;     // > 0; measured, likewise where points are asked for
    // > 0; measured, where triangles_per_second is the rate of Gouraud ones or the lower of both.
    std::optional<double> flat_triangles_per_second;
};

// Whether the device is known to draw flat triangles hardly faster than Gouraud ones (Table 3 reckons with four times),
// so that a hybrid level would save it no time. A tenth is within what a probe repeats.
inline constexpr double least_flat_gain = 1.1;
bool gouraud_costs_no_more(const DeviceReport& device);

struct Display {
    std::uint32_t width = 0;   // px
    std::uint32_t height = 0;  // px
};

struct Preference {
    std::optional<std::uint64_t> triangles;  // UP, polygons the user wants; >= 1
    double quality = 1.0;                    // UP as a share of NCP, (0, 1]; above 1 counts as 1
    double target_fps = 30.0;                // frames/s, > 0; clamped to [min_target_fps, max_target_fps]
};

struct Network {
    double downlink_mbps = 0.0;  // Mbit/s, > 0
    double rtt_ms = 0.0;         // >= 0
    double max_wait_s = 3.0;     // s, > 0: longest time from the click to the level
};

// The previous device of equation 1 and what it showed.
struct Reference {
    double capacity_mhz = reference_capacity_mhz;  // CP, > 0
    std::optional<std::uint64_t> triangles;        // NPP, >= 1; absent: 1,000,000 / target_fps, at most the asset
};

// Measured size of one encoded level.
struct EncodedSize {
    std::uint64_t triangles = 0;
    std::uint64_t bytes = 0;
};

// What the asset costs, for the limits that are not the device's.
struct AssetCost {
    std::uint64_t triangles = 0;     // of the full model
    std::vector<EncodedSize> sizes;  // of its ladder, finest first, falling; empty: the network does not limit
    double bytes_factor = 1.0;       // > 0; what the sizes are to be multiplied by
    std::uint64_t fixed_bytes = 0;   // sent with any level beside its triangles and not part of the sizes: textures
};

// The most triangles whose level is expected to have at most `bytes`: piecewise linear between the measured sizes, the
// first and the last interval continued. May be negative: not even an empty level fits. +infinity without sizes.
double triangles_within_bytes(const AssetCost& asset, double bytes);

struct Request {
    DeviceReport device;
    std::optional<Display> display;
    Preference preference;
    std::optional<Network> network;
    Reference reference;
};

enum class LimitedBy { device, user, display, network, memory, asset };
const char* limited_by_name(LimitedBy limit);

struct Budget {
    double capacity_mhz = 0.0;    // CC
    double dlr = 0.0;             // CC / CP
    std::uint64_t ncp = 0;        // floor(NPP * DLR)
    std::optional<double> rup;    // UP / NCP where the user asked for something
    std::uint64_t triangles = 0;  // the least of all limits; >= 1 unless the asset is empty
    LimitedBy limited_by = LimitedBy::device;
    bool feasible = true;  // false: the binding limit allows less than one triangle, one is given all the same
};

// Capacity in MHz of Table 1's scale: cpu_mhz * (1 + uplift), or the measured rate where there is one.
// pre: validate(device) succeeded.
double capacity_mhz(const DeviceReport& device);

// Table 2's upper figure (good quality at full preference) for a display of `pixels`: piecewise linear between its
// rows, continued by the first row's triangles per pixel below and by the last interval's slope above. Never negative.
double triangles_for_display(double pixels);

// What the network carries in max_wait_s; +infinity where no network is given.
double network_bytes(const Request& request);

// Bytes of the triangles over what the network leaves them beside the fixed bytes; above 1: too many. 0 where no
// network is given. `bytes` are the whole level's.
double network_excess(const Request& request, const AssetCost& asset, std::uint64_t bytes);

// Refuses with a message that names the field: non-finite numbers, zero or negative where the header says > 0.
Status validate(const Request& request);

// Equations 1–3 and the user's rule, then the display's, the network's, the memory's and the asset's limits.
// Fails where validate() fails; extreme but valid numbers saturate at max_triangles.
Result<Budget> derive_budget(const Request& request, const AssetCost& asset);

// What an asset's points cost, for the limits that are not the device's.
struct PointCost {
    std::uint64_t points = 0;       // all there are
    std::uint64_t triangles = 0;    // of the full model; 0: it has none
    std::uint64_t shown = 0;        // more of them than this the view cannot tell apart
    std::uint64_t fixed_bytes = 0;  // sent with any number of them
    std::uint64_t bytes_per_point = 1;
};

struct PointBudget {
    std::uint64_t points = 0;  // >= 1 unless the asset has none
    LimitedBy limited_by = LimitedBy::device;
    bool feasible = true;  // as Budget::feasible
};

// As derive_budget() for a cloud: the device draws points_per_second / target_fps of them, or points_per_triangle for
// each triangle of equation 2's NCP (each one the reference drew, where the model has none); the user's count is one of
// points.
Result<PointBudget> derive_point_budget(const Request& request, const PointCost& cost);

// Table 3's prices, a polygon.
inline constexpr std::uint64_t flat_operations = 1;
inline constexpr std::uint64_t gouraud_operations = 4;

struct Operations {
    std::uint64_t criterion = 0;  // counted where the criterion runs (common/shading/operation_counts.h)
    std::uint64_t total = 0;      // and what drawing adds: f + 4g
};
Operations with_shading(std::uint64_t criterion, std::uint64_t gouraud, std::uint64_t flat);

}  // namespace lodestream::budget
