#include <algorithm>

#include "client/report/machine.h"
#include "client/report/section_rows.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

using proto::SceneBake;

double microseconds_per_triangle(const SceneBake& bake) {
    return bake.triangles > 0 ? 1e3 * bake.cpu_ms / static_cast<double>(bake.triangles) : not_known;
}

std::string title_of(const SceneBake& bake) {
    return bake.scene + ": " + format_count(bake.objects) + " objects, " + format_count(bake.triangles) +
           " triangles, " + format_duration(bake.wall_ms) + ", " +
           format_bytes(static_cast<double>(bake.peak_memory_bytes)) + " of memory";
}

// Measured times, and what they would be if each object took as long as one of the fewest.
Plot growth_plot(const proto::SceneRun& run) {
    Plot plot{"Bake time against objects",
              {"objects", AxisScale::logarithmic},
              {"CPU time, s", AxisScale::logarithmic},
              {},
              {}};
    const std::vector<std::string> scenes = distinct(run.bakes, &SceneBake::scene);
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        Series measured{scenes[i], {}, true, true, false, i}, linear{scenes[i] + ", linear", {}, true, false, true, i};
        const SceneBake* fewest = nullptr;
        for (const SceneBake& bake : run.bakes) {
            if (bake.scene != scenes[i] || bake.objects == 0) continue;
            const auto objects = static_cast<double>(bake.objects);
            if (!fewest || bake.objects < fewest->objects) fewest = &bake;
            measured.points.push_back({objects, 1e-3 * bake.cpu_ms, title_of(bake)});
        }
        for (const Point& point : measured.points)
            linear.points.push_back({point.x, 1e-3 * fewest->cpu_ms * point.x / static_cast<double>(fewest->objects),
                                     "as long an object as of the fewest"});
        plot.series.push_back(std::move(measured));
        plot.series.push_back(std::move(linear));
    }
    return plot;
}

}  // namespace

Section scenes_section(const proto::SceneRun& run) {
    Section section{"hlod_growth", "Bakes of growing scenes", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>A scene of more and more objects, most of them instances of few shapes: each shape is simplified, encoded "
        "and stored once, and tiles above instances are made of its coarse levels. Everything of the bake counts: the "
        "tiles, the levels and the points of the whole scene, which are made of a bounded number of its triangles. "
        "Dashed: as if every object took as long as one of the fewest. Measured apart from this report: " +
        source_line(provenance_of(run.origin)) + "</p>";
    section.plots = {growth_plot(run)};
    section.rows = table_of<SceneBake>(
        run.bakes, {{"scene", "scene", [](const auto& b) { return b.scene; }},
                    {"objects", "objects", [](const auto& b) { return b.objects; }},
                    {"triangles", "triangles", [](const auto& b) { return b.triangles; }},
                    {"tiles", "tiles", [](const auto& b) { return b.tiles; }},
                    {"bytes", "bytes of all tiles", [](const auto& b) { return b.bytes; }},
                    {"wall_ms", "wall ms", [](const auto& b) { return b.wall_ms; }},
                    {"cpu_ms", "CPU ms", [](const auto& b) { return b.cpu_ms; }},
                    {"tiles_ms", "tiles, wall ms", [](const auto& b) { return b.tiles_ms; }},
                    {"cpu_us_per_triangle", "CPU µs a triangle", microseconds_per_triangle},
                    {"peak_memory_bytes", "peak memory, bytes", [](const auto& b) { return b.peak_memory_bytes; }}});
    return section;
}

}  // namespace lodestream::report
