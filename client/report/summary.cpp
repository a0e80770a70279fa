#include "client/report/section_rows.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "client/report/text.h"

namespace lodestream::report {
namespace {

std::string strong(const std::string& text) {
    return "<strong>" + text + "</strong>";
}

std::string example_sentence(const DeviceRow& row) {
    const auto& level = row.device->plan.level;
    const double share =
        share_percent(static_cast<double>(hybrid_of(*row.device).bytes), static_cast<double>(row.asset->full_bytes));
    return "The " + escape_html(row.device->device) + " (" +
           format_number(budget::capacity_mhz(row.device->request.device)) + " MHz, " +
           display_text(display_of(*row.device)) + ") shows " + escape_html(row.asset->asset.name) + " with " +
           strong(format_count(level.triangles)) + " of " + format_count(row.asset->full_triangles) +
           " triangles: " + strong(format_bytes(static_cast<double>(hybrid_of(*row.device).bytes))) + " instead of " +
           format_bytes(static_cast<double>(row.asset->full_bytes)) + " (" + format_number(share) +
           " %). Its surface is off by " + format_number(level.rms_error_percent) +
           " % of the model’s size (root mean square), its picture by " +
           format_number(hybrid_of(*row.device).image.percent) + " %.";
}

std::string limits_sentence(const std::vector<DeviceRow>& rows) {
    std::map<std::string, int> counts;
    std::size_t kept = 0;
    for (const DeviceRow& row : rows) {
        ++counts[row.device->plan.budget.limited_by];
        kept += row.device->plan.level.triangles <= row.device->plan.budget.triangles;
    }
    std::string out = "Every budget held in " + strong(std::to_string(kept) + " of " + std::to_string(rows.size())) +
                      " plans. What decided it: ";
    for (const auto& [limit, count] : counts)
        out += (limit == counts.begin()->first ? "" : ", ") + escape_html(limit) + " " + std::to_string(count) + "×";
    return out + ".";
}

// The server sends a level all Gouraud where splitting it would cost more bytes than it saves.
std::string fallback_sentence(const std::vector<DeviceRow>& rows) {
    const auto kept_whole = std::count_if(rows.begin(), rows.end(), [](const DeviceRow& row) {
        return row.device->plan.shading.distance > 0.0 && hybrid_of(*row.device).flat == 0;
    });
    if (kept_whole == 0) return "";
    return std::string(" ") + std::to_string(kept_whole) + " of " + std::to_string(rows.size()) +
           " went all Gouraud, because any split of them would have been larger.";
}

std::string bytes_sentence(const std::vector<DeviceRow>& rows) {
    double sum = 0.0, least = std::numeric_limits<double>::infinity(), most = -least;
    std::size_t counted = 0, larger = 0;
    for (const DeviceRow& row : rows) {
        const double saved = saved_percent(*row.device);
        if (!std::isfinite(saved)) continue;
        ++counted;
        sum += saved;
        least = std::min(least, saved);
        most = std::max(most, saved);
        larger += hybrid_of(*row.device).bytes > gouraud_of(*row.device).bytes;
    }
    if (counted == 0) return "";
    return "Hybrid levels take " + strong(format_number(sum / static_cast<double>(counted)) + " % fewer bytes") +
           " than the same levels all Gouraud (from " + format_number(least) + " to " + format_number(most) + " %), " +
           (larger == 0 ? "never more."
                        : "but more in " + std::to_string(larger) + " of " + std::to_string(counted) + " cases.") +
           fallback_sentence(rows);
}

std::string time_sentence(const DeviceRow& row) {
    const auto& network = row.device->request.network;
    Journey journey = cut_journey(row, 1);
    if (network) {
        journey.link = {network->downlink_mbps, network->rtt_ms};
        journey.linked_ms.reset();
    }
    const Link& link = journey.link;
    const ModeResult& sent = hybrid_of(*row.device);
    const double own = journey.time_ms();
    const double full = own + link_ms(link, static_cast<double>(row.asset->full_bytes)) -
                        link_ms(link, static_cast<double>(sent.bytes));
    return "Over " + link_text(link) + " the " + escape_html(row.device->device) + "’s picture of " +
           escape_html(row.asset->asset.name) + " is there " + strong(format_duration(own)) +
           " after the click (link time computed); the bytes of the full model alone would make it " +
           format_duration(full) + ".";
}

std::string bake_sentence(const ReportData& data, const std::vector<DeviceRow>& rows) {
    const auto largest = std::max_element(data.assets.begin(), data.assets.end(), [](const auto& a, const auto& b) {
        return a.asset.triangles < b.asset.triangles;
    });
    const auto slowest = std::max_element(rows.begin(), rows.end(), [](const DeviceRow& a, const DeviceRow& b) {
        return a.device->plan.timing_ms.cut < b.device->plan.timing_ms.cut;
    });
    return "The largest model, " + escape_html(largest->asset.name) + " with " +
           format_count(largest->asset.triangles) + " triangles, is baked once in " +
           format_duration(largest->asset.bake_ms) +
           ". After that any budget is a cut: the slowest of this report took " +
           strong(format_duration(slowest->device->plan.timing_ms.cut)) + ".";
}

}  // namespace

std::vector<std::string> summary_html(const ReportData& data) {
    const std::vector<DeviceRow> rows = device_rows(data);
    if (rows.empty()) return {"No model could be measured."};
    const auto extreme = std::min_element(rows.begin(), rows.end(), [](const DeviceRow& a, const DeviceRow& b) {
        const auto share = [](const DeviceRow& r) {
            return share_percent(static_cast<double>(r.device->plan.level.triangles),
                                 static_cast<double>(r.asset->full_triangles));
        };
        return share(a) < share(b);
    });
    std::vector<std::string> out = {example_sentence(*extreme), time_sentence(*extreme), limits_sentence(rows),
                                    bytes_sentence(rows),       between_sentence(rows),  bake_sentence(data, rows)};
    std::erase(out, "");
    return out;
}

}  // namespace lodestream::report
