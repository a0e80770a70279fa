#include "client/report/linked.h"
#include "client/report/section_rows.h"

#include "client/report/text.h"

namespace lodestream::report {
namespace {

std::vector<Journey> journeys(const ReportData& data) {
    std::vector<Journey> rows;
    for (const auto& [asset, device] : device_rows(data))
        for (std::size_t link = 0; link < links.size(); ++link) {
            rows.push_back(cut_journey({asset, device}, link));
            const std::vector<Journey> rungs = rung_journeys({asset, device}, link);
            rows.insert(rows.end(), rungs.begin(), rungs.end());
        }
    return rows;
}

Plot journey_plot(const AssetResult& asset, const DeviceResult& device) {
    Plot plot{asset.asset.name + " on " + device.device + ", " + display_text(display_of(device)),
              {"time since the click, ms", AxisScale::logarithmic},
              {"error of the picture, %", AxisScale::logarithmic},
              {},
              {}};
    for (std::size_t link = 0; link < links.size(); ++link) {
        Series series{link_text(links[link]), {}, true, true, false, {}};
        for (const Journey& row : rung_journeys({&asset, &device}, link))
            series.points.push_back({row.time_ms(), row.image_error_percent,
                                     link_text(links[link]) + ", level " + std::to_string(row.rung->index) + ": " +
                                         format_count(row.triangles) + " triangles, " +
                                         format_bytes(static_cast<double>(row.bytes)) + ", drawn after " +
                                         format_duration(row.time_ms()) + (row.linked_ms ? "" : " (computed)") +
                                         ", error " + format_number(row.image_error_percent) + " %"});
        plot.series.push_back(std::move(series));
    }
    return plot;
}

Table journey_table(const ReportData& data) {
    std::vector<Field<DeviceRow>> fields = {
        {"asset", "model", [](const auto& r) { return r.asset->asset.name; }},
        {"device", "device", [](const auto& r) { return r.device->device; }},
        {"triangles", "triangles", [](const auto& r) { return r.device->plan.level.triangles; }},
        {"bytes", "bytes", [](const auto& r) { return r.device->plan.content.bytes; }},
        {"image", "picture’s error %", [](const auto& r) { return hybrid_of(*r.device).image.percent; }},
        {"first", "first plan ms", [](const auto& r) { return r.device->plan.timing_ms.plan; }},
        {"replan", "plan ms", [](const auto& r) { return r.device->replan_ms; }},
        {"fetch", "fetch ms", [](const auto& r) { return hybrid_of(*r.device).fetch_ms; }},
        {"decode", "decode ms", [](const auto& r) { return hybrid_of(*r.device).decode_ms; }},
        {"frame", "frame ms", [](const auto& r) { return hybrid_of(*r.device).frame_ms; }}};
    for (std::size_t link = 0; link < links.size(); ++link)
        fields.push_back({"", "ms at " + link_text(links[link]),
                          [link](const DeviceRow& r) { return cut_journey(r, link).time_ms(); }});
    return table_of<DeviceRow>(device_rows(data), fields);
}

}  // namespace

Section end_to_end_section(const ReportData& data) {
    Section section{"end_to_end", "From the click to the picture", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>How good the picture is, and how long after the click: plan + fetch + decode + first frame, for each "
        "level of the ladder (one point a level, coarse to fine from left to right) over four links. The links are "
        "<strong>throttled for real</strong>: the client reads no faster and waits a round trip for "
        "the plan and another for the content (";
    for (const Link& link : links)
        section.text_html +=
            (&link == links.begin() ? "" : ", ") + link_text(link) + " with " + format_number(link.rtt_ms) + " ms";
    section.text_html +=
        "). Transfers of more than " + format_number(data.provenance.quick ? max_quick_link_s : max_link_s) +
        " s are computed instead: bytes × 8 ÷ rate and the two round trips. Decode and frame times are <em>this</em> "
        "machine’s at the device’s display size, not those of a device of that class. The table has the level that "
        "was cut for each device; “first plan” includes cutting, measuring and encoding it, later plans find it in "
        "the store.</p>";
    for (const AssetResult& asset : data.assets)
        for (const DeviceResult& device : asset.devices) {
            const bool outer = &device == &asset.devices.front() || &device == &asset.devices.back();
            (outer ? section.plots : section.folded_plots).push_back(journey_plot(asset, device));
        }
    section.shown = journey_table(data);
    section.rows = table_of<Journey>(
        journeys(data), {{"asset", "", [](const auto& r) { return r.asset->asset.name; }},
                         {"device", "", [](const auto& r) { return r.device->device; }},
                         {"level", "", [](const auto& r) { return r.rung ? Cell{r.rung->index} : Cell{}; }},
                         {"triangles", "", [](const auto& r) { return r.triangles; }},
                         {"bytes", "", [](const auto& r) { return r.bytes; }},
                         {"rms_error_percent", "", [](const auto& r) { return r.rms_error_percent; }},
                         {"error_px", "", [](const auto& r) { return r.error_px; }},
                         {"image_error_percent", "", [](const auto& r) { return r.image_error_percent; }},
                         {"downlink_mbps", "", [](const auto& r) { return r.link.downlink_mbps; }},
                         {"rtt_ms", "", [](const auto& r) { return r.link.rtt_ms; }},
                         {"plan_ms", "", [](const auto& r) { return r.device->replan_ms; }},
                         {"fetch_ms", "", [](const auto& r) { return r.fetch_ms; }},
                         {"link_ms", "", [](const auto& r) { return link_ms(r.link, static_cast<double>(r.bytes)); }},
                         {"linked_ms", "", [](const auto& r) { return r.linked_ms.value_or(not_known); }},
                         {"decode_ms", "", [](const auto& r) { return r.decode_ms; }},
                         {"frame_ms", "", [](const auto& r) { return r.frame_ms; }},
                         {"time_ms", "", [](const auto& r) { return r.time_ms(); }}});
    return section;
}

}  // namespace lodestream::report
