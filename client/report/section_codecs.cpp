#include <algorithm>
#include <cmath>

#include "client/report/machine.h"
#include "client/report/section_rows.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

using proto::CodecTrial;

// The codec that the others are compared with.
constexpr const char* reference_codec = "draco";
constexpr std::size_t max_codec_plots = 4;  // shown at once; the others are folded

// One codec on one model, by rising bytes: settings that no smaller one comes nearer than.
std::vector<CodecTrial> curve_of(const std::vector<CodecTrial>& trials, const std::string& model,
                                 const std::string& codec) {
    std::vector<CodecTrial> all;
    for (const CodecTrial& trial : trials)
        if (trial.model == model && trial.codec == codec) all.push_back(trial);
    std::ranges::sort(all, [](const CodecTrial& a, const CodecTrial& b) {
        return a.bytes != b.bytes ? a.bytes < b.bytes : a.image_rms < b.image_rms;
    });
    std::vector<CodecTrial> curve;
    for (const CodecTrial& trial : all)
        if (curve.empty() || trial.image_rms < curve.back().image_rms) curve.push_back(trial);
    return curve;
}

// Between the settings around it, on logarithmic scales; not_known beyond them.
double bytes_at(const std::vector<CodecTrial>& curve, double image_rms) {
    for (std::size_t i = 0; i < curve.size(); ++i) {
        const auto bytes = static_cast<double>(curve[i].bytes);
        if (curve[i].image_rms == image_rms) return bytes;
        if (i == 0 || !(curve[i - 1].image_rms > image_rms && curve[i].image_rms < image_rms)) continue;
        if (!(curve[i].image_rms > 0.0)) return not_known;
        const double share =
            std::log(curve[i - 1].image_rms / image_rms) / std::log(curve[i - 1].image_rms / curve[i].image_rms);
        return std::exp(std::lerp(std::log(static_cast<double>(curve[i - 1].bytes)), std::log(bytes), share));
    }
    return not_known;
}

const CodecTrial* usual(const std::vector<CodecTrial>& trials, const std::string& model, const std::string& codec) {
    const auto found = std::ranges::find_if(trials, [&](const CodecTrial& trial) {
        return trial.model == model && trial.codec == codec && trial.is_default;
    });
    return found == trials.end() ? nullptr : &*found;
}

Plot error_over_bytes(const std::vector<CodecTrial>& trials, const std::string& model) {
    Plot plot{"Picture’s error against bytes: " + model,
              {"bytes a triangle", AxisScale::logarithmic},
              {"picture’s error, steps of 255", AxisScale::logarithmic},
              {},
              {}};
    for (const std::string& codec : distinct(trials, &CodecTrial::codec)) {
        Series series{codec, {}, true, true, false, std::nullopt};
        for (const CodecTrial& trial : curve_of(trials, model, codec))
            series.points.push_back({bytes_per_triangle(trial.bytes, trial.triangles), trial.image_rms,
                                     codec + ", " + trial.setting + ": " + format_number(trial.image_rms) + " in " +
                                         format_count(trial.bytes) + " bytes"});
        plot.series.push_back(std::move(series));
    }
    return plot;
}

Plot decoding_over_bytes(const std::vector<CodecTrial>& trials) {
    Plot plot{"Decoding against bytes, each codec as it is used",
              {"bytes a triangle", AxisScale::logarithmic},
              {"decoding, ns a triangle", AxisScale::logarithmic},
              {},
              {}};
    for (const std::string& codec : distinct(trials, &CodecTrial::codec)) {
        Series series{codec, {}, false, true, false, std::nullopt};
        for (const CodecTrial& trial : trials) {
            if (trial.codec != codec || !trial.is_default || trial.triangles == 0) continue;
            series.points.push_back({bytes_per_triangle(trial.bytes, trial.triangles),
                                     1e6 * trial.decode_ms / static_cast<double>(trial.triangles),
                                     codec + ", " + trial.model + ": " + format_duration(trial.decode_ms)});
        }
        plot.series.push_back(std::move(series));
    }
    return plot;
}

// What each codec takes where it is as near the level as the reference's usual setting.
Table equal_error_table(const std::vector<CodecTrial>& trials) {
    const std::vector<std::string> codecs = distinct(trials, &CodecTrial::codec);
    Table table{{{"model", "model"},
                 {"triangles", "triangles"},
                 {"image_rms", "picture’s error /255"},
                 {"bytes", "Draco, bytes"}},
                {}};
    for (const std::string& codec : codecs)
        if (codec != reference_codec) table.columns.push_back({codec, codec + " / Draco"});
    for (const std::string& codec : codecs) table.columns.push_back({codec + "_decode_ms", codec + " decodes in ms"});
    for (const std::string& model : distinct(trials, &CodecTrial::model)) {
        const CodecTrial* reference = usual(trials, model, reference_codec);
        if (!reference) continue;
        std::vector<Cell> row{model, reference->triangles, reference->image_rms, reference->bytes};
        const auto reference_bytes = static_cast<double>(reference->bytes);
        for (const std::string& codec : codecs)
            if (codec != reference_codec)
                row.emplace_back(bytes_at(curve_of(trials, model, codec), reference->image_rms) / reference_bytes);
        for (const std::string& codec : codecs) {
            const CodecTrial* trial = usual(trials, model, codec);
            row.emplace_back(trial ? trial->decode_ms : not_known);
        }
        table.rows.push_back(std::move(row));
    }
    return table;
}

}  // namespace

Section codecs_section(const proto::CodecRun& run) {
    Section section{"codecs", "The same level by other codecs", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>One level of each model as <em>plain</em> and <em>lean</em> encode it, from closer than is served to four "
        "times the level’s own error, as Draco’s encoder does over bits and speeds, and as meshoptimizer’s codec does "
        "over bits; no container, no images. The picture’s error is what the codec alone adds: the root mean square "
        "over the covered pixels of eight views against the level before encoding, in steps of 255. A codec is better "
        "the further down and to the left its line lies, which joins the settings that no smaller one comes nearer "
        "than. "
        "The table compares bytes where the pictures are as near as Draco’s by its usual 14 bits at speed 5 (“–”: none "
        "of the settings is), and decoding, CPU time, of what each is used with. meshoptimizer’s bytes are usually "
        "compressed once more in transport. Measured apart from this report: " +
        source_line(provenance_of(run.origin)) + "</p>";
    section.plots.push_back(decoding_over_bytes(run.trials));
    for (const std::string& model : distinct(run.trials, &CodecTrial::model))
        (section.plots.size() <= max_codec_plots ? section.plots : section.folded_plots)
            .push_back(error_over_bytes(run.trials, model));
    section.shown = equal_error_table(run.trials);
    section.rows = table_of<CodecTrial>(run.trials, {{"model", "", [](const auto& r) { return r.model; }},
                                                     {"codec", "", [](const auto& r) { return r.codec; }},
                                                     {"setting", "", [](const auto& r) { return r.setting; }},
                                                     {"triangles", "", [](const auto& r) { return r.triangles; }},
                                                     {"bytes", "", [](const auto& r) { return r.bytes; }},
                                                     {"encode_ms", "", [](const auto& r) { return r.encode_ms; }},
                                                     {"decode_ms", "", [](const auto& r) { return r.decode_ms; }},
                                                     {"image_rms", "", [](const auto& r) { return r.image_rms; }}});
    return section;
}

}  // namespace lodestream::report
