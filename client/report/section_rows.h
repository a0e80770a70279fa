// What the sections share: their rows, and tables and plots made from rows.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "client/report/data.h"
#include "client/report/plot.h"
#include "client/report/sections.h"
#include "client/report/table.h"

namespace lodestream::report {

inline constexpr double not_known = std::numeric_limits<double>::quiet_NaN();  // "–" on the page, null in JSON

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

// The names that rows have, as they come.
template <class Row>
std::vector<std::string> distinct(const std::vector<Row>& rows, std::string Row::*name) {
    std::vector<std::string> names;
    for (const Row& row : rows)
        if (std::find(names.begin(), names.end(), row.*name) == names.end()) names.push_back(row.*name);
    return names;
}

// An asset on a device.
struct DeviceRow {
    const AssetResult* asset = nullptr;
    const DeviceResult* device = nullptr;
};
std::vector<DeviceRow> device_rows(const ReportData& data);

// One level on its way to one device over one link: everything between the click and the picture.
struct Journey {
    const AssetResult* asset = nullptr;
    const DeviceResult* device = nullptr;
    const LadderLevel* rung = nullptr;  // null: the level cut for the device
    Link link;
    std::optional<double> linked_ms;  // plan and fetch over the link; computed where it is not there
    double fetch_ms = 0.0, decode_ms = 0.0, frame_ms = 0.0;
    double rms_error_percent = 0.0, error_px = 0.0, image_error_percent = 0.0;
    std::uint64_t triangles = 0, bytes = 0;

    double time_ms() const;
};
// `link`: of `links`.
Journey cut_journey(const DeviceRow& row, std::size_t link);
std::vector<Journey> rung_journeys(const DeviceRow& row, std::size_t link);

inline const ModeResult& hybrid_of(const DeviceResult& device) {
    return device.modes[0];
}
inline const ModeResult& gouraud_of(const DeviceResult& device) {
    return device.modes[1];
}
inline const ModeResult& flat_of(const DeviceResult& device) {
    return device.modes[2];
}

double share_percent(double part, double whole);                          // not_known where there is no whole
double bytes_per_triangle(std::uint64_t bytes, std::uint64_t triangles);  // not_known without triangles
double saved_percent(const DeviceResult& device);                         // bytes of hybrid against all Gouraud
bool lies_between(const DeviceResult& device);  // hybrid's picture, between flat's and Gouraud's
budget::Display display_of(const DeviceResult& device);
std::string display_text(const budget::Display& display);  // "800×600"
std::string link_text(const Link& link);                   // "2 Mbit/s"
std::string device_title(const DeviceRow& row);            // for hovering
std::string between_sentence(const std::vector<DeviceRow>& rows);

// One line an asset over its ladder; an asset keeps its colour in all plots.
std::vector<Series> ladder_series(const ReportData& data, const std::function<double(const LadderLevel&)>& x,
                                  const std::function<double(const AssetResult&, const LadderLevel&)>& y);
double rms_percent(const AssetResult& asset, const LadderLevel& rung);

Section budget_section(const ReportData& data);
Section simplification_section(const ReportData& data);
Section methods_section(const proto::MethodRun& run);
Section codec_section(const ReportData& data);
Section codecs_section(const proto::CodecRun& run);
Section shading_section(const ReportData& data);
Section end_to_end_section(const ReportData& data);
Section hlod_section(const ReportData& data);
Section points_section(const ReportData& data);
Section points_scores_section(const proto::PointsRun& run);
Section points_settings_section(const proto::PointsRun& run);
Section points_crowds_section(const proto::PointsRun& run);
Section points_choices_section(const proto::PointsRun& run);
Section scenes_section(const proto::SceneRun& run);
Section frame_rate_section(const ReportData& data);

}  // namespace lodestream::report
