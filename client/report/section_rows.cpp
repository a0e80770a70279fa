#include "client/report/section_rows.h"

#include <algorithm>

#include "client/report/text.h"

namespace lodestream::report {
namespace {

std::string rung_title(const AssetResult& asset, const LadderLevel& rung) {
    return asset.asset.name + ", level " + std::to_string(rung.index) + ": " + format_count(rung.level.triangles) +
           " triangles, RMS " + format_number(rung.level.rms_error_percent) + " %, " +
           format_bytes(static_cast<double>(rung.level.bytes));
}

std::optional<double> both(const std::optional<double>& plan_ms, const std::optional<double>& fetch_ms) {
    return plan_ms && fetch_ms ? std::optional(*plan_ms + *fetch_ms) : std::nullopt;
}

}  // namespace

std::vector<DeviceRow> device_rows(const ReportData& data) {
    std::vector<DeviceRow> rows;
    for (const AssetResult& asset : data.assets)
        for (const DeviceResult& device : asset.devices) rows.push_back({&asset, &device});
    return rows;
}

double Journey::time_ms() const {
    const double computed_ms = device->replan_ms + fetch_ms + link_ms(link, static_cast<double>(bytes));
    return linked_ms.value_or(computed_ms) + decode_ms + frame_ms;
}

Journey cut_journey(const DeviceRow& row, std::size_t link) {
    const ModeResult& sent = hybrid_of(*row.device);
    const auto& level = row.device->plan.level;
    return {row.asset,
            row.device,
            nullptr,
            links[link],
            both(row.device->linked_plan_ms[link], row.device->linked_fetch_ms[link]),
            sent.fetch_ms,
            sent.decode_ms,
            sent.frame_ms,
            level.rms_error_percent,
            level.screen_space_error_px,
            sent.image.percent,
            level.triangles,
            sent.bytes};
}

std::vector<Journey> rung_journeys(const DeviceRow& row, std::size_t link) {
    std::vector<Journey> out;
    for (const LadderLevel& rung : row.asset->ladder)
        for (const DrawnLevel& drawn : rung.drawn)
            if (drawn.device == row.device->device)
                out.push_back({row.asset, row.device, &rung, links[link],
                               both(row.device->linked_plan_ms[link], rung.linked_fetch_ms[link]), rung.fetch_ms,
                               rung.decode_ms, drawn.frame_ms, rung.level.rms_error_percent, drawn.error_px,
                               drawn.image.percent, rung.level.triangles, rung.level.bytes});
    return out;
}

double link_ms(const Link& link, double bytes) {
    return bytes * 8.0 / (link.downlink_mbps * 1e3) + 2.0 * link.rtt_ms;
}

double share_percent(double part, double whole) {
    return whole > 0.0 ? 100.0 * part / whole : not_known;
}

double bytes_per_triangle(std::uint64_t bytes, std::uint64_t triangles) {
    return triangles > 0 ? static_cast<double>(bytes) / static_cast<double>(triangles) : not_known;
}

double saved_percent(const DeviceResult& device) {
    const double gouraud = static_cast<double>(gouraud_of(device).bytes);
    return share_percent(gouraud - static_cast<double>(hybrid_of(device).bytes), gouraud);
}

bool lies_between(const DeviceResult& device) {
    constexpr double tolerance_percent = 0.01;  // of full scale; below what 8-bit pictures resolve
    const auto [low, high] = std::minmax(gouraud_of(device).image.percent, flat_of(device).image.percent);
    const double hybrid = hybrid_of(device).image.percent;
    return hybrid >= low - tolerance_percent && hybrid <= high + tolerance_percent;
}

budget::Display display_of(const DeviceResult& device) {
    return device.request.display.value_or(shading::default_display);
}

std::string display_text(const budget::Display& display) {
    return std::to_string(display.width) + "×" + std::to_string(display.height);
}

std::string link_text(const Link& link) {
    return format_number(link.downlink_mbps) + " Mbit/s";
}

std::string device_title(const DeviceRow& row) {
    return row.asset->asset.name + " on " + row.device->device + ": " + format_count(row.device->plan.level.triangles) +
           " triangles";
}

std::string between_sentence(const std::vector<DeviceRow>& rows) {
    std::size_t split = 0, between = 0;
    for (const DeviceRow& row : rows) {
        const ModeResult& hybrid = hybrid_of(*row.device);
        if (hybrid.flat == 0 || hybrid.gouraud == 0) continue;
        ++split;
        between += lies_between(*row.device);
    }
    if (split == 0) return "No level of this report mixes both kinds of triangles.";
    return "Of the " + std::to_string(split) + " levels that mix both kinds of triangles, " + std::to_string(between) +
           " have a picture whose error lies between all flat and all Gouraud.";
}

std::vector<Series> ladder_series(const ReportData& data, const std::function<double(const LadderLevel&)>& x,
                                  const std::function<double(const AssetResult&, const LadderLevel&)>& y) {
    std::vector<Series> out;
    for (std::size_t i = 0; i < data.assets.size(); ++i) {
        Series series{data.assets[i].asset.name, {}, true, true, false, i};
        for (const LadderLevel& rung : data.assets[i].ladder)
            series.points.push_back({x(rung), y(data.assets[i], rung), rung_title(data.assets[i], rung)});
        out.push_back(std::move(series));
    }
    return out;
}

double rms_percent(const AssetResult&, const LadderLevel& rung) {
    return rung.level.rms_error_percent;
}

}  // namespace lodestream::report
