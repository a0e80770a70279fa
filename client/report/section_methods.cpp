#include <algorithm>
#include <cmath>

#include "client/report/machine.h"
#include "client/report/section_rows.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

using proto::MethodLevel;
using Value = std::optional<double> MethodLevel::*;

std::vector<std::string> method_names(const std::vector<MethodLevel>& levels) {
    std::vector<std::string> names;
    for (const MethodLevel& level : levels)
        if (std::ranges::count(names, level.method) == 0) names.push_back(level.method);
    return names;
}

// Of the model's triangles, as asked for.
long percent_asked(const MethodLevel& level) {
    const double whole = static_cast<double>(std::max<std::uint64_t>(1, level.model_triangles));
    return std::lround(100.0 * static_cast<double>(level.asked) / whole);
}

std::vector<long> shares(const std::vector<MethodLevel>& levels) {
    std::vector<long> all;
    for (const MethodLevel& level : levels)
        if (std::ranges::count(all, percent_asked(level)) == 0) all.push_back(percent_asked(level));
    return all;
}

Plot error_over_time(const std::vector<MethodLevel>& levels, long percent, Value error, const std::string& what,
                     const std::string& unit) {
    Plot plot{what + " at " + std::to_string(percent) + " % of the triangles, against time",
              {"time, ms", AxisScale::logarithmic},
              {what + ", " + unit, AxisScale::logarithmic},
              {},
              {}};
    for (const std::string& method : method_names(levels)) {
        Series series{method, {}, false, true, false, std::nullopt};
        for (const MethodLevel& level : levels)
            if (level.method == method && percent_asked(level) == percent && level.*error)
                series.points.push_back({level.wall_ms, *(level.*error),
                                         method + ", " + level.model + ": " + format_number(*(level.*error)) + " in " +
                                             format_duration(level.wall_ms)});
        plot.series.push_back(std::move(series));
    }
    return plot;
}

Cell cell_of(const std::optional<double>& value) {
    return value ? Cell(*value) : Cell();
}

}  // namespace

Section methods_section(const proto::MethodRun& run) {
    Section section{"simplification_methods", "Simplification beside other libraries", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>The same models, simplified to the same counts by this project’s engine (<em>ours</em>) and by its peers, "
        "in "
        "turns in one process. A method is better the further down and to the left its marks lie; a mark is a model. "
        "<em>ours</em> records the whole history in that time, from which any other level is then cut; the others make "
        "the one level. The picture’s error is the root mean square over the covered pixels of eight views, in steps "
        "of 255. Measured apart from this report: " +
        source_line(provenance_of(run.origin)) + "</p>";
    for (const long percent : shares(run.levels)) {
        section.plots.push_back(error_over_time(run.levels, percent, &MethodLevel::rms_error_percent, "RMS error",
                                                "% of the model’s diagonal"));
        section.plots.push_back(
            error_over_time(run.levels, percent, &MethodLevel::image_rms, "Picture’s error", "steps of 255"));
    }
    section.rows = table_of<MethodLevel>(
        run.levels, {{"model", "model", [](const auto& r) { return r.model; }},
                     {"method", "method", [](const auto& r) { return r.method; }},
                     {"asked_percent", "asked %",
                      [](const auto& r) { return static_cast<std::uint64_t>(std::max(0l, percent_asked(r))); }},
                     {"triangles", "triangles", [](const auto& r) { return r.triangles; }},
                     {"wall_ms", "time ms", [](const auto& r) { return r.wall_ms; }},
                     {"cpu_ms", "CPU ms", [](const auto& r) { return r.cpu_ms; }},
                     {"rms_error_percent", "RMS error %", [](const auto& r) { return cell_of(r.rms_error_percent); }},
                     {"max_error_percent", "max error %", [](const auto& r) { return cell_of(r.max_error_percent); }},
                     {"image_rms", "picture /255", [](const auto& r) { return cell_of(r.image_rms); }}});
    return section;
}

}  // namespace lodestream::report
