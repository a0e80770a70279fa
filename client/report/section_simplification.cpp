#include "client/report/section_rows.h"

#include "client/report/text.h"

namespace lodestream::report {
namespace {

// A rung of the ladder, or the level cut for a device.
struct LevelRow {
    const AssetResult* asset = nullptr;
    Cell level, device;  // one of the two is empty
    Cell cut_ms;         // empty for rungs, which are cut in the bake
    std::uint64_t triangles = 0, vertices = 0, bytes = 0;
    double rms_error = 0.0, max_error = 0.0, rms_error_percent = 0.0, normal_error_degrees = 0.0, encode_ms = 0.0;
};

LevelRow rung_row(const AssetResult& asset, const LadderLevel& rung) {
    const proto::Level& level = rung.level;
    return {&asset,
            rung.index,
            {},
            {},
            level.triangles,
            level.vertices,
            level.bytes,
            level.rms_error,
            level.max_error,
            level.rms_error_percent,
            level.normal_error_degrees,
            level.encode_ms};
}

LevelRow cut_row(const AssetResult& asset, const DeviceResult& device) {
    const auto& level = device.plan.level;
    const auto& timing = device.plan.timing_ms;
    return {&asset,
            {},
            device.device,
            timing.cut,
            level.triangles,
            level.vertices,
            device.plan.content.bytes,
            level.rms_error,
            level.max_error,
            level.rms_error_percent,
            level.normal_error_degrees,
            timing.encode};
}

std::vector<LevelRow> level_rows(const ReportData& data) {
    std::vector<LevelRow> rows;
    for (const AssetResult& asset : data.assets) {
        for (const LadderLevel& rung : asset.ladder) rows.push_back(rung_row(asset, rung));
        for (const DeviceResult& device : asset.devices) rows.push_back(cut_row(asset, device));
    }
    return rows;
}

Plot error_over_triangles(const ReportData& data) {
    const auto triangles = [](const LadderLevel& rung) { return static_cast<double>(rung.level.triangles); };
    Plot plot{"Geometric error against triangles",
              {"triangles", AxisScale::logarithmic},
              {"error, % of the model’s diagonal", AxisScale::logarithmic},
              ladder_series(data, triangles, rms_percent),
              {}};
    for (Series& series : plot.series) series.name += ", RMS";
    for (Series& series : ladder_series(data, triangles, [](const AssetResult&asset, const LadderLevel&rung) {
             return share_percent(rung.level.max_error, asset.diagonal);
         })) {
        series.name += ", maximum";
        series.dashed = true;
        plot.series.push_back(std::move(series));
    }
    return plot;
}

Plot error_over_encode_time(const ReportData& data) {
    const auto encode_ms = [](const LadderLevel& rung) { return rung.level.encode_ms; };
    Plot plot{"Error against the time to encode a level",
              {"encode, ms", AxisScale::logarithmic},
              {"RMS error, % of the model’s diagonal", AxisScale::logarithmic},
              ladder_series(data, encode_ms, rms_percent),
              {}};
    for (Series& series : plot.series) series.line = false;
    return plot;
}

Plot error_over_cut_time(const ReportData& data) {
    Plot plot{"Error against the time to cut a level from the bake",
              {"cut, ms", AxisScale::logarithmic},
              {"RMS error, % of the model’s diagonal", AxisScale::logarithmic},
              {},
              {}};
    for (std::size_t i = 0; i < data.assets.size(); ++i) {
        Series series{data.assets[i].asset.name, {}, false, true, false, i};
        for (const DeviceResult& device : data.assets[i].devices)
            series.points.push_back(
                {device.plan.timing_ms.cut, device.plan.level.rms_error_percent,
                 device_title({&data.assets[i], &device}) + ", cut in " + format_duration(device.plan.timing_ms.cut)});
        plot.series.push_back(std::move(series));
    }
    return plot;
}

}  // namespace

Section simplification_section(const ReportData& data) {
    Section section{"simplification", "What fewer triangles cost in shape", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>A model is simplified once, when it is baked; the record of that one pass is then cut at any number of "
        "triangles. Errors are measured on the finished level in both directions against the original surface: the "
        "root mean square and the largest distance, in % of the diagonal of the model’s bounding box. Both axes are "
        "logarithmic: a straight line that falls to the right means that each halving of the triangles multiplies "
        "the error by the same factor. Levels without any error lie off such an axis.</p><ul>";
    for (const AssetResult& asset : data.assets)
        section.text_html += "<li><strong>" + escape_html(asset.asset.name) +
                             "</strong>: " + format_count(asset.asset.triangles) + " triangles baked in " +
                             format_duration(asset.asset.bake_ms) +
                             (asset.asset.peak_memory_bytes > 0
                                  ? ", peak memory " + format_bytes(static_cast<double>(asset.asset.peak_memory_bytes))
                                  : "") +
                             ".</li>";
    section.text_html += "</ul>";
    section.plots = {error_over_triangles(data), error_over_encode_time(data), error_over_cut_time(data)};
    section.rows = table_of<LevelRow>(
        level_rows(data),
        {{"asset", "model", [](const auto& r) { return r.asset->asset.name; }},
         {"level", "level", [](const auto& r) { return r.level; }},
         {"device", "cut for", [](const auto& r) { return r.device; }},
         {"triangles", "triangles", [](const auto& r) { return r.triangles; }},
         {"vertices", "vertices", [](const auto& r) { return r.vertices; }},
         {"rms_error", "", [](const auto& r) { return r.rms_error; }},
         {"max_error", "", [](const auto& r) { return r.max_error; }},
         {"rms_error_percent", "RMS error %", [](const auto& r) { return r.rms_error_percent; }},
         {"max_error_percent", "max error %",
          [](const auto& r) { return share_percent(r.max_error, r.asset->diagonal); }},
         {"normal_error_degrees", "normals off by, °", [](const auto& r) { return r.normal_error_degrees; }},
         {"bytes", "bytes", [](const auto& r) { return r.bytes; }},
         {"cut_ms", "cut ms", [](const auto& r) { return r.cut_ms; }},
         {"encode_ms", "encode ms", [](const auto& r) { return r.encode_ms; }},
         {"bake_ms", "", [](const auto& r) { return r.asset->asset.bake_ms; }}});
    return section;
}

}  // namespace lodestream::report
