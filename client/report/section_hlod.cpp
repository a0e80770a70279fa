#include "client/report/section_rows.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

// One picture of a scene: of its tiles, or of a level of the whole scene.
struct SceneRow {
    const AssetResult* asset = nullptr;
    std::string method;
    Cell budget, tiles;
    std::uint64_t triangles = 0, bytes = 0;
    double error_px = 0.0, frame_ms = 0.0;
    ImageError image;
};

SceneRow sample_row(const AssetResult& asset, const HlodSample& sample) {
    const bool is_plan = sample.tiles == 0;
    return {&asset,           is_plan ? "plan" : "hierarchy",
            sample.budget,    is_plan ? Cell{} : Cell{sample.tiles},
            sample.triangles, sample.bytes,
            sample.error_px,  sample.frame_ms,
            sample.image};
}

SceneRow rung_row(const AssetResult& asset, const LadderLevel& rung) {
    const DrawnLevel& drawn = rung.drawn.front();
    return {&asset,         "ladder",       {},         {}, rung.level.triangles, rung.level.bytes,
            drawn.error_px, drawn.frame_ms, drawn.image};
}

std::vector<SceneRow> scene_rows(const AssetResult& asset) {
    std::vector<SceneRow> rows;
    for (const auto* samples : {&asset.hlod, &asset.plans})
        for (const HlodSample& sample : *samples) rows.push_back(sample_row(asset, sample));
    if (rows.empty()) return rows;
    for (const LadderLevel& rung : asset.ladder)
        if (!rung.drawn.empty()) rows.push_back(rung_row(asset, rung));
    return rows;
}

using Value = double (*)(const SceneRow&);

double triangles_of(const SceneRow& row) {
    return static_cast<double>(row.triangles);
}
double frame_ms_of(const SceneRow& row) {
    return row.frame_ms;
}

// Three lines a scene: what its tiles show, what a plan's level shows, and what a level of the whole of it shows.
Plot scene_plot(const ReportData& data, const std::string& title, const Axis& x, Value value) {
    Plot plot{title, x, {"error of the picture, %", AxisScale::logarithmic}, {}, {}};
    for (std::size_t i = 0; i < data.assets.size(); ++i) {
        const AssetResult& asset = data.assets[i];
        for (const std::string method : {"hierarchy", "plan", "ladder"}) {
            const std::size_t style = method == "plan" ? data.assets.size() + i : i;
            Series series{asset.asset.name + ", " + method, {}, true, true, method == "ladder", style};
            for (const SceneRow& row : scene_rows(asset))
                if (row.method == method)
                    series.points.push_back({value(row), row.image.percent,
                                             series.name + ": " + format_count(row.triangles) + " triangles, " +
                                                 format_bytes(static_cast<double>(row.bytes)) + ", frame " +
                                                 format_duration(row.frame_ms) + ", error " +
                                                 format_number(row.image.percent) + " %"});
            if (!series.points.empty()) plot.series.push_back(std::move(series));
        }
    }
    return plot;
}

Table baked_table(const ReportData& data) {
    std::vector<const AssetResult*> scenes;
    for (const AssetResult& asset : data.assets)
        if (asset.asset.hierarchy) scenes.push_back(&asset);
    return table_of<const AssetResult*>(
        scenes, {{"asset", "scene", [](const auto& a) { return a->asset.name; }},
                 {"triangles", "triangles", [](const auto& a) { return a->asset.triangles; }},
                 {"tiles", "tiles", [](const auto& a) { return a->asset.hierarchy->tiles; }},
                 {"depth", "depth", [](const auto& a) { return a->asset.hierarchy->depth; }},
                 {"all", "triangles of all tiles", [](const auto& a) { return a->asset.hierarchy->triangles; }},
                 {"bytes", "bytes of all tiles", [](const auto& a) { return a->asset.hierarchy->bytes; }},
                 {"max_error", "root’s error at most", [](const auto& a) { return a->asset.hierarchy->max_error; }},
                 {"bake_ms", "bake ms", [](const auto& a) { return a->asset.hierarchy->bake_ms; }}});
}

}  // namespace

Section hlod_section(const ReportData& data) {
    Section section{"hlod", "Scenes as trees of tiles", {}, {}, {}, {}, {}};
    std::vector<SceneRow> rows;
    for (const AssetResult& asset : data.assets) {
        const std::vector<SceneRow> more = scene_rows(asset);
        rows.insert(rows.end(), more.begin(), more.end());
    }
    if (rows.empty()) {
        section.text_html = "<p>No scene of several objects was measured.</p>";
    } else {
        section.text_html =
            "<p>A scene of several objects is baked as a tree of tiles: its objects in the leaves, above them tiles "
            "that simplify what the tiles below show together. Within a budget of triangles the tile with the largest "
            "error on the screen is refined first (“hierarchy”). Beside it the one level that a plan gives for that "
            "budget, which spends nothing on what is hidden (“plan”), and the levels of the whole scene as one "
            "mesh (“ladder”): the same detail everywhere, seen or not. One view of the whole scene on the first "
            "device’s display; the closer the eye, the more a tree saves. The table tells what the bakes "
            "took.</p>";
        section.plots = {scene_plot(data, "Error of the picture against triangles",
                                    {"triangles", AxisScale::logarithmic}, triangles_of),
                         scene_plot(data, "Error of the picture against frame time",
                                    {"frame time, ms", AxisScale::logarithmic}, frame_ms_of)};
        section.shown = baked_table(data);
    }
    section.rows = table_of<SceneRow>(
        rows, {{"asset", "", [](const auto& r) { return r.asset->asset.name; }},
               {"method", "", [](const auto& r) { return r.method; }},
               {"budget_triangles", "", [](const auto& r) { return r.budget; }},
               {"triangles", "", [](const auto& r) { return r.triangles; }},
               {"tiles", "", [](const auto& r) { return r.tiles; }},
               {"bytes", "", [](const auto& r) { return r.bytes; }},
               {"error_px", "", [](const auto& r) { return r.error_px; }},
               {"frame_ms", "", [](const auto& r) { return r.frame_ms; }},
               {"image_error_percent", "", [](const auto& r) { return r.image.percent; }},
               {"silhouette_percent", "", [](const auto& r) { return r.image.silhouette_percent; }}});
    return section;
}

}  // namespace lodestream::report
