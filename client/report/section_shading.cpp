#include "client/report/section_rows.h"

#include <algorithm>

#include "client/report/text.h"

namespace lodestream::report {
namespace {

struct ShadingRow {
    const AssetResult* asset = nullptr;
    std::string device;
    std::string series;  // "devices" or "split"
    double distance = 0.0;
    std::uint64_t triangles = 0;
    const ModeResult* result = nullptr;
};

std::vector<ShadingRow> shading_rows(const ReportData& data) {
    std::vector<ShadingRow> rows;
    for (const AssetResult& asset : data.assets) {
        for (const DeviceResult& device : asset.devices)
            for (const ModeResult& mode : device.modes)
                rows.push_back({&asset, device.device, "devices", device.plan.shading.distance,
                                device.plan.level.triangles, &mode});
        for (const SplitStep& step : asset.split)
            rows.push_back({&asset, asset.split_device, "split", step.distance, step.triangles, &step.result});
    }
    return rows;
}

std::string mode_label(proto::ShadingMode mode) {
    return mode == proto::ShadingMode::gouraud ? "Gouraud" : proto::shading_mode_name(mode);
}

Plot mode_plot(const AssetResult& asset) {
    Plot plot{asset.asset.name + ": error of the picture against frame time",
              {"frame, ms", AxisScale::logarithmic},
              {"error of the picture, %"},
              {},
              {}};
    for (std::size_t mode = 0; mode < 3; ++mode) {
        Series series{"", {}, false, true, false, mode};
        for (const DeviceResult& device : asset.devices) {
            const ModeResult& result = device.modes[mode];
            series.name = mode_label(result.mode);
            series.points.push_back({result.frame_ms, result.image.percent,
                                     device_title({&asset, &device}) + ", " + series.name + ", " +
                                         format_duration(result.frame_ms) + ", error " +
                                         format_number(result.image.percent) + " %"});
        }
        plot.series.push_back(std::move(series));
    }
    return plot;
}

template <class Y>
Plot split_plot(const ReportData& data, std::string title, std::string label, Y y) {
    Plot plot{std::move(title), {"d: share of flat triangles"}, {std::move(label)}, {}, {}};
    for (std::size_t i = 0; i < data.assets.size(); ++i) {
        Series series{data.assets[i].asset.name, {}, true, true, false, i};
        for (const SplitStep& step : data.assets[i].split)
            series.points.push_back({step.distance, y(data.assets[i], step),
                                     series.name + ", d = " + format_number(step.distance) + ": " +
                                         format_count(step.result.flat) + " of " + format_count(step.triangles) +
                                         " triangles flat"});
        if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    return plot;
}

// Bytes of a step against the same level all Gouraud, which was measured with the device classes.
double percent_of_all_gouraud(const AssetResult& asset, const SplitStep& step) {
    const auto device = std::find_if(asset.devices.begin(), asset.devices.end(),
                                     [&](const DeviceResult& d) { return d.device == asset.split_device; });
    if (device == asset.devices.end()) return not_known;
    return share_percent(static_cast<double>(step.result.bytes), static_cast<double>(gouraud_of(*device).bytes));
}

}  // namespace

Section shading_section(const ReportData& data) {
    Section section{"shading", "Gouraud, flat, and both at once", {}, {}, {}, {}, {}};
    section.text_html =
        "<p><dfn>Gouraud</dfn> shading lights the corners of a triangle and blends between them; <dfn>flat</dfn> "
        "shading gives the triangle one colour and needs no normals. A <dfn>hybrid</dfn> level uses both: the "
        "farther the object, the larger the share d of flat triangles. The error of a picture is the root mean "
        "square difference of its pixels from the full model’s picture, all Gouraud, same view and same size, "
        "where either of the two shows the object. " +
        between_sentence(device_rows(data)) +
        "</p><p>Each point of the first plots is one device class. The plots over d hold the triangles and the "
        "drawn view fixed and change only the split; d = 0 is all Gouraud, d = 1 all flat.</p>";
    for (const AssetResult& asset : data.assets) section.plots.push_back(mode_plot(asset));
    const bool has_split =
        std::any_of(data.assets.begin(), data.assets.end(), [](const auto& a) { return !a.split.empty(); });
    if (has_split) {
        section.plots.push_back(
            split_plot(data, "Error of the picture over the split", "error of the picture, %",
                       [](const auto&, const SplitStep& step) { return step.result.image.percent; }));
        section.plots.push_back(
            split_plot(data, "Bytes over the split", "bytes, % of all Gouraud", percent_of_all_gouraud));
        section.plots.push_back(split_plot(data, "Frame time over the split", "frame, ms",
                                           [](const auto&, const SplitStep& step) { return step.result.frame_ms; }));
    }
    section.rows = table_of<ShadingRow>(
        shading_rows(data),
        {{"asset", "model", [](const auto& r) { return r.asset->asset.name; }},
         {"device", "device", [](const auto& r) { return r.device; }},
         {"series", "series", [](const auto& r) { return r.series; }},
         {"shading", "shading", [](const auto& r) { return proto::shading_mode_name(r.result->mode); }},
         {"distance", "d", [](const auto& r) { return r.distance; }},
         {"triangles", "triangles", [](const auto& r) { return r.triangles; }},
         {"gouraud", "Gouraud", [](const auto& r) { return r.result->gouraud; }},
         {"flat", "flat", [](const auto& r) { return r.result->flat; }},
         {"bytes", "bytes", [](const auto& r) { return r.result->bytes; }},
         {"gpu_bytes", "bytes on the GPU", [](const auto& r) { return r.result->gpu_bytes; }},
         {"image_error_percent", "picture’s error %", [](const auto& r) { return r.result->image.percent; }},
         {"silhouette_percent", "outline differs %", [](const auto& r) { return r.result->image.silhouette_percent; }},
         {"frame_ms", "frame ms", [](const auto& r) { return r.result->frame_ms; }}});
    return section;
}

}  // namespace lodestream::report
