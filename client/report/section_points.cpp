#include "client/report/section_rows.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

// The point-cloud paper's Table 12.
constexpr double paper_mean_f = 0.947;

struct LevelRow {
    const AssetResult* asset = nullptr;
    const PointsLevel* level = nullptr;
};

struct ChoiceRow {
    const AssetResult* asset = nullptr;
    const PointsChoice* choice = nullptr;
};

template <class Row, class Item>
std::vector<Row> rows_of(const ReportData& data, std::vector<Item> AssetResult::*items) {
    std::vector<Row> rows;
    for (const AssetResult& asset : data.assets)
        for (const Item& item : asset.*items) rows.push_back({&asset, &item});
    return rows;
}

// Of pictures that differ: which of the two shows less of an error.
bool chose_better(const PointsChoice& choice) {
    const Shown& chosen = choice.chose_points ? choice.points : choice.triangles;
    const Shown& other = choice.chose_points ? choice.triangles : choice.points;
    return chosen.image.percent <= other.image.percent;
}

Plot error_over_distance(const ReportData& data) {
    Plot plot{"Error of the picture over distance",
              {"distance of the eye, radii of the model", AxisScale::logarithmic},
              {"error of the picture, %", AxisScale::logarithmic},
              {},
              {}};
    for (std::size_t i = 0; i < data.assets.size(); ++i)
        for (const bool as_points : {false, true}) {
            const AssetResult& asset = data.assets[i];
            Series series{asset.asset.name + (as_points ? ", points" : ", triangles"), {}, true, true, as_points, i};
            for (const PointsChoice& choice : asset.choices) {
                if (choice.device != asset.choices.front().device) continue;
                const Shown& shown = as_points ? choice.points : choice.triangles;
                series.points.push_back({choice.distance, shown.image.percent,
                                         series.name + ": " + format_count(shown.primitives) + ", " +
                                             format_bytes(static_cast<double>(shown.bytes)) + ", frame " +
                                             format_duration(shown.frame_ms) + ", error " +
                                             format_number(shown.image.percent) + " %"});
            }
            if (!series.points.empty()) plot.series.push_back(std::move(series));
        }
    return plot;
}

Table choice_table(const std::vector<ChoiceRow>& rows) {
    return table_of<ChoiceRow>(
        rows, {{"model", "model", [](const auto& r) { return r.asset->asset.name; }},
               {"device", "device", [](const auto& r) { return r.choice->device; }},
               {"distance", "distance, radii", [](const auto& r) { return r.choice->distance; }},
               {"triangles", "triangles", [](const auto& r) { return r.choice->triangles.primitives; }},
               {"triangles_error", "error, %", [](const auto& r) { return r.choice->triangles.image.percent; }},
               {"triangles_ms", "frame ms", [](const auto& r) { return r.choice->triangles.frame_ms; }},
               {"points", "points", [](const auto& r) { return r.choice->points.primitives; }},
               {"points_error", "error, %", [](const auto& r) { return r.choice->points.image.percent; }},
               {"points_ms", "frame ms", [](const auto& r) { return r.choice->points.frame_ms; }},
               {"chosen", "plan’s choice", [](const auto& r) {
                    return r.choice->chose_points ? std::string("points") : std::string("triangles");
                }}});
}

std::string words(const ReportData& data, const std::vector<ChoiceRow>& choices) {
    double sum = 0.0;
    std::size_t models = 0, better = 0;
    for (const AssetResult& asset : data.assets)
        for (const PointsLevel& level : asset.points)
            if (level.level == "all") {
                sum += level.f_measure;
                ++models;
            }
    for (const ChoiceRow& row : choices) better += chose_better(*row.choice);
    std::string text =
        "<p>For the weakest devices and for what is far away a model can be drawn as points: discs on its surface, "
        "in an order in which every beginning is a level. A crowd of instances is drawn as points, fewer the farther "
        "away, and as full models, from five distances; recall, precision and F compare the silhouettes pixel by "
        "pixel. ";
    if (models > 0)
        text += "F is " + format_number(sum / static_cast<double>(models)) + " on average; the paper’s levels have " +
                format_number(paper_mean_f) + " on its models. ";
    if (!choices.empty())
        text += "The table sets points beside triangles, each within the device’s budget, from near to far: on " +
                std::to_string(better) + " of " + std::to_string(choices.size()) +
                " rows the plan’s choice (“primitives”: “any”) shows no larger error than the other.";
    return text + "</p>";
}

}  // namespace

Section points_section(const ReportData& data) {
    Section section{"points", "Points for the weakest devices", {}, {}, {}, {}, {}};
    const auto levels = rows_of<LevelRow>(data, &AssetResult::points);
    const auto choices = rows_of<ChoiceRow>(data, &AssetResult::choices);
    section.text_html =
        levels.empty() && choices.empty() ? "<p>No model’s points were measured.</p>" : words(data, choices);
    if (!choices.empty()) {
        section.plots = {error_over_distance(data)};
        section.shown = choice_table(choices);
    }
    section.rows =
        table_of<LevelRow>(levels, {{"model", "model", [](const auto& r) { return r.asset->asset.name; }},
                                    {"level", "level", [](const auto& r) { return r.level->level; }},
                                    {"instances", "instances", [](const auto& r) { return r.asset->crowd_instances; }},
                                    {"points", "points", [](const auto& r) { return r.level->points; }},
                                    {"recall", "recall", [](const auto& r) { return r.level->recall; }},
                                    {"precision", "precision", [](const auto& r) { return r.level->precision; }},
                                    {"f_measure", "F", [](const auto& r) { return r.level->f_measure; }}});
    return section;
}

}  // namespace lodestream::report
