#include <algorithm>
#include <cmath>

#include "client/report/section_rows.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

// One row of report.json's section: a flight, a number of exposures, or a controller over the simulated devices.
struct FrameRateRow {
    std::string series;  // "scenario", "blur" or "simulated"
    std::string motion;
    std::string controller;
    const FlightResult* flight = nullptr;
    const BlurResult* blur = nullptr;
    const SweepRow* sweep = nullptr;
};

double paced_fps(const control::FlownFrame& frame, double target_fps) {
    return 1000.0 / std::max(frame.frame_ms, 1000.0 / target_fps);
}

const FlightResult* flight_of(const FrameRateResult& result, const std::string& controller) {
    const auto found = std::find_if(result.flights.begin(), result.flights.end(),
                                    [&](const FlightResult& flight) { return flight.controller == controller; });
    return found == result.flights.end() ? nullptr : &*found;
}

std::vector<FrameRateRow> rows_of(const FrameRateResult& result) {
    std::vector<FrameRateRow> rows;
    for (const FlightResult& flight : result.flights)
        rows.push_back({"scenario", result.motion, flight.controller, &flight, nullptr, nullptr});
    for (const BlurResult& blur : result.blur) rows.push_back({"blur", "fast turn", "", nullptr, &blur, nullptr});
    for (const SweepRow& sweep : result.sweep)
        rows.push_back({"simulated", sweep.motion, sweep.controller, nullptr, nullptr, &sweep});
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
            {"frames", "frames", of_flight([](const Flight& f) { return std::uint64_t{f.summary.frames}; })},
            {"average_fps", "average fps", of_flight([](const Flight& f) { return f.summary.average_fps; })},
            {"worst_fps", "worst fps", of_flight([](const Flight& f) { return f.summary.worst_fps; })},
            {"deviation_fps", "σ fps",
             of_either([](const Flight& f) { return f.summary.deviation_fps; },
                       [](const SweepRow& s) { return s.deviation_fps; })},
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
             of_flight([](const Flight& f) { return percent(f.summary.prediction_error); })},
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
           format_number(isblc->summary.deviation_fps) + ", and its pictures are off by " +
           format_number(predictive->image_error_percent) + " % against " + format_number(isblc->image_error_percent) +
           " %.";
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

// How far frame times lie from the line through those of an asset's finest and coarsest level, for every level between
// them and every device's screen, as shares.
std::vector<double> off_the_line(const ReportData& data) {
    std::vector<double> off;
    for (const AssetResult& asset : data.assets) {
        if (asset.ladder.size() < 3) continue;
        const LadderLevel &fine = asset.ladder.front(), &coarse = asset.ladder.back();
        const auto triangles = [](const LadderLevel& level) { return static_cast<double>(level.level.triangles); };
        for (std::size_t i = 1; i + 1 < asset.ladder.size(); ++i)
            for (std::size_t d = 0; d < asset.ladder[i].drawn.size(); ++d) {
                const double share =
                    (triangles(asset.ladder[i]) - triangles(coarse)) / (triangles(fine) - triangles(coarse));
                const double low = coarse.drawn[d].frame_ms, high = fine.drawn[d].frame_ms;
                const double measured = asset.ladder[i].drawn[d].frame_ms;
                if (measured > 0.0) off.push_back(std::abs((low + share * (high - low)) / measured - 1.0));
            }
    }
    return off;
}

std::string line_sentence(const ReportData& data) {
    std::vector<double> off = off_the_line(data);
    if (off.empty()) return "";
    std::sort(off.begin(), off.end());
    return " Predicted from a model’s finest and coarsest level alone, the frame time of a level between them is off "
           "by " +
           format_number(100.0 * off[off.size() / 2]) + " % in the median over " + format_count(off.size()) +
           " levels and screens of all models.";
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

std::string text_of(const ReportData& data, const FrameRateResult& result) {
    return "<p>The ISBLC paper’s motion (" + escape_html(result.motion) + ") over " + escape_html(result.asset) +
           ", flown by every controller with the real renderer at " + format_number(result.target_fps) +
           " frames/s, 120° of view, " + display_text(result.screen) + ", levels of " + ladder_text(result) +
           " triangles. A view that turns is drawn with 2 or 4 exposures (motion blur), which is what makes speed "
           "cost; levels and screen were chosen so that the finest level just fits when still. One level is on the "
           "GPU, and changing it takes its time within the frame. Frame rates are 1/max(frame time, deadline). The "
           "picture’s error is against the finest of these levels at the same moments. The paper reports no control "
           "22 fps at worst, SBLC 30, ISBLC 60 on average, 40 at worst, σ 6.1.</p><p>" +
           ratios_sentence(result) + disturbed_sentence(result) + "</p><p>" + sweep_sentence(result) + " " +
           blur_sentence(result) + line_sentence(data) + "</p>";
}

Table scenario_table(const FrameRateResult& result) {
    std::vector<FrameRateRow> rows = rows_of(result);
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
    section.text_html = text_of(data, result);
    section.plots.push_back(over_time(result, "Frame rate over the motion", "frames/s",
                                      [&](const auto& frame) { return paced_fps(frame, result.target_fps); }));
    section.plots.push_back(over_time(result, "Level over the motion, 0 the finest", "level",
                                      [](const auto& frame) { return double(frame.level); }));
    section.plots.push_back(error_plot(result));
    section.plots.push_back(distribution_plot(result));
    section.shown = scenario_table(result);
    section.rows = table_of(rows_of(result), fields());
    return section;
}

}  // namespace lodestream::report
