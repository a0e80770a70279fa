#include <algorithm>
#include <cmath>

#include "client/report/section_rows.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

// How far a model's frame times are off what the probe's figures say, all its levels, shadings and screens.
struct PredictedFrames {
    std::string model;
    std::vector<double> off;  // shares of the measured time, rising; not empty
    double median() const { return off[off.size() / 2]; }
};

// One row of report.json's section: a flight, a number of exposures, a controller over the simulated devices, or a
// model.
struct FrameRateRow {
    std::string series;  // "scenario", "blur", "simulated" or "predicted"
    std::string motion;
    std::string controller;
    const FlightResult* flight = nullptr;
    const BlurResult* blur = nullptr;
    const SweepRow* sweep = nullptr;
    const PredictedFrames* predicted = nullptr;
};

double paced_fps(const control::FlownFrame& frame, double target_fps) {
    return 1000.0 / std::max(frame.frame_ms, 1000.0 / target_fps);
}

const FlightResult* flight_of(const FrameRateResult& result, const std::string& controller) {
    const auto found = std::find_if(result.flights.begin(), result.flights.end(),
                                    [&](const FlightResult& flight) { return flight.controller == controller; });
    return found == result.flights.end() ? nullptr : &*found;
}

void add_off(std::vector<double>& off, double predicted_ms, double measured_ms) {
    if (predicted_ms > 0.0 && measured_ms > 0.0) off.push_back(std::abs(predicted_ms / measured_ms - 1.0));
}

std::vector<PredictedFrames> predicted_frames(const ReportData& data) {
    std::vector<PredictedFrames> models;
    for (const AssetResult& asset : data.assets) {
        PredictedFrames model{asset.asset.name, {}};
        for (const LadderLevel& level : asset.ladder)
            for (const DrawnLevel& drawn : level.drawn) add_off(model.off, drawn.predicted_ms, drawn.frame_ms);
        for (const DeviceResult& device : asset.devices)
            for (const ModeResult& mode : device.modes) add_off(model.off, mode.predicted_ms, mode.frame_ms);
        std::sort(model.off.begin(), model.off.end());
        if (!model.off.empty()) models.push_back(std::move(model));
    }
    return models;
}

std::vector<FrameRateRow> rows_of(const FrameRateResult& result, const std::vector<PredictedFrames>& models) {
    std::vector<FrameRateRow> rows;
    for (const FlightResult& flight : result.flights)
        rows.push_back({"scenario", result.motion, flight.controller, &flight, nullptr, nullptr, nullptr});
    for (const BlurResult& blur : result.blur)
        rows.push_back({"blur", "fast turn", "", nullptr, &blur, nullptr, nullptr});
    for (const SweepRow& sweep : result.sweep)
        rows.push_back({"simulated", sweep.motion, sweep.controller, nullptr, nullptr, &sweep, nullptr});
    for (const PredictedFrames& model : models)
        rows.push_back({"predicted", "", "", nullptr, nullptr, nullptr, &model});
    return rows;
}

// A row has cells for what it is about; the rest says nothing.
template <class Value>
std::function<Cell(const FrameRateRow&)> of_flight(Value value) {
    return [value](const FrameRateRow& row) { return row.flight ? Cell{value(*row.flight)} : Cell{}; };
}
template <class Flown, class Swept>
std::function<Cell(const FrameRateRow&)> of_either(Flown flown, Swept swept) {
    return [flown, swept](const FrameRateRow& row) {
        if (row.flight) return Cell{flown(*row.flight)};
        return row.sweep ? Cell{swept(*row.sweep)} : Cell{};
    };
}
template <class Value>
std::function<Cell(const FrameRateRow&)> of_blur(Value value) {
    return [value](const FrameRateRow& row) { return row.blur ? Cell{value(*row.blur)} : Cell{}; };
}

double percent(const std::optional<double>& share) {
    return share ? 100.0 * *share : not_known;
}

std::vector<Field<FrameRateRow>> fields() {
    using Flight = FlightResult;
    return {{"series", "", [](const auto& r) { return r.series; }},
            {"motion", "", [](const auto& r) { return r.motion; }},
            {"controller", "controller", [](const auto& r) { return r.controller; }},
            {"model", "", [](const auto& r) { return r.predicted ? Cell{r.predicted->model} : Cell{}; }},
            {"frames", "frames",
             [](const auto& r) {
                 if (r.predicted) return Cell{std::uint64_t{r.predicted->off.size()}};
                 return r.flight ? Cell{std::uint64_t{r.flight->summary.frames}} : Cell{};
             }},
            {"average_fps", "average fps", of_flight([](const Flight& f) { return f.summary.average_fps; })},
            {"worst_fps", "worst fps", of_flight([](const Flight& f) { return f.summary.worst_fps; })},
            {"deviation_fps", "σ fps",
             of_either([](const Flight& f) { return f.summary.deviation_fps; },
                       [](const SweepRow& s) { return s.deviation_fps; })},
            {"deviation_ms", "σ of frames, ms", of_flight([](const Flight& f) { return f.summary.deviation_ms; })},
            {"within_deadline_percent", "in time %",
             of_either([](const Flight& f) { return 100.0 * f.summary.within_deadline; },
                       [](const SweepRow& s) { return 100.0 * s.within_deadline; })},
            {"worst_device_within_percent", "",
             [](const auto& r) { return r.sweep ? Cell{100.0 * r.sweep->worst_device} : Cell{}; }},
            {"switches", "switches",
             of_either([](const Flight& f) { return double(f.summary.switches); },
                       [](const SweepRow& s) { return s.switches; })},
            {"error_px", "error px",
             of_either([](const Flight& f) { return f.summary.mean_error_px; },
                       [](const SweepRow& s) { return s.error_px; })},
            {"image_error_percent", "picture’s error %",
             [](const auto& r) {
                 if (r.flight) return Cell{r.flight->image_error_percent};
                 return r.blur ? Cell{r.blur->coarse_error_percent} : Cell{};
             }},
            {"prediction_error_percent", "prediction off by %",
             [](const auto& r) {
                 if (r.predicted) return Cell{100.0 * r.predicted->median()};
                 return r.flight ? Cell{percent(r.flight->summary.prediction_error)} : Cell{};
             }},
            {"worst_prediction_error_percent", "",
             [](const auto& r) { return r.predicted ? Cell{100.0 * r.predicted->off.back()} : Cell{}; }},
            {"other_cores", "other load, cores",
             of_flight([](const Flight& f) { return f.other_cores.value_or(not_known); })},
            {"exposures", "", of_blur([](const BlurResult& b) { return std::uint64_t{b.exposures}; })},
            {"frame_ms", "", of_blur([](const BlurResult& b) { return b.frame_ms; })}};
}

Plot over_time(const FrameRateResult& result, std::string title, std::string label,
               const std::function<double(const control::FlownFrame&)>& value) {
    Plot plot{std::move(title), {"time, s"}, {std::move(label)}, {}, {}};
    for (const FlightResult& flight : result.flights) {
        Series series{flight.controller, {}, true, false, false, {}};
        for (const control::FlownFrame& frame : flight.frames) series.points.push_back({frame.t_s, value(frame), ""});
        plot.series.push_back(std::move(series));
    }
    return plot;
}

Plot distribution_plot(const FrameRateResult& result) {
    Plot plot{"Frames in time on " + format_count(result.devices) + " simulated devices, 20 motions each",
              {"flights, % of all, the worst first"},
              {"frames in time, %"},
              {},
              {}};
    for (const SweepDistribution& distribution : result.distributions) {
        Series series{distribution.controller, {}, true, false, false, {}};
        const double last = static_cast<double>(distribution.within_deadline.size()) - 1.0;
        for (std::size_t i = 0; i < distribution.within_deadline.size(); ++i)
            series.points.push_back(
                {100.0 * static_cast<double>(i) / std::max(last, 1.0), 100.0 * distribution.within_deadline[i], ""});
        plot.series.push_back(std::move(series));
    }
    return plot;
}

Plot error_plot(const FrameRateResult& result) {
    Plot plot{
        "Error of the picture against frames that came late", {"frames late, %"}, {"error of the picture, %"}, {}, {}};
    for (const FlightResult& flight : result.flights) {
        const double late = 100.0 * (1.0 - flight.summary.within_deadline);
        plot.series.push_back({flight.controller,
                               {{late, flight.image_error_percent,
                                 flight.controller + ": " + format_number(late) + " % late, picture off by " +
                                     format_number(flight.image_error_percent) + " %"}},
                               false,
                               true,
                               false,
                               {}});
    }
    return plot;
}

std::string ratios_sentence(const FrameRateResult& result) {
    const FlightResult *none = flight_of(result, "none"), *sblc = flight_of(result, "sblc"),
                       *isblc = flight_of(result, "isblc"), *predictive = flight_of(result, "predictive");
    if (!none || !sblc || !isblc || !predictive) return "";
    const auto ratio = [](const FlightResult& flight, double value) {
        return format_number(value / std::max(flight.summary.average_fps, 1e-9));
    };
    return "Here: no control falls to " + format_number(none->summary.worst_fps) + " fps; ISBLC’s worst is " +
           ratio(*isblc, isblc->summary.worst_fps) + " of its average and its σ " +
           ratio(*isblc, isblc->summary.deviation_fps) + " (the paper: 0.66 and 0.10), with " +
           std::to_string(isblc->summary.switches) + " level changes where SBLC makes " +
           std::to_string(sblc->summary.switches) + "; predictive has <strong>" +
           format_number(100.0 * predictive->summary.within_deadline) + " %</strong> of its frames in time, σ " +
           format_number(predictive->summary.deviation_fps) + " against ISBLC’s " +
           format_number(isblc->summary.deviation_fps) + " (of what frames take, without the wait for the next, " +
           format_number(predictive->summary.deviation_ms) + " against " + format_number(isblc->summary.deviation_ms) +
           " ms), and its pictures are off by " + format_number(predictive->image_error_percent) + " % against " +
           format_number(isblc->image_error_percent) + " %.";
}

// Simulated motions on which another controller had more frames in time than the predictive one.
std::size_t motions_lost(const FrameRateResult& result) {
    std::size_t lost = 0;
    for (const SweepRow& mine : result.sweep) {
        if (mine.controller != "predictive") continue;
        lost += std::any_of(result.sweep.begin(), result.sweep.end(), [&](const SweepRow& other) {
            return other.motion == mine.motion && other.within_deadline > mine.within_deadline;
        });
    }
    return lost;
}

std::string sweep_sentence(const FrameRateResult& result) {
    if (result.sweep.empty()) return "";
    const std::size_t lost = motions_lost(result);
    return "On " + format_count(result.devices) +
           " simulated devices (seeded noise, spikes, throttling, decoding beside the frames; their probe off by 15 %) "
           "the predictive controller keeps the deadline " +
           (lost == 0 ? "at least as often as every other on <strong>every one</strong> of the 20 motions."
                      : "less often than another on " + std::to_string(lost) + " of the 20 motions.");
}

std::string blur_sentence(const FrameRateResult& result) {
    std::string out;
    for (const BlurResult& blur : result.blur)
        out += (out.empty() ? "" : ", ") + std::to_string(blur.exposures) +
               (blur.exposures == 1 ? " exposure " : " exposures ") + format_duration(blur.frame_ms) +
               " and the coarsest level off by " + format_number(blur.coarse_error_percent) + " %";
    return out.empty() ? "" : "Motion blur in a fast turn, the finest level: " + out + ".";
}

std::string predicted_sentence(const std::vector<PredictedFrames>& models) {
    std::vector<double> all;
    for (const PredictedFrames& model : models) all.insert(all.end(), model.off.begin(), model.off.end());
    if (all.empty()) return "";
    std::sort(all.begin(), all.end());
    return " From the probe’s figures alone, the time of a frame is predicted with an error of " +
           format_number(100.0 * all[all.size() / 2]) + " % in the median, below " +
           format_number(100.0 * all[all.size() * 9 / 10]) + " % nine times of ten and " +
           format_number(100.0 * all.back()) + " % at the worst, over " + format_count(all.size()) +
           " levels, shadings and screens of " + format_count(models.size()) +
           " models. Both are the fast tenth of as many frames as fit into a fraction of a second.";
}

std::string disturbed_sentence(const FrameRateResult& result) {
    double most = 0.0;
    for (const FlightResult& flight : result.flights) most = std::max(most, flight.other_cores.value_or(0.0));
    if (most <= 0.15) return "";
    return " <strong>Disturbed:</strong> other processes kept up to " + format_number(most) +
           " cores busy during these flights; late frames may be theirs.";
}

std::string ladder_text(const FrameRateResult& result) {
    std::string out;
    for (const control::Level& level : result.ladder) out += (out.empty() ? "" : ", ") + format_count(level.triangles);
    return out;
}

std::string text_of(const FrameRateResult& result, const std::vector<PredictedFrames>& models) {
    return "<p>The ISBLC paper’s motion (" + escape_html(result.motion) + ") over " + escape_html(result.asset) +
           ", flown by every controller with the real renderer at " + format_number(result.target_fps) +
           " frames/s, 120° of view, " + display_text(result.screen) + ", levels of " + ladder_text(result) +
           " triangles. A view that turns is drawn with 2 or 4 exposures (motion blur), which is what makes speed "
           "cost; levels and screen were chosen so that the finest level just fits when still, whatever the heading. "
           "One level is on the GPU, and changing it takes its time within the frame; frames begin a deadline apart at "
           "the soonest. Frame rates are 1/max(frame time, deadline). The picture’s error is against the finest of "
           "these levels at the same moments. The paper reports no control "
           "22 fps at worst, SBLC 30, ISBLC 60 on average, 40 at worst, σ 6.1.</p><p>" +
           ratios_sentence(result) + disturbed_sentence(result) + "</p><p>" + sweep_sentence(result) + " " +
           blur_sentence(result) + predicted_sentence(models) + "</p>";
}

Table scenario_table(const FrameRateResult& result) {
    std::vector<FrameRateRow> rows = rows_of(result, {});
    std::erase_if(rows, [](const FrameRateRow& row) { return row.flight == nullptr; });
    return table_of(rows, fields());
}

}  // namespace

Section frame_rate_section(const ReportData& data) {
    Section section{"frame_rate", "Holding the frame rate while the view turns", {}, {}, {}, {}, {}};
    if (!data.frame_rate) {
        section.text_html = "<p>Not measured.</p>";
        section.rows = table_of<FrameRateRow>({}, fields());
        return section;
    }
    const FrameRateResult& result = *data.frame_rate;
    const std::vector<PredictedFrames> models = predicted_frames(data);
    section.text_html = text_of(result, models);
    section.plots.push_back(over_time(result, "Frame rate over the motion", "frames/s",
                                      [&](const auto& frame) { return paced_fps(frame, result.target_fps); }));
    section.plots.push_back(over_time(result, "Level over the motion, 0 the finest", "level",
                                      [](const auto& frame) { return double(frame.level); }));
    section.plots.push_back(error_plot(result));
    section.plots.push_back(distribution_plot(result));
    section.shown = scenario_table(result);
    section.rows = table_of(rows_of(result, models), fields());
    return section;
}

}  // namespace lodestream::report
