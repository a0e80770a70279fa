#include <algorithm>
#include <map>

#include "client/report/choice_groups.h"
#include "client/report/machine.h"
#include "client/report/section_rows.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

double middle_of(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
}

std::string share_words(double frame_share) {
    return frame_share == 1.0 ? "a whole frame" : "1/" + format_number(1.0 / frame_share) + " of a frame";
}

bool is_of(const proto::PointsChoice& choice, const ChoiceGroup& group) {
    return choice.device == group.device && choice.points_per_triangle == group.points_per_triangle &&
           choice.frame_share == group.frame_share;
}

// Over all models: the middle one of the errors of points over those of triangles.
Series ratio_series(const std::vector<proto::PointsChoice>& choices, const ChoiceGroup& group) {
    std::map<double, std::vector<double>> ratios;
    for (const proto::PointsChoice& choice : choices)
        if (is_of(choice, group) && choice.triangles_percent > 0.0 && choice.points_percent > 0.0)
            ratios[choice.distance].push_back(choice.points_percent / choice.triangles_percent);
    Series series{format_number(group.points_per_triangle) + " points a triangle", {}, true, true, false, std::nullopt};
    for (auto& [distance, values] : ratios) {
        const double ratio = middle_of(std::move(values));
        series.points.push_back({distance, ratio,
                                 series.name + ", " + format_number(distance) + " radii: points err " +
                                     format_number(ratio) + " times as much"});
    }
    return series;
}

// One of each device and share of its frame.
std::vector<Plot> ratio_plots(const std::vector<proto::PointsChoice>& choices, const std::vector<ChoiceGroup>& groups) {
    std::vector<Plot> plots;
    for (const ChoiceGroup& group : groups) {
        const std::string title = group.device + ", " + share_words(group.frame_share);
        auto plot = std::ranges::find(plots, title, &Plot::title);
        if (plot == plots.end()) {
            plots.push_back({title,
                             {"distance of the eye, radii of the model", AxisScale::logarithmic},
                             {"error of points / of triangles", AxisScale::logarithmic},
                             {},
                             {}});
            plot = plots.end() - 1;
        }
        Series series = ratio_series(choices, group);
        if (!series.points.empty()) plot->series.push_back(std::move(series));
    }
    return plots;
}

double percent_of(std::uint64_t part, std::uint64_t all) {
    return all > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(all) : not_known;
}

Table group_table(const std::vector<ChoiceGroup>& groups) {
    return table_of<ChoiceGroup>(
        groups, {{"device", "device", [](const auto& g) { return g.device; }},
                 {"points_per_triangle", "points a triangle", [](const auto& g) { return g.points_per_triangle; }},
                 {"frame_percent", "of a frame, %", [](const auto& g) { return 100.0 * g.frame_share; }},
                 {"cases", "cases", [](const auto& g) { return g.cases; }},
                 {"points_nearer", "points are nearer", [](const auto& g) { return g.points_nearer; }},
                 {"points_taken", "plan takes points", [](const auto& g) { return g.points_taken; }},
                 {"points_found", "both", [](const auto& g) { return g.points_found; }},
                 {"right_percent", "plan is right, %", [](const auto& g) { return percent_of(g.right, g.cases); }}});
}

std::string words(const proto::PointsRun& run, const ChoiceGroup& all) {
    return "<p>What a weak device draws in the same time, points or triangles, beside the full model: each model from "
           "near to far, alone in the frame or one of many, on devices that draw half a point in the time of a "
           "triangle (what is taken where nothing was measured) or more. A triangle is shaded smoothly over its area "
           "and a disc is not, so points are nearer only where a device draws many in that time, or a model is too "
           "rough for the few triangles there are: above 1 in the plots, which show the median of the models, "
           "triangles "
           "are nearer. The plan is right where what it takes errs no more than the other: "
           "on " +
           format_number(percent_of(all.right, all.cases)) + " % of " + format_count(all.cases) +
           " cases. Points are nearer on " + format_count(all.points_nearer) + ", and on " +
           format_count(all.points_found) + " of these the plan takes them." +
           " Measured apart from this report: " + source_line(provenance_of(run.origin)) + "</p>";
}

}  // namespace

Section points_choices_section(const proto::PointsRun& run) {
    const std::vector<ChoiceGroup> groups = choice_groups(run.choices);
    Section section{"points_choices", "Points or triangles in the same time", {}, {}, {}, {}, {}};
    section.text_html = words(run, sum_of(groups));
    section.plots = ratio_plots(run.choices, groups);
    section.shown = group_table(groups);
    section.rows = table_of<proto::PointsChoice>(
        run.choices,
        {{"model", "", [](const auto& c) { return c.model; }},
         {"device", "", [](const auto& c) { return c.device; }},
         {"points_per_triangle", "", [](const auto& c) { return c.points_per_triangle; }},
         {"frame_share", "", [](const auto& c) { return c.frame_share; }},
         {"distance", "", [](const auto& c) { return c.distance; }},
         {"triangles", "", [](const auto& c) { return c.triangles; }},
         {"points", "", [](const auto& c) { return c.points; }},
         {"triangles_error", "", [](const auto& c) { return c.triangles_percent; }},
         {"points_error", "", [](const auto& c) { return c.points_percent; }},
         {"chosen", "", [](const auto& c) { return std::string(c.chose_points ? "points" : "triangles"); }},
         {"crossing", "", [](const auto& c) { return c.crossing.value_or(not_known); }}});
    return section;
}

}  // namespace lodestream::report
