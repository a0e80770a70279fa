#include "client/report/sections.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "client/report/text.h"

namespace lodestream::report {
namespace {

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

template <class Row>
struct Field {
    std::string key;
    std::string label;
    std::function<Cell(const Row&)> value;
};

template <class Row>
Table table_of(const std::vector<Row>& rows, const std::vector<Field<Row>>& fields) {
    Table table;
    for (const auto& field : fields) table.columns.push_back({field.key, field.label});
    for (const Row& row : rows) {
        auto& cells = table.rows.emplace_back();
        for (const auto& field : fields) cells.push_back(field.value(row));
    }
    return table;
}

template <class T>
Cell optional_cell(const std::optional<T>& value) {
    return value ? Cell{*value} : Cell{};
}

double share_percent(double part, double whole) {
    return whole > 0.0 ? 100.0 * part / whole : not_known;
}

const ModeResult& hybrid_of(const DeviceResult& device) {
    return device.modes[0];
}
const ModeResult& gouraud_of(const DeviceResult& device) {
    return device.modes[1];
}
const ModeResult& flat_of(const DeviceResult& device) {
    return device.modes[2];
}

struct DeviceRow {
    const AssetResult* asset = nullptr;
    const DeviceResult* device = nullptr;
};

std::vector<DeviceRow> device_rows(const ReportData& data) {
    std::vector<DeviceRow> rows;
    for (const AssetResult& asset : data.assets)
        for (const DeviceResult& device : asset.devices) rows.push_back({&asset, &device});
    return rows;
}

budget::Display display_of(const DeviceResult& device) {
    return device.request.display.value_or(shading::default_display);
}

std::string display_text(const budget::Display& display) {
    return std::to_string(display.width) + "×" + std::to_string(display.height);
}

std::string device_title(const DeviceRow& row) {
    return row.asset->asset.name + " on " + row.device->device + ": " + format_count(row.device->plan.level.triangles) +
           " triangles";
}

// ---- budget

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

Section budget_section(const std::vector<DeviceRow>& rows) {
    Section section{"budget", "How many triangles each device gets", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>A device’s <dfn>capacity</dfn> over that of a reference device (3400 MHz) is its <dfn>device level "
        "ratio</dfn>, DLR. "
        "What the reference shows (NPP: 1,000,000 triangles/s at 30 frames/s, or the whole model where it is smaller) "
        "times DLR is the "
        "most triangles that this device can show: <dfn>NCP</dfn>, rounded down. Display, network, memory, the user’s "
        "wish and the "
        "model itself can only lower it. “Limited by” names the limit that decided.</p>";
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

// ---- simplification

// A rung of the ladder, or the level cut for a device.
struct LevelRow {
    const AssetResult* asset = nullptr;
    const LadderLevel* rung = nullptr;
    const DeviceResult* device = nullptr;
};

std::vector<LevelRow> level_rows(const ReportData& data) {
    std::vector<LevelRow> rows;
    for (const AssetResult& asset : data.assets) {
        for (const LadderLevel& rung : asset.ladder) rows.push_back({&asset, &rung, nullptr});
        for (const DeviceResult& device : asset.devices) rows.push_back({&asset, nullptr, &device});
    }
    return rows;
}

// Reads a field that rungs and cut levels share.
template <class Get>
auto level_field(Get get) {
    return [get](const LevelRow& row) -> Cell { return row.rung ? get(row.rung->level) : get(row.device->plan.level); };
}

double percent_of_diagonal(const LevelRow& row, double error) {
    return share_percent(error, row.asset->diagonal);
}

std::vector<Field<LevelRow>> level_name_fields() {
    return {{"asset", "model", [](const LevelRow& r) { return r.asset->asset.name; }},
            {"level", "level", [](const LevelRow& r) { return r.rung ? Cell{r.rung->index} : Cell{}; }},
            {"device", "cut for", [](const LevelRow& r) { return r.device ? Cell{r.device->device} : Cell{}; }},
            {"triangles", "triangles", level_field([](const auto& level) { return level.triangles; })}};
}

std::vector<Field<LevelRow>> joined(std::vector<Field<LevelRow>> first, std::vector<Field<LevelRow>> second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

std::string rung_title(const AssetResult& asset, const LadderLevel& rung) {
    return asset.asset.name + ", level " + std::to_string(rung.index) + ": " + format_count(rung.level.triangles) +
           " triangles, RMS " + format_number(rung.level.rms_error_percent) + " %, " +
           format_bytes(static_cast<double>(rung.level.bytes));
}

// One line an asset over its ladder, sharing colours between plots.
template <class X, class Y>
std::vector<Series> ladder_series(const ReportData& data, X x, Y y) {
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

Section simplification_section(const ReportData& data) {
    Section section{"simplification", "What fewer triangles cost in shape", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>A model is simplified once, when it is baked; the record of that one pass is then cut at any number of "
        "triangles. "
        "Errors are measured on the finished level in both directions against the original surface: the root mean "
        "square and the "
        "largest distance, in % of the diagonal of the model’s bounding box. Both axes are logarithmic: a straight "
        "line "
        "that falls to the right means that each halving of the triangles multiplies the error by the same factor. "
        "Levels without any error lie off such an axis.</p><ul>";
    for (const AssetResult& asset : data.assets)
        section.text_html += "<li><strong>" + escape_html(asset.asset.name) +
                             "</strong>: " + format_count(asset.asset.triangles) + " triangles baked in " +
                             format_duration(asset.asset.bake_ms) +
                             (asset.asset.peak_memory_bytes > 0
                                  ? ", peak memory " + format_bytes(static_cast<double>(asset.asset.peak_memory_bytes))
                                  : "") +
                             ".</li>";
    section.text_html += "</ul>";
    section.plots = {error_over_triangles(data),
                     {"Error against the time to encode a level",
                      {"encode, ms", AxisScale::logarithmic},
                      {"RMS error, % of the model’s diagonal", AxisScale::logarithmic},
                      ladder_series(
                          data, [](const LadderLevel& rung) { return rung.level.encode_ms; }, rms_percent),
                      {}},
                     error_over_cut_time(data)};
    section.rows = table_of<LevelRow>(
        level_rows(data),
        joined(
            level_name_fields(),
            {{"vertices", "vertices", level_field([](const auto& level) { return level.vertices; })},
             {"rms_error", "", level_field([](const auto& level) { return level.rms_error; })},
             {"max_error", "", level_field([](const auto& level) { return level.max_error; })},
             {"rms_error_percent", "RMS error %",
              level_field([](const auto& level) { return level.rms_error_percent; })},
             {"max_error_percent", "max error %",
              [](const auto& r) {
                  return percent_of_diagonal(r, r.rung ? r.rung->level.max_error : r.device->plan.level.max_error);
              }},
             {"bytes", "bytes",
              [](const auto& r) { return r.rung ? r.rung->level.bytes : r.device->plan.content.bytes; }},
             {"cut_ms", "cut ms", [](const auto& r) { return r.rung ? Cell{} : Cell{r.device->plan.timing_ms.cut}; }},
             {"encode_ms", "encode ms",
              [](const auto& r) { return r.rung ? r.rung->level.encode_ms : r.device->plan.timing_ms.encode; }},
             {"bake_ms", "", [](const auto& r) { return r.asset->asset.bake_ms; }}}));
    return section;
}

// ---- codec

// A rung as stored, or a device's level in one shading mode.
struct CodecRow {
    LevelRow level;
    const ModeResult* mode = nullptr;

    std::uint64_t triangles() const {
        return level.rung ? level.rung->level.triangles : level.device->plan.level.triangles;
    }
    std::uint64_t bytes() const { return mode ? mode->bytes : level.rung->level.bytes; }
};

std::vector<CodecRow> codec_rows(const ReportData& data) {
    std::vector<CodecRow> rows;
    for (const LevelRow& level : level_rows(data)) {
        if (level.rung)
            rows.push_back({level, nullptr});
        else
            for (const ModeResult& mode : level.device->modes) rows.push_back({level, &mode});
    }
    return rows;
}

double bytes_per_triangle(std::uint64_t bytes, std::uint64_t triangles) {
    return triangles > 0 ? static_cast<double>(bytes) / static_cast<double>(triangles) : not_known;
}

double saved_percent(const DeviceResult& device) {
    const double gouraud = static_cast<double>(gouraud_of(device).bytes);
    return share_percent(gouraud - static_cast<double>(hybrid_of(device).bytes), gouraud);
}

Table mode_bytes_table(const ReportData& data) {
    return table_of<DeviceRow>(
        device_rows(data),
        {{"asset", "model", [](const auto& r) { return r.asset->asset.name; }},
         {"device", "device", [](const auto& r) { return r.device->device; }},
         {"triangles", "triangles", [](const auto& r) { return r.device->plan.level.triangles; }},
         {"flat", "of them flat", [](const auto& r) { return hybrid_of(*r.device).flat; }},
         {"hybrid", "hybrid, bytes", [](const auto& r) { return hybrid_of(*r.device).bytes; }},
         {"gouraud", "all Gouraud, bytes", [](const auto& r) { return gouraud_of(*r.device).bytes; }},
         {"flat_bytes", "all flat, bytes", [](const auto& r) { return flat_of(*r.device).bytes; }},
         {"saved", "hybrid saves %", [](const auto& r) { return saved_percent(*r.device); }},
         {"per_triangle", "hybrid, bytes a triangle",
          [](const auto& r) { return bytes_per_triangle(hybrid_of(*r.device).bytes, r.device->plan.level.triangles); }},
         {"decode", "decode ms", [](const auto& r) { return hybrid_of(*r.device).decode_ms; }},
         {"left_out_bytes", "left out, bytes", [](const auto& r) { return r.device->left_out_bytes; }}});
}

Section codec_section(const ReportData& data) {
    Section section{"codec", "What a level costs to send", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>A level travels as plain glTF 2.0 with Draco compression, in no more bits than its own error is worth. "
        "Flat triangles "
        "carry no normals. The table compares the level that each device was sent with the same triangles all Gouraud "
        "shaded "
        "and all flat; “left out” is what the server says it did not have to send.</p>";
    const auto bytes = [](const LadderLevel& rung) { return static_cast<double>(rung.level.bytes); };
    const auto triangles = [](const LadderLevel& rung) { return static_cast<double>(rung.level.triangles); };
    section.plots = {{"Error against bytes, level by level",
                      {"bytes", AxisScale::logarithmic},
                      {"RMS error, % of the model’s diagonal", AxisScale::logarithmic},
                      ladder_series(data, bytes, rms_percent),
                      {}},
                     {"Bytes a triangle",
                      {"triangles", AxisScale::logarithmic},
                      {"bytes a triangle"},
                      ladder_series(data, triangles,
                                    [](const AssetResult&, const LadderLevel& rung) {
                                        return bytes_per_triangle(rung.level.bytes, rung.level.triangles);
                                    }),
                      {}}};
    section.shown = mode_bytes_table(data);
    section.rows = table_of<CodecRow>(
        codec_rows(data),
        {{"asset", "", [](const auto& r) { return r.level.asset->asset.name; }},
         {"level", "", [](const auto& r) { return r.level.rung ? Cell{r.level.rung->index} : Cell{}; }},
         {"device", "", [](const auto& r) { return r.level.device ? Cell{r.level.device->device} : Cell{}; }},
         {"shading", "", [](const auto& r) { return r.mode ? Cell{proto::shading_mode_name(r.mode->mode)} : Cell{}; }},
         {"triangles", "", [](const auto& r) { return r.triangles(); }},
         {"gouraud", "", [](const auto& r) { return r.mode ? Cell{r.mode->gouraud} : Cell{}; }},
         {"flat", "", [](const auto& r) { return r.mode ? Cell{r.mode->flat} : Cell{}; }},
         {"bytes", "", [](const auto& r) { return r.bytes(); }},
         {"bytes_per_triangle", "", [](const auto& r) { return bytes_per_triangle(r.bytes(), r.triangles()); }},
         {"rms_error_percent", "",
          [](const auto& r) {
              return r.level.rung ? r.level.rung->level.rms_error_percent
                                  : r.level.device->plan.level.rms_error_percent;
          }},
         {"decode_ms", "", [](const auto& r) { return r.mode ? r.mode->decode_ms : r.level.rung->decode_ms; }}});
    return section;
}

// ---- shading

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
            series.name = proto::shading_mode_name(result.mode);
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

bool lies_between(const DeviceResult& device) {
    constexpr double tolerance_percent = 0.01;  // of full scale; below what 8-bit pictures resolve
    const auto [low, high] = std::minmax(gouraud_of(device).image.percent, flat_of(device).image.percent);
    const double hybrid = hybrid_of(device).image.percent;
    return hybrid >= low - tolerance_percent && hybrid <= high + tolerance_percent;
}

std::string between_sentence(const std::vector<DeviceRow>& rows) {
    const auto between =
        std::count_if(rows.begin(), rows.end(), [](const DeviceRow& r) { return lies_between(*r.device); });
    return "The picture of the hybrid level lies between flat and Gouraud in " + std::to_string(between) + " of " +
           std::to_string(rows.size()) + " cases.";
}

Section shading_section(const ReportData& data) {
    Section section{"shading", "Gouraud, flat, and both at once", {}, {}, {}, {}, {}};
    section.text_html =
        "<p><dfn>Gouraud</dfn> shading lights the corners of a triangle and blends between them; <dfn>flat</dfn> "
        "shading gives the "
        "triangle one colour and needs no normals. A <dfn>hybrid</dfn> level uses both: the farther the object, the "
        "larger the share "
        "d of flat triangles. The error of a picture is the root mean square difference of its pixels from the full "
        "model’s picture, all Gouraud, same view and same size, where either of the two shows the object. " +
        between_sentence(device_rows(data)) +
        "</p><p>Each point of the first plots is one device class. The plots over d hold the triangles and the drawn "
        "view fixed and "
        "change only the split; d = 0 is all Gouraud, d = 1 all flat.</p>";
    for (const AssetResult& asset : data.assets) section.plots.push_back(mode_plot(asset));
    const bool has_split =
        std::any_of(data.assets.begin(), data.assets.end(), [](const auto& a) { return !a.split.empty(); });
    if (has_split) {
        section.plots.push_back(
            split_plot(data, "Error of the picture over the split", "error of the picture, %",
                       [](const auto&, const SplitStep& step) { return step.result.image.percent; }));
        section.plots.push_back(split_plot(
            data, "Bytes over the split", "bytes, % of all Gouraud", [](const auto& asset, const SplitStep& step) {
                return share_percent(static_cast<double>(step.result.bytes),
                                     static_cast<double>(asset.split.front().result.bytes));
            }));
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

// ---- end to end

// One level on its way to one device over one link: everything between the click and the picture.
struct JourneyRow {
    const AssetResult* asset = nullptr;
    const DeviceResult* device = nullptr;
    const LadderLevel* rung = nullptr;  // null: the level cut for the device
    Link link;
    double fetch_ms = 0.0, decode_ms = 0.0, frame_ms = 0.0;
    double rms_error_percent = 0.0, error_px = 0.0, image_error_percent = 0.0;
    std::uint64_t triangles = 0, bytes = 0;

    double time_ms() const {
        return device->replan_ms + fetch_ms + link_ms(link, static_cast<double>(bytes)) + decode_ms + frame_ms;
    }
};

JourneyRow cut_journey(const AssetResult& asset, const DeviceResult& device, const Link& link) {
    const ModeResult& sent = hybrid_of(device);
    const auto& level = device.plan.level;
    return {&asset,
            &device,
            nullptr,
            link,
            sent.fetch_ms,
            sent.decode_ms,
            sent.frame_ms,
            level.rms_error_percent,
            level.screen_space_error_px,
            sent.image.percent,
            level.triangles,
            sent.bytes};
}

std::vector<JourneyRow> rung_journeys(const AssetResult& asset, const DeviceResult& device, const Link& link) {
    std::vector<JourneyRow> rows;
    for (const LadderLevel& rung : asset.ladder)
        for (const DrawnLevel& drawn : rung.drawn)
            if (drawn.device == device.device)
                rows.push_back({&asset, &device, &rung, link, rung.fetch_ms, rung.decode_ms, drawn.frame_ms,
                                rung.level.rms_error_percent, drawn.error_px, drawn.image.percent, rung.level.triangles,
                                rung.level.bytes});
    return rows;
}

std::vector<JourneyRow> journeys(const ReportData& data) {
    std::vector<JourneyRow> rows;
    for (const auto& [asset, device] : device_rows(data))
        for (const Link& link : links) {
            rows.push_back(cut_journey(*asset, *device, link));
            const std::vector<JourneyRow> rungs = rung_journeys(*asset, *device, link);
            rows.insert(rows.end(), rungs.begin(), rungs.end());
        }
    return rows;
}

std::string link_text(const Link& link) {
    return format_number(link.downlink_mbps) + " Mbit/s";
}

Plot journey_plot(const AssetResult& asset, const DeviceResult& device) {
    Plot plot{asset.asset.name + " on " + device.device + ", " + display_text(display_of(device)),
              {"time since the click, ms", AxisScale::logarithmic},
              {"error of the picture, %", AxisScale::logarithmic},
              {},
              {}};
    for (const Link& link : links) {
        Series series{link_text(link), {}, true, true, false, {}};
        for (const JourneyRow& row : rung_journeys(asset, device, link))
            series.points.push_back(
                {row.time_ms(), row.image_error_percent,
                 link_text(link) + ", level " + std::to_string(row.rung->index) + ": " + format_count(row.triangles) +
                     " triangles, " + format_bytes(static_cast<double>(row.bytes)) + ", drawn after " +
                     format_duration(row.time_ms()) + ", error " + format_number(row.image_error_percent) + " %"});
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
    for (const Link& link : links)
        fields.push_back({"", "ms at " + link_text(link),
                          [link](const DeviceRow& r) { return cut_journey(*r.asset, *r.device, link).time_ms(); }});
    return table_of<DeviceRow>(device_rows(data), fields);
}

Section end_to_end_section(const ReportData& data) {
    Section section{"end_to_end", "From the click to the picture", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>How good the picture is, and how long after the click: plan + fetch + decode + first frame, for each level "
        "of the ladder "
        "(one point a level, coarse to fine from left to right) over four links. <strong>Link time is computed, not "
        "throttled</strong>: "
        "bytes × 8 ÷ rate, and a round trip each for the plan and the content (";
    for (const Link& link : links)
        section.text_html +=
            (&link == links ? "" : ", ") + link_text(link) + " with " + format_number(link.rtt_ms) + " ms";
    section.text_html +=
        "). Everything else is measured between server and client on this machine: decode and frame times are "
        "<em>this</em> machine’s at the device’s display size, not those of a device of that class. The table has the "
        "level "
        "that was cut for each device; “first plan” includes cutting, measuring and encoding it, later plans find it "
        "in the store.</p>";
    for (const AssetResult& asset : data.assets)
        for (const DeviceResult& device : asset.devices) {
            const bool outer = &device == &asset.devices.front() || &device == &asset.devices.back();
            (outer ? section.plots : section.folded_plots).push_back(journey_plot(asset, device));
        }
    section.shown = journey_table(data);
    section.rows = table_of<JourneyRow>(
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
                         {"decode_ms", "", [](const auto& r) { return r.decode_ms; }},
                         {"frame_ms", "", [](const auto& r) { return r.frame_ms; }},
                         {"time_ms", "", [](const auto& r) { return r.time_ms(); }}});
    return section;
}

// ---- summary

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
           " % of the model’s size on average, its picture by " + format_number(hybrid_of(*row.device).image.percent) +
           " %.";
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
                        : "but more in " + std::to_string(larger) + " of " + std::to_string(counted) + " cases.");
}

std::string time_sentence(const DeviceRow& row) {
    const Link& link = links[1];
    const ModeResult& sent = hybrid_of(*row.device);
    const double own = cut_journey(*row.asset, *row.device, link).time_ms();
    const double full = own + link_ms(link, static_cast<double>(row.asset->full_bytes)) -
                        link_ms(link, static_cast<double>(sent.bytes));
    return "On a link of " + link_text(link) + " the " + escape_html(row.device->device) + "’s picture of " +
           escape_html(row.asset->asset.name) + " is there " + strong(format_duration(own)) +
           " after the click; the bytes of the full model alone would take it to " + format_duration(full) + ".";
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

double link_ms(const Link& link, double bytes) {
    return bytes * 8.0 / (link.downlink_mbps * 1e3) + 2.0 * link.rtt_ms;
}

Table overview_table(const ReportData& data) {
    return table_of<DeviceRow>(
        device_rows(data),
        {{"asset", "model", [](const auto& r) { return r.asset->asset.name; }},
         {"device", "device", [](const auto& r) { return r.device->device; }},
         {"capacity_mhz", "MHz", [](const auto& r) { return budget::capacity_mhz(r.device->request.device); }},
         {"dlr", "DLR", [](const auto& r) { return r.device->plan.dlr; }},
         {"ncp", "NCP", [](const auto& r) { return r.device->plan.ncp; }},
         {"budget_triangles", "budget", [](const auto& r) { return r.device->plan.budget.triangles; }},
         {"limited_by", "by", [](const auto& r) { return r.device->plan.budget.limited_by; }},
         {"triangles", "level", [](const auto& r) { return r.device->plan.level.triangles; }},
         {"gouraud", "Gouraud", [](const auto& r) { return r.device->plan.shading.gouraud; }},
         {"flat", "flat", [](const auto& r) { return r.device->plan.shading.flat; }},
         {"rms_error_percent", "RMS %", [](const auto& r) { return r.device->plan.level.rms_error_percent; }},
         {"screen_space_error_px", "max px", [](const auto& r) { return r.device->plan.level.screen_space_error_px; }},
         {"bytes", "bytes", [](const auto& r) { return r.device->plan.content.bytes; }},
         {"left_out_bytes", "left out", [](const auto& r) { return r.device->left_out_bytes; }},
         {"saved_percent", "vs G %", [](const auto& r) { return -saved_percent(*r.device); }},
         {"image_hybrid", "pic %", [](const auto& r) { return hybrid_of(*r.device).image.percent; }},
         {"image_gouraud", "all G %", [](const auto& r) { return gouraud_of(*r.device).image.percent; }},
         {"image_flat", "all F %", [](const auto& r) { return flat_of(*r.device).image.percent; }},
         {"plan_ms", "plan ms", [](const auto& r) { return r.device->plan.timing_ms.plan; }},
         {"cut_ms", "cut ms", [](const auto& r) { return r.device->plan.timing_ms.cut; }},
         {"encode_ms", "enc ms", [](const auto& r) { return r.device->plan.timing_ms.encode; }},
         {"fetch_ms", "fetch", [](const auto& r) { return hybrid_of(*r.device).fetch_ms; }},
         {"decode_ms", "decode", [](const auto& r) { return hybrid_of(*r.device).decode_ms; }},
         {"frame_ms", "frame ms", [](const auto& r) { return hybrid_of(*r.device).frame_ms; }}});
}

std::vector<Section> sections(const ReportData& data) {
    return {budget_section(device_rows(data)), simplification_section(data), codec_section(data), shading_section(data),
            end_to_end_section(data)};
}

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
