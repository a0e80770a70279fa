#include "client/report/document.h"

#include <charconv>
#include <cmath>

#include "client/report/machine.h"
#include "client/report/plot.h"
#include "client/report/sections.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

constexpr std::size_t rows_shown_unfolded = 16;

constexpr const char* page_css = R"css(
:root{color-scheme:light dark;--page:#fff;--ink:#1b1f24;--muted:#5b6570;--card:#f4f6f8;--edge:#d5dbe1;--accent:#0b62a8}
@media(prefers-color-scheme:dark){:root{--page:#14171b;--ink:#e6e9ed;--muted:#9aa5b1;--card:#1d2228;--edge:#353d46;--accent:#79b8f0}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);font:16px/1.55 system-ui,sans-serif}
main{max-width:1180px;margin:0 auto;padding:1.5rem 1rem 4rem}
h1{font-size:1.9rem;line-height:1.2;margin:.5rem 0}h2{font-size:1.4rem;margin:3rem 0 .5rem;padding-top:1rem;border-top:1px solid var(--edge)}
h3{font-size:1.1rem;margin:1.5rem 0 .5rem}
p,.text ul{max-width:48rem}dfn{font-style:italic}a{color:var(--accent)}
nav{display:flex;flex-wrap:wrap;gap:.25rem 1.25rem;margin:1rem 0}
.muted,.table figcaption,figcaption small{color:var(--muted)}
.summary{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,21rem),1fr));gap:.75rem;padding:0;list-style:none}
.summary li{background:var(--card);border:1px solid var(--edge);border-radius:.5rem;padding:.75rem 1rem}
.problems{background:var(--card);border-left:4px solid #d55e00;padding:.5rem 1rem;overflow-wrap:anywhere}
.plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,22rem),1fr));gap:1.25rem;margin:1rem 0}
figure{margin:0;min-width:0}figcaption{font-weight:600;font-size:.95rem;overflow-wrap:anywhere}figcaption small{font-weight:400}
figure>svg{width:100%;height:auto;display:block}
.legend{list-style:none;display:flex;flex-wrap:wrap;gap:.1rem 1rem;margin:.25rem 0 0;padding:0;font-size:.85rem}
.legend svg{vertical-align:middle}
.table{margin:1rem 0;border:1px solid var(--edge);border-radius:.5rem;overflow:hidden}.table>div{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.875rem;font-variant-numeric:tabular-nums}
.table figcaption{padding:.5rem .75rem;font-size:.75rem;font-weight:400;line-height:1.4}
th,td{padding:.35rem .6rem;text-align:left;white-space:nowrap;border-bottom:1px solid var(--edge)}
th{white-space:normal;vertical-align:bottom;background:var(--card)}th.n,td.n{text-align:right}
tbody tr:hover{background:var(--card)}
th:first-child,td:first-child{position:sticky;left:0;background:var(--page);max-width:9rem;overflow:hidden;text-overflow:ellipsis}
th:first-child{background:var(--card)}
#overview table{font-size:.72rem}#overview :is(th,td){padding:.3rem .28rem}
details{margin:1rem 0}details>summary{cursor:pointer;color:var(--accent)}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,30rem),1fr));gap:1.25rem}
.panels{display:grid;grid-template-columns:repeat(3,1fr);gap:4px;margin-top:.25rem}
.panels img{width:100%;height:auto;display:block;border:1px solid var(--edge);border-radius:3px;background:#fff}
.strip{margin:1rem 0;width:fit-content;max-width:100%}.strip img{max-width:100%;height:auto;display:block;background:#fff}
.labels{display:grid;grid-auto-flow:column;grid-auto-columns:minmax(0,1fr)}
:is(.panels,.labels) span{font-size:.75rem;color:var(--muted);text-align:center}
)css";

std::string folded(const std::string& title, const std::string& html) {
    return "<details><summary>" + title + "</summary>\n" + html + "</details>\n";
}

std::string table_html(const Table& table, const std::string& source) {
    const std::string html = to_html(table, source);
    return table.rows.size() <= rows_shown_unfolded ? html
                                                    : folded("All " + format_count(table.rows.size()) + " rows", html);
}

std::string plots_html(const std::vector<Plot>& plots) {
    std::string out = "<div class=\"plots\">\n";
    for (const Plot& plot : plots) out += to_figure(plot);
    return out + "</div>\n";
}

std::string strip_html(const Strip& strip) {
    std::string labels;
    for (const std::string& label : strip.labels) labels += "<span>" + escape_html(label) + "</span>";
    return "<figure class=\"strip\"><figcaption>" + escape_html(strip.title) + "</figcaption><img alt=\"" +
           escape_html(strip.title) + "\" src=\"data:image/png;base64," + escape_html(strip.png_base64) + "\">" +
           (labels.empty() ? "" : "<div class=\"labels\">" + labels + "</div>") + "</figure>\n";
}

std::string section_html(const Section& section, const std::string& source) {
    std::string out = "<section id=\"" + section.key + "\"><h2>" + section.title + "</h2>\n<div class=\"text\">" +
                      section.text_html + "</div>\n" + plots_html(section.plots);
    if (!section.folded_plots.empty()) out += folded("More of these plots", plots_html(section.folded_plots));
    for (const Strip& strip : section.strips) out += strip_html(strip);
    return out + table_html(section.shown.value_or(section.rows), source) + "</section>\n";
}

std::string panel_html(const std::string& png, const std::string& name) {
    return "<div><img alt=\"" + escape_html(name) + "\" src=\"data:image/png;base64," + base64(png) + "\"><span>" +
           escape_html(name) + "</span></div>";
}

std::string picture_html(const AssetResult& asset, const DeviceResult& device, const Picture& picture) {
    const auto& level = device.plan.level;
    return "<figure><figcaption>" + escape_html(picture.device) + " <small>" + std::to_string(picture.width) + "×" +
           std::to_string(picture.height) + ", " + format_count(level.triangles) + " of " +
           format_count(asset.full_triangles) + " triangles, " +
           format_bytes(static_cast<double>(device.plan.content.bytes)) + ", limited by " +
           escape_html(device.plan.budget.limited_by) + "</small></figcaption><div class=\"panels\">" +
           panel_html(picture.level_png, "what it gets") + panel_html(picture.full_png, "full model") +
           panel_html(picture.difference_png, "difference × 8") + "</div></figure>\n";
}

std::string pictures_html(const ReportData& data) {
    std::string out =
        "<section id=\"pictures\"><h2>What each device shows</h2>\n<p>Left: the level that the device was sent, "
        "drawn at its display’s size and cropped to the model. Middle: the full model, all Gouraud, same view. "
        "Right: where they differ, eight times amplified (white: not at all). The pictures in full size lie in "
        "<code>pictures/</code> beside this page.</p>\n";
    for (const AssetResult& asset : data.assets) {
        out += "<h3>" + escape_html(asset.asset.name) + "</h3>\n<div class=\"pictures\">\n";
        for (const Picture& picture : asset.pictures)
            for (const DeviceResult& device : asset.devices)
                if (device.device == picture.device) out += picture_html(asset, device, picture);
        out += "</div>\n";
    }
    return out + "</section>\n";
}

std::string problems_html(const ReportData& data) {
    if (data.problems.empty()) return "";
    std::string out = "<div class=\"problems\"><strong>Not in this report:</strong><ul>";
    for (const std::string& problem : data.problems) out += "<li>" + escape_html(problem) + "</li>";
    return out + "</ul></div>\n";
}

std::string summary_section_html(const ReportData& data) {
    std::string out = "<ul class=\"summary\">\n";
    for (const std::string& sentence : summary_html(data)) out += "<li>" + sentence + "</li>\n";
    return out + "</ul>\n";
}

std::string overview_html(const ReportData& data, const std::string& source) {
    return "<section id=\"overview\"><h2>Everything at a glance</h2>\n<p>One row a model and device. “RMS %” is the "
           "level’s geometric error in % of the model’s size, “max px” its largest error on this display; “vs G %” "
           "the bytes against the same level all Gouraud; “pic %”, “all G %” and “all F %” the error of the "
           "picture as sent, all Gouraud and all flat.</p>\n" +
           to_html(overview_table(data), source) + "</section>\n";
}

// ---- JSON

std::string json_string(std::string_view text) {
    std::string out = "\"";
    for (const char c : printable(text)) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + "\"";
}

template <class Number>
std::string shortest(Number value) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
    return {buffer, end};
}

std::string json_value(const Cell& cell) {
    if (const auto* text = std::get_if<std::string>(&cell)) return json_string(*text);
    if (const auto* count = std::get_if<std::uint64_t>(&cell)) return shortest(*count);
    const auto* number = std::get_if<double>(&cell);
    return number && std::isfinite(*number) ? shortest(*number) : "null";
}

std::string json_rows(const Table& table) {
    std::string out = "[";
    for (const auto& row : table.rows) {
        out += &row == &table.rows.front() ? "\n    {" : ",\n    {";
        for (std::size_t i = 0; i < row.size(); ++i)
            out += (i ? ", " : "") + json_string(table.columns[i].key) + ": " + json_value(row[i]);
        out += "}";
    }
    return out + (table.rows.empty() ? "]" : "\n  ]");
}

std::string json_run(const Provenance& from) {
    return "{\"command\": " + json_string(from.command) + ", \"commit\": " + json_string(from.commit) +
           ", \"date\": " + json_string(from.date) + ", \"cpu\": " + json_string(from.cpu) +
           ", \"cores\": " + shortest(from.cores) + ", \"renderer\": " + json_string(from.renderer) +
           ", \"quick\": " + (from.quick ? "true" : "false") + "}";
}

}  // namespace

std::string html_document(const ReportData& data) {
    const std::string source = source_line(data.provenance);
    const std::vector<Section> all = sections(data);
    std::string out =
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta name=\"viewport\" "
        "content=\"width=device-width,initial-scale=1\">\n<title>Lodestream report</title>\n<style>" +
        std::string(page_css) + plot_css() + "</style></head>\n<body><main>\n<h1>Lodestream report</h1>\n" +
        "<p>A server was asked by four classes of device for 3D models, and each got the level of detail that it "
        "can afford. This page shows what they got, how far it is from the full model, and what each step "
        "cost.</p>\n" +
        summary_section_html(data) + problems_html(data) +
        "<nav><a href=\"#pictures\">Pictures</a><a href=\"#overview\">At a glance</a>";
    for (const Section& section : all) out += "<a href=\"#" + section.key + "\">" + section.title + "</a>";
    out += "</nav>\n" + pictures_html(data) + overview_html(data, source);
    for (const Section& section : all) out += section_html(section, source);
    return out + "<p class=\"muted\">" + source +
           (data.provenance.quick ? " · quick run: fewer models, levels and frames" : "") +
           "</p>\n</main></body></html>\n";
}

std::string json_document(const ReportData& data) {
    std::string out = "{\n  \"run\": " + json_run(data.provenance) + ",\n  \"problems\": [";
    for (const std::string& problem : data.problems)
        out += (&problem == &data.problems.front() ? "" : ", ") + json_string(problem);
    out += "]";
    for (const Section& section : sections(data))
        out += ",\n  " + json_string(section.key) + ": " + json_rows(section.rows);
    return out + "\n}\n";
}

}  // namespace lodestream::report
