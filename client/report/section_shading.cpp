#include "client/report/section_rows.h"
#include "client/report/shading_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "client/report/machine.h"
#include "client/report/table.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

// A measured level, or a sample of the study.
struct ShadingRow {
    const AssetResult* asset = nullptr;
    std::string device;
    ShadingSample sample;
};

std::vector<ShadingRow> shading_rows(const ReportData& data) {
    std::vector<ShadingRow> rows;
    const auto add = [&](const AssetResult& asset, const std::string& device, const char* series, double distance,
                         std::uint64_t triangles, const ModeResult& result) {
        ShadingSample sample;
        sample.series = series;
        sample.distance = distance;
        sample.triangles = triangles;
        sample.operations = budget::with_shading(0, result.gouraud, result.flat).total;
        sample.result = result;
        rows.push_back({&asset, device, std::move(sample)});
    };
    for (const AssetResult& asset : data.assets) {
        for (const DeviceResult& device : asset.devices)
            for (const ModeResult& mode : device.modes)
                add(asset, device.device, "devices", device.plan.shading.distance, device.plan.level.triangles, mode);
        for (const SplitStep& step : asset.split)
            add(asset, asset.split_device, "split", step.distance, step.triangles, step.result);
        for (const ShadingSample& sample : asset.shading) rows.push_back({&asset, "", sample});
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

// The samples of a series, in their order.
std::vector<const ShadingSample*> samples_of(const AssetResult& asset, const std::string& series,
                                             const std::string& criterion) {
    std::vector<const ShadingSample*> out;
    for (const ShadingSample& sample : asset.shading)
        if (sample.series == series && sample.criterion == criterion) out.push_back(&sample);
    return out;
}

// What each shading mode makes of the same price in the paper's operations.
struct EqualCost {
    const AssetResult* asset = nullptr;
    std::uint64_t operations = 0;
    double gouraud = not_known, flat = not_known, hybrid = not_known, hybrid_paper = not_known;  // image error, %
    double gouraud_at_flats_bytes = not_known;
    double flat_sent = not_known;  // its opponent there

    bool hybrid_wins() const { return hybrid < gouraud && hybrid < flat; }
};

EqualCost equal_cost(const AssetResult& asset) {
    EqualCost row{&asset};
    for (const ShadingSample& sample : asset.shading) {
        const double error = sample.result.image.percent;
        if (sample.series == "equal bytes")
            (sample.result.flat > 0 ? row.flat_sent : row.gouraud_at_flats_bytes) = error;
        if (sample.series != "equal operations") continue;
        if (sample.is_chosen) {
            (sample.criterion == "paper" ? row.hybrid_paper : row.hybrid) = error;
        } else if (sample.share_of_price >= 1.0) {
            row.flat = error;
            row.operations = sample.operations;
        } else if (sample.share_of_price <= 0.25) {
            row.gouraud = error;
        }
    }
    return row;
}

std::vector<EqualCost> equal_costs(const ReportData& data) {
    std::vector<EqualCost> rows;
    for (const AssetResult& asset : data.assets)
        if (!asset.shading.empty()) rows.push_back(equal_cost(asset));
    return rows;
}

// Error over where the price goes, as a share of the better of the two pure modes: below 100 hybrid pays.
Plot price_plot(const ReportData& data) {
    Plot plot{"The same price: from all Gouraud (left) to all flat (right)",
              {"triangles, share of what all flat affords"},
              {"error of the picture, % of the better pure mode"},
              {},
              {}};
    for (std::size_t i = 0; i < data.assets.size(); ++i) {
        const EqualCost ends = equal_cost(data.assets[i]);
        Series series{data.assets[i].asset.name, {}, true, true, false, i};
        std::vector<const ShadingSample*> samples =
            samples_of(data.assets[i], "equal operations", "measured importance");
        std::sort(samples.begin(), samples.end(),
                  [](const auto* a, const auto* b) { return a->share_of_price < b->share_of_price; });
        for (const ShadingSample* sample : samples)
            series.points.push_back({sample->share_of_price,
                                     share_percent(sample->result.image.percent, std::min(ends.gouraud, ends.flat)),
                                     series.name + ": " + format_count(sample->result.gouraud) + " Gouraud and " +
                                         format_count(sample->result.flat) + " flat, error " +
                                         format_number(sample->result.image.percent) + " %"});
        if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    return plot;
}

Plot lights_plot(const AssetResult& asset) {
    Plot plot{asset.asset.name + ": error against frame time as the border moves from all Gouraud to all flat",
              {"frame, ms", AxisScale::logarithmic},
              {"error of the picture, %"},
              {},
              {}};
    std::vector<Series> series;
    std::vector<std::string> names;
    for (const ShadingSample* sample : samples_of(asset, "lights", "importance from anywhere")) {
        const std::string name = std::to_string(sample->lights) + (sample->lights == 1 ? " light, " : " lights, ") +
                                 display_text(sample->display);
        if (names.empty() || names.back() != name) {
            names.push_back(name);
            series.push_back({name, {}, true, true, false, series.size()});
        }
        series.back().points.push_back({sample->result.frame_ms, sample->result.image.percent,
                                        name + ", d = " + format_number(sample->distance) + ", " +
                                            format_duration(sample->result.frame_ms) + ", error " +
                                            format_number(sample->result.image.percent) + " %"});
    }
    plot.series = std::move(series);
    return plot;
}

Plot criteria_plot(const AssetResult& asset) {
    Plot plot{asset.asset.name + ": which triangles are flat",
              {"d: share of flat triangles"},
              {"error of the picture, %"},
              {},
              {}};
    for (const char* criterion : {"paper", "measured importance", "importance", "importance from anywhere"}) {
        Series series{criterion, {}, true, true, false, plot.series.size()};
        for (const ShadingSample* sample : samples_of(asset, "criteria", criterion))
            series.points.push_back({sample->distance, sample->result.image.percent,
                                     series.name + ", d = " + format_number(sample->distance) + ", error " +
                                         format_number(sample->result.image.percent) + " %"});
        if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    return plot;
}

Cell known(std::uint64_t count) {
    return count > 0 ? Cell(count) : Cell();
}

// What a reader wants of all the rows: one a model.
Table equal_cost_table(const std::vector<EqualCost>& rows) {
    return table_of<EqualCost>(
        rows, {{"asset", "model", [](const auto& r) { return r.asset->asset.name; }},
               {"operations", "price", [](const auto& r) { return r.operations; }},
               {"gouraud_percent", "all Gouraud %", [](const auto& r) { return r.gouraud; }},
               {"flat_percent", "all flat %", [](const auto& r) { return r.flat; }},
               {"hybrid_percent", "hybrid %", [](const auto& r) { return r.hybrid; }},
               {"hybrid_paper_percent", "the paper’s choice %", [](const auto& r) { return r.hybrid_paper; }},
               {"hybrid_wins", "hybrid best", [](const auto& r) { return r.hybrid_wins() ? "yes" : "no"; }},
               {"flat_sent_percent", "flat as sent %", [](const auto& r) { return r.flat_sent; }},
               {"gouraud_at_flats_bytes_percent", "Gouraud, same bytes %",
                [](const auto& r) { return r.gouraud_at_flats_bytes; }},
               {"criterion_operations", "criterion", [](const auto& r) { return r.asset->operations.criterion; }},
               {"flat_operations", "flat", [](const auto& r) { return r.asset->operations.all_flat; }},
               {"gouraud_operations", "Gouraud", [](const auto& r) { return r.asset->operations.all_gouraud; }},
               {"hybrid_operations", "hybrid", [](const auto& r) { return r.asset->operations.hybrid; }},
               {"hybrid_as_printed_operations", "as printed",
                [](const auto& r) { return known(r.asset->operations.hybrid_as_printed.value_or(0)); }}});
}

std::string equal_cost_sentence(const std::vector<EqualCost>& rows) {
    std::size_t wins = 0, better = 0, bytes = 0;
    for (const EqualCost& row : rows) {
        wins += row.hybrid_wins() ? 1 : 0;
        better += row.hybrid <= row.hybrid_paper ? 1 : 0;
        bytes += row.gouraud_at_flats_bytes < row.flat_sent ? 1 : 0;
    }
    if (rows.empty()) return "";
    const std::string of = " of " + std::to_string(rows.size());
    return "<p>For the same price in the paper’s operations (flat 1, Gouraud 4 a triangle) hybrid’s picture is nearer "
           "to the full model’s than all flat and all Gouraud, each with what it affords, on <strong>" +
           std::to_string(wins) + of +
           "</strong> models. Hybrid then spends on Gouraud shading what gains more there than three further flat "
           "triangles would, measured on the full model’s normals. Its choice (what blending brings a triangle’s "
           "normals "
           "nearer to the model’s, under any light, times the area seen) is at least as good as the paper’s (differing "
           "corners, then size) on " +
           std::to_string(better) + of +
           ". For the same bytes instead, all Gouraud with fewer triangles beats all flat on " + std::to_string(bytes) +
           of + ".</p>";
}

// Borders between the map's columns, in triangles a covered pixel.
constexpr double map_borders[] = {0.02, 0.1, 0.5};
constexpr std::size_t map_columns = std::size(map_borders) + 1;

std::string map_heading(std::size_t column) {
    if (column == 0) return "below " + format_number(map_borders[0]);
    const std::string from = format_number(map_borders[column - 1]);
    return column + 1 < map_columns ? from + " to " + format_number(map_borders[column]) : "from " + from;
}

// What flat takes of Gouraud's frame time, the geometric mean over models and displays; a row for each number of
// lights.
class TimeMap {
  public:
    explicit TimeMap(const ReportData& data) {
        for (const AssetResult& asset : data.assets)
            for (const char* series : {"lights", "fine level"}) {
                const ShadingSample* gouraud = nullptr;  // the last one: of a setting it comes first
                for (const ShadingSample* sample : samples_of(asset, series, "importance from anywhere")) {
                    if (sample->distance == 0.0) gouraud = sample;
                    if (sample->distance == 1.0 && gouraud) add(*gouraud, *sample);
                }
            }
    }

    bool empty() const { return rows_.empty(); }

    Table table() const {
        Table table;
        table.columns.push_back({"lights", "lights"});
        for (std::size_t column = 0; column < map_columns; ++column)
            table.columns.push_back({"column_" + std::to_string(column), map_heading(column)});
        for (const auto& [lights, row] : rows_) {
            std::vector<Cell> cells{std::uint64_t{lights}};
            for (const Mean& mean : row) cells.emplace_back(text(mean));
            table.rows.push_back(std::move(cells));
        }
        return table;
    }

  private:
    struct Mean {
        double logarithms = 0.0, count = 0.0;
        double ratio() const { return std::exp(logarithms / count); }
    };

    // By the rule that plans follow.
    static std::string text(const Mean& mean) {
        if (mean.count == 0.0) return "–";
        const bool pays = budget::least_flat_gain * mean.ratio() < 1.0;
        return format_number(100.0 * mean.ratio()) + " %: " + (pays ? "hybrid can pay" : "all Gouraud");
    }

    void add(const ShadingSample& gouraud, const ShadingSample& flat) {
        if (!(gouraud.result.frame_ms > 0.0) || !(flat.result.frame_ms > 0.0)) return;
        const auto column = std::upper_bound(std::begin(map_borders), std::end(map_borders), flat.triangles_per_pixel);
        Mean& mean = rows_[flat.lights][static_cast<std::size_t>(column - std::begin(map_borders))];
        mean.logarithms += std::log(flat.result.frame_ms / gouraud.result.frame_ms);
        ++mean.count;
    }

    std::map<std::uint32_t, std::array<Mean, map_columns>> rows_;
};

std::string time_map_html(const ReportData& data) {
    const TimeMap map(data);
    if (map.empty()) return "";
    return "<p>Where hybrid pays in measured time: the same triangles all flat against all Gouraud, by lights and by "
           "triangles a pixel of the object. Vertices are shared, so Gouraud lights about half as many points as there "
           "are faces, and flat one a face. Plans follow this map where a device tells both rates: within a tenth they "
           "send all Gouraud, which is nearer for the same time.</p>" +
           to_html(map.table(),
                   "Frame time of all flat in % of all Gouraud’s, and what pays. Columns: triangles a "
                   "pixel.<br>" +
                       source_line(data.provenance));
}

}  // namespace

Section shading_section(const ReportData& data) {
    const std::vector<EqualCost> costs = equal_costs(data);
    Section section{"shading", "Gouraud, flat, and both at once", {}, {}, {}, {}, {}};
    section.text_html =
        "<p><dfn>Gouraud</dfn> shading lights the corners of a triangle and blends between them; <dfn>flat</dfn> "
        "shading gives the triangle one colour and needs no normals. A <dfn>hybrid</dfn> level uses both: the "
        "farther the object, the larger the share d of flat triangles. The error of a picture is the root mean "
        "square difference of its pixels from the full model’s picture, all Gouraud, same view and same size, "
        "where either of the two shows the object. " +
        between_sentence(device_rows(data)) +
        "</p><p>Each point of the first plots is one device class. The plots over d hold the triangles and the "
        "drawn view fixed and change only the split; d = 0 is all Gouraud, d = 1 all flat.</p>" +
        equal_cost_sentence(costs) + time_map_html(data) +
        "<p>The table: the price and the errors that it buys; flat against Gouraud at the same bytes; and the paper’s "
        "Table 3 counted on the full model, where “as printed” is the row that adds up to 4,600 polygons.</p>";
    if (!costs.empty()) section.plots.push_back(price_plot(data));
    for (const AssetResult& asset : data.assets) {
        if (asset.shading.empty()) continue;
        section.plots.push_back(lights_plot(asset));
        section.plots.push_back(criteria_plot(asset));
    }
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
    if (!costs.empty()) section.shown = equal_cost_table(costs);
    section.rows = table_of<ShadingRow>(
        shading_rows(data),
        {{"asset", "model", [](const auto& r) { return r.asset->asset.name; }},
         {"device", "device", [](const auto& r) { return r.device; }},
         {"series", "series", [](const auto& r) { return r.sample.series; }},
         {"criterion", "criterion", [](const auto& r) { return r.sample.criterion; }},
         {"lights", "lights", [](const auto& r) { return std::uint64_t{r.sample.lights}; }},
         {"width", "width", [](const auto& r) { return known(r.sample.display.width); }},
         {"height", "height", [](const auto& r) { return known(r.sample.display.height); }},
         {"shading", "shading", [](const auto& r) { return proto::shading_mode_name(r.sample.result.mode); }},
         {"distance", "d", [](const auto& r) { return r.sample.distance; }},
         {"triangles", "triangles", [](const auto& r) { return r.sample.triangles; }},
         {"triangles_per_pixel", "triangles a pixel",
          [](const auto& r) {
              return r.sample.triangles_per_pixel > 0.0 ? Cell(r.sample.triangles_per_pixel) : Cell();
          }},
         {"gouraud", "Gouraud", [](const auto& r) { return r.sample.result.gouraud; }},
         {"flat", "flat", [](const auto& r) { return r.sample.result.flat; }},
         {"operations", "operations", [](const auto& r) { return r.sample.operations; }},
         {"bytes", "bytes", [](const auto& r) { return known(r.sample.result.bytes); }},
         {"gpu_bytes", "bytes on the GPU", [](const auto& r) { return known(r.sample.result.gpu_bytes); }},
         {"image_error_percent", "picture’s error %", [](const auto& r) { return r.sample.result.image.percent; }},
         {"silhouette_percent", "outline differs %",
          [](const auto& r) { return r.sample.result.image.silhouette_percent; }},
         {"frame_ms", "frame ms",
          [](const auto& r) { return r.sample.result.frame_ms > 0.0 ? Cell(r.sample.result.frame_ms) : Cell(); }}});
    return section;
}

}  // namespace lodestream::report
