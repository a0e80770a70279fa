#include <algorithm>

#include "client/report/machine.h"
#include "client/report/section_rows.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

using proto::PointsCrowd;
using proto::PointsScore;
using proto::PointsSetting;

constexpr const char* whole_crowd = "all";

std::string source_of(const proto::PointsRun& run) {
    return " Measured apart from this report: " + source_line(provenance_of(run.origin));
}

std::string label(const PointsScore& score) {
    return score.model + (score.is_scaled ? ", fewer points" : "");
}

double off(const proto::SilhouetteMatch& match) {
    return 1.0 - match.f_measure;
}

Plot off_by_level(const proto::PointsRun& run) {
    Plot plot{"What silhouettes are off, level by level",
              {"points of an instance", AxisScale::logarithmic},
              {"1 − F", AxisScale::logarithmic},
              {},
              {}};
    const std::vector<std::string> models = distinct(run.scores, &PointsScore::model);
    for (std::size_t i = 0; i < models.size(); ++i)
        for (const bool is_scaled : {false, true}) {
            Series series{models[i] + (is_scaled ? ", fewer points" : ""), {}, true, true, is_scaled, i};
            for (const PointsScore& score : run.scores)
                if (score.model == models[i] && score.is_scaled == is_scaled && score.level != whole_crowd)
                    series.points.push_back({static_cast<double>(score.points), off(score.match),
                                             label(score) + ", " + score.level + ": " + format_count(score.points) +
                                                 " points, F " + format_number(score.match.f_measure)});
            if (!series.points.empty()) plot.series.push_back(std::move(series));
        }
    return plot;
}

// The paper's Table 12 and ours.
Table crowd_table(const std::vector<PointsScore>& scores) {
    std::vector<PointsScore> crowds;
    std::ranges::copy_if(scores, std::back_inserter(crowds), [](const auto& s) { return s.level == whole_crowd; });
    return table_of<PointsScore>(
        crowds, {{"model", "model", [](const auto& s) { return label(s); }},
                 {"triangles", "triangles", [](const auto& s) { return s.triangles; }},
                 {"points", "points, finest", [](const auto& s) { return s.points; }},
                 {"instances", "instances", [](const auto& s) { return s.instances; }},
                 {"views", "views", [](const auto& s) { return s.views; }},
                 {"recall", "recall", [](const auto& s) { return s.match.recall; }},
                 {"precision", "precision", [](const auto& s) { return s.match.precision; }},
                 {"f_measure", "F", [](const auto& s) { return s.match.f_measure; }},
                 {"paper_f", "paper’s F", [](const auto& s) { return s.paper_f.value_or(not_known); }}});
}

std::string mean_words(const std::vector<PointsScore>& scores) {
    double sum = 0.0, paper_sum = 0.0;
    std::size_t count = 0;
    for (const PointsScore& score : scores)
        if (score.level == whole_crowd && !score.is_scaled && score.paper_f) {
            sum += score.match.f_measure;
            paper_sum += *score.paper_f;
            ++count;
        }
    if (count == 0) return "";
    const auto models = static_cast<double>(count);
    return " With the paper’s points, F is " + format_number(sum / models) + " on average; the paper has " +
           format_number(paper_sum / models) + ".";
}

std::string setting_title(const PointsSetting& s) {
    return s.model + ", filter " + s.filter + ", " + format_count(s.slices) + " slices, " + format_count(s.side) +
           " px, size " + format_number(s.point_size) + ": " + format_count(s.points) + " points, " +
           format_count(s.holes) + " holes in " + format_count(s.views) + " views, F " +
           format_number(s.match.f_measure);
}

// What is varied: its name in the rows, and what it is on an axis.
struct Varied {
    const char* name;
    const char* title;
    const char* axis;
    double (*value)(const PointsSetting&);
};
constexpr Varied varied[] = {
    {"side", "image size T3", "pixels of an image’s side, T3", [](const auto& s) { return double(s.side); }},
    {"slices", "slices T1", "slices, T1", [](const auto& s) { return double(s.slices); }},
    {"point size", "point size T2", "size of a point over the one that fits, T2",
     [](const auto& s) { return s.point_size; }}};

// A line a filter.
Plot setting_plot(const proto::PointsRun& run, const std::string& model, const Varied& by, const Axis& y,
                  double (*value)(const PointsSetting&)) {
    Plot plot{model + ": " + y.label + " over " + by.title, {by.axis}, y, {}, {}};
    for (const std::string& filter : distinct(run.settings, &PointsSetting::filter)) {
        Series series{filter, {}, true, true, false, std::nullopt};
        for (const PointsSetting& s : run.settings)
            if (s.model == model && s.varied == by.name && s.filter == filter)
                series.points.push_back({by.value(s), value(s), setting_title(s)});
        if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    return plot;
}

double holes_a_view(const PointsSetting& s) {
    return s.views > 0 ? static_cast<double>(s.holes) / static_cast<double>(s.views) : not_known;
}

Table filter_table(const std::vector<PointsSetting>& settings) {
    std::vector<PointsSetting> rows;
    std::ranges::copy_if(settings, std::back_inserter(rows), [](const auto& s) { return s.varied == "filter"; });
    return table_of<PointsSetting>(rows,
                                   {{"model", "model", [](const auto& s) { return s.model; }},
                                    {"filter", "filter", [](const auto& s) { return s.filter; }},
                                    {"points", "points", [](const auto& s) { return s.points; }},
                                    {"holes", "holes a view", [](const auto& s) { return holes_a_view(s); }},
                                    {"hole_px", "pixels of holes, all views", [](const auto& s) { return s.hole_px; }},
                                    {"recall", "recall", [](const auto& s) { return s.match.recall; }},
                                    {"precision", "precision", [](const auto& s) { return s.match.precision; }},
                                    {"f_measure", "F", [](const auto& s) { return s.match.f_measure; }}});
}

double gain_of(const PointsCrowd& crowd) {
    return crowd.points_ms > 0.0 ? crowd.full_ms / crowd.points_ms : not_known;
}

Series gain_series(const proto::PointsRun& run, const std::string& model, bool is_papers, std::size_t color) {
    Series series{model + (is_papers ? ", the paper’s" : ""), {}, true, true, is_papers, color};
    for (const PointsCrowd& crowd : run.crowds) {
        if (crowd.model != model) continue;
        const double gain = is_papers ? crowd.paper_gain.value_or(not_known) : gain_of(crowd);
        series.points.push_back({static_cast<double>(crowd.instances), gain,
                                 series.name + ", " + format_count(crowd.instances) +
                                     " instances: " + format_number(gain) + " times as many frames"});
    }
    return series;
}

Plot gain_over_instances(const proto::PointsRun& run) {
    Plot plot{"Gain of the frame rate, dashed the paper’s",
              {"instances", AxisScale::logarithmic},
              {"frame rate with levels / without", AxisScale::logarithmic},
              {},
              {}};
    const std::vector<std::string> models = distinct(run.crowds, &PointsCrowd::model);
    for (std::size_t i = 0; i < models.size(); ++i)
        for (const bool is_papers : {false, true}) plot.series.push_back(gain_series(run, models[i], is_papers, i));
    return plot;
}

std::vector<Strip> strips_of(const proto::PointsRun& run, bool of_crowds) {
    std::vector<Strip> strips;
    for (const proto::PointsPicture& picture : run.pictures)
        if (picture.title.starts_with("crowd") == of_crowds)
            strips.push_back({picture.model + ": " + picture.title, picture.png_base64, picture.panels});
    return strips;
}

}  // namespace

Section points_scores_section(const proto::PointsRun& run) {
    Section section{"points_scores", "Points by the paper’s test", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>A camera goes around many instances of a model on spheres of 30 to 360 radii; each instance is drawn as "
        "the points of one of five levels by its distance, and the silhouettes are compared with those of full "
        "models, pixel by pixel (the point-cloud paper’s Table 12). “Fewer points”: the paper’s levels times the "
        "vertices of the scan at hand over those of the paper’s, where the scan is smaller." +
        mean_words(run.scores) + source_of(run) + "</p>";
    section.plots.push_back(off_by_level(run));
    section.shown = crowd_table(run.scores);
    section.strips = strips_of(run, true);
    section.rows = table_of<PointsScore>(
        run.scores, {{"model", "", [](const auto& s) { return s.model; }},
                     {"level", "", [](const auto& s) { return s.level; }},
                     {"scale", "", [](const auto& s) { return std::string(s.is_scaled ? "scan" : "paper"); }},
                     {"triangles", "", [](const auto& s) { return s.triangles; }},
                     {"points", "", [](const auto& s) { return s.points; }},
                     {"instances", "", [](const auto& s) { return s.instances; }},
                     {"views", "", [](const auto& s) { return s.views; }},
                     {"recall", "", [](const auto& s) { return s.match.recall; }},
                     {"precision", "", [](const auto& s) { return s.match.precision; }},
                     {"f_measure", "", [](const auto& s) { return s.match.f_measure; }},
                     {"paper_f", "", [](const auto& s) { return s.paper_f.value_or(not_known); }}});
    return section;
}

Section points_settings_section(const proto::PointsRun& run) {
    Section section{"points_settings", "What makes holes in points", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>One model from close by, as points that were taken through images of T3 pixels in T1 slices and are "
        "drawn T2 times as large as fits, with each filter that closes holes (the paper’s figures 5 to 8). A hole is "
        "a part of what faces the eye in which no point is drawn and which does not reach the outline; where points "
        "are far too small, holes run together and count as few. F compares the silhouettes. The table has the filters "
        "where points are drawn at two thirds of their size." +
        source_of(run) + "</p>";
    const std::vector<std::string> models = distinct(run.settings, &PointsSetting::model);
    for (const std::string& model : models)
        for (const Varied& by : varied) {
            auto& plots = model == models.front() ? section.plots : section.folded_plots;
            plots.push_back(setting_plot(run, model, by, {"holes a view"}, holes_a_view));
            plots.push_back(setting_plot(run, model, by, {"1 − F", AxisScale::logarithmic},
                                         [](const auto& s) { return off(s.match); }));
        }
    section.shown = filter_table(run.settings);
    section.strips = strips_of(run, false);
    section.rows =
        table_of<PointsSetting>(run.settings, {{"model", "", [](const auto& s) { return s.model; }},
                                               {"varied", "", [](const auto& s) { return s.varied; }},
                                               {"filter", "", [](const auto& s) { return s.filter; }},
                                               {"slices", "", [](const auto& s) { return s.slices; }},
                                               {"side_px", "", [](const auto& s) { return s.side; }},
                                               {"point_size", "", [](const auto& s) { return s.point_size; }},
                                               {"points", "", [](const auto& s) { return s.points; }},
                                               {"views", "", [](const auto& s) { return s.views; }},
                                               {"holes", "", [](const auto& s) { return s.holes; }},
                                               {"hole_px", "", [](const auto& s) { return s.hole_px; }},
                                               {"recall", "", [](const auto& s) { return s.match.recall; }},
                                               {"precision", "", [](const auto& s) { return s.match.precision; }},
                                               {"f_measure", "", [](const auto& s) { return s.match.f_measure; }}});
    return section;
}

Section points_crowds_section(const proto::PointsRun& run) {
    Section section{"points_crowds", "Frame rates of crowds of points", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>A square of instances, drawn in turns as full models and each as the points that its distance asks for, in "
        "CPU time of the software renderer: the paper’s levels or, where the scan at hand is smaller than the paper’s, "
        "as much smaller ones. The paper’s gains are of a Nexus 7 up to 289 instances and of a GTX 750 beyond, whose "
        "frame rates it tells as whole numbers. Scaled: times the vertices of the scan at hand over those of the "
        "paper’s, where they are fewer, for so much less do the full models cost here." +
        source_of(run) + "</p>";
    section.plots = {gain_over_instances(run)};
    section.rows = table_of<PointsCrowd>(
        run.crowds,
        {{"model", "model", [](const auto& c) { return c.model; }},
         {"instances", "instances", [](const auto& c) { return c.instances; }},
         {"full_triangles", "triangles, full", [](const auto& c) { return c.full_triangles; }},
         {"points", "points", [](const auto& c) { return c.points; }},
         {"full_ms", "full, ms", [](const auto& c) { return c.full_ms; }},
         {"points_ms", "points, ms", [](const auto& c) { return c.points_ms; }},
         {"gain", "gain", [](const auto& c) { return gain_of(c); }},
         {"paper_gain", "paper’s gain", [](const auto& c) { return c.paper_gain.value_or(not_known); }},
         {"scaled_gain", "paper’s, scaled", [](const auto& c) { return c.scaled_gain.value_or(not_known); }}});
    return section;
}

}  // namespace lodestream::report
