#include "client/report/section_rows.h"

#include <map>

#include "client/report/text.h"

namespace lodestream::report {
namespace {

template <class T>
Cell optional_cell(const std::optional<T>& value) {
    return value ? Cell{*value} : Cell{};
}

Plot budget_plot(const std::vector<DeviceRow>& rows) {
    Plot plot{"Triangles that a device gets, against its capacity",
              {"capacity, MHz of the papers' scale", AxisScale::logarithmic},
              {"budget, triangles", AxisScale::logarithmic},
              {},
              {}};
    std::map<std::string, Series> by_limit;
    std::map<std::string, double> guides;
    for (const DeviceRow& row : rows) {
        const double capacity = budget::capacity_mhz(row.device->request.device);
        const auto& given = row.device->plan.budget;
        guides[row.device->device] = capacity;
        by_limit[given.limited_by].points.push_back({capacity, static_cast<double>(given.triangles),
                                                     row.asset->asset.name + " on " + row.device->device + ": " +
                                                         format_count(given.triangles) + " triangles, limited by " +
                                                         given.limited_by});
    }
    Series rule{"NCP of a large model at 30 frames/s", {}, true, false, true, 6};
    for (const double capacity : {50.0, 5000.0})
        rule.points.push_back(
            {capacity, budget::reference_triangles_per_second / 30.0 * capacity / budget::reference_capacity_mhz, ""});
    plot.series.push_back(rule);
    std::size_t style = 0;
    for (auto& [limit, series] : by_limit) {
        series.name = "limited by " + limit;
        series.line = false;
        series.style = style++;
        plot.series.push_back(series);
    }
    for (const auto& [device, capacity] : guides) plot.guides.push_back({capacity, device});
    return plot;
}

}  // namespace

Section budget_section(const ReportData& data) {
    const std::vector<DeviceRow> rows = device_rows(data);
    Section section{"budget", "How many triangles each device gets", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>A device’s <dfn>capacity</dfn> over that of a reference device (3400 MHz) is its <dfn>device level "
        "ratio</dfn>, DLR. What the reference shows (NPP: 1,000,000 triangles/s at 30 frames/s, or the whole model "
        "where it is smaller) times DLR is the most triangles that this device can show: <dfn>NCP</dfn>, rounded "
        "down. Display, network, memory, the user’s wish and the model itself can only lower it. “Limited by” names "
        "the limit that decided.</p>";
    section.plots = {budget_plot(rows)};
    section.rows = table_of<DeviceRow>(
        rows,
        {{"asset", "model", [](const auto& r) { return r.asset->asset.name; }},
         {"device", "device", [](const auto& r) { return r.device->device; }},
         {"width", "", [](const auto& r) { return std::uint64_t{display_of(*r.device).width}; }},
         {"height", "", [](const auto& r) { return std::uint64_t{display_of(*r.device).height}; }},
         {"display", "display", [](const auto& r) { return display_text(display_of(*r.device)); }},
         {"cpu_mhz", "clock MHz", [](const auto& r) { return r.device->request.device.cpu_mhz; }},
         {"capacity_mhz", "capacity MHz", [](const auto& r) { return budget::capacity_mhz(r.device->request.device); }},
         {"dlr", "DLR", [](const auto& r) { return r.device->plan.dlr; }},
         {"ncp", "NCP", [](const auto& r) { return r.device->plan.ncp; }},
         {"rup", "", [](const auto& r) { return optional_cell(r.device->plan.rup); }},
         {"asset_triangles", "of the model’s", [](const auto& r) { return r.asset->full_triangles; }},
         {"budget_triangles", "budget", [](const auto& r) { return r.device->plan.budget.triangles; }},
         {"limited_by", "limited by", [](const auto& r) { return r.device->plan.budget.limited_by; }},
         {"triangles", "level", [](const auto& r) { return r.device->plan.level.triangles; }},
         {"distance", "distance d", [](const auto& r) { return r.device->plan.shading.distance; }},
         {"gouraud", "Gouraud", [](const auto& r) { return r.device->plan.shading.gouraud; }},
         {"flat", "flat", [](const auto& r) { return r.device->plan.shading.flat; }}});
    return section;
}

}  // namespace lodestream::report
