#include "client/report/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "client/report/text.h"

namespace lodestream::report {
namespace {

constexpr double width = 440, height = 310;
constexpr double left = 64, right = 14, top = 20, bottom = 48;
constexpr double plot_width = width - left - right, plot_height = height - top - bottom;
constexpr double largest_value = 1e100;  // sums and ratios of two such values stay finite
constexpr double smallest_value = 1e-100;

bool can_show(AxisScale kind, double value) {
    return std::isfinite(value) && (kind == AxisScale::linear || value > 0.0);
}

double clamped(AxisScale kind, double value) {
    return std::clamp(value, kind == AxisScale::linear ? -largest_value : smallest_value, largest_value);
}

double round_step(double span, double count) {
    const double raw = span / count;
    const double power = std::pow(10.0, std::floor(std::log10(raw)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= raw) return factor * power;
    return 10.0 * power;
}

std::string tick_label(double value) {
    char buffer[32];
    const double size = std::abs(value);
    const bool plain = size == 0.0 || (size >= 1e-4 && size < 1e4);
    if (size >= 1e4 && size < 1e6)
        std::snprintf(buffer, sizeof buffer, "%g k", value / 1e3);
    else if (size >= 1e6 && size < 1e9)
        std::snprintf(buffer, sizeof buffer, "%g M", value / 1e6);
    else
        std::snprintf(buffer, sizeof buffer, plain ? "%g" : "%.0e", value);
    return buffer;
}

std::vector<Tick> linear_ticks(const Scale& scale) {
    const double step = round_step(scale.high - scale.low, 6);
    std::vector<Tick> out;
    const double first = std::ceil(scale.low / step - 1e-9) + 0.0;  // not -0, which would print its sign
    for (double i = first; i * step <= scale.high + 1e-9 * step; ++i) out.push_back({i * step, tick_label(i * step)});
    return out;
}

std::vector<Tick> logarithmic_ticks(const Scale& scale) {
    const int first = static_cast<int>(std::floor(std::log10(scale.low)));
    const int last = static_cast<int>(std::ceil(std::log10(scale.high)));
    const int decades_a_label = std::max(1, (last - first + 5) / 6);
    const bool few = last - first <= 3;
    std::vector<Tick> out;
    for (int decade = first; decade <= last; ++decade)
        for (const int factor : {1, 2, 5}) {
            const double value = factor * std::pow(10.0, decade);
            if (value < scale.low || value > scale.high) continue;
            const bool labelled = factor == 1 ? (decade - first) % decades_a_label == 0 : few;
            if (factor == 1 || few) out.push_back({value, labelled ? tick_label(value) : ""});
        }
    return out;
}

std::string number(double value) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.1f", value);
    return buffer;
}

// A path command with its point: "M1.0,2.0".
std::string at(char command, double x, double y) {
    std::string out(1, command);
    return out.append(number(x)).append(",").append(number(y));
}

// Shapes of about equal weight around (x, y).
std::string marker(std::size_t style, double x, double y) {
    switch (style % plot_styles) {
        case 0:
            return at('M', x - 4, y) + "a4,4 0 1 0 8,0a4,4 0 1 0 -8,0z";
        case 1:
            return at('M', x - 3.6, y - 3.6) + "h7.2v7.2h-7.2z";
        case 2:
            return at('M', x, y - 5) + "l4.7,8.2h-9.4z";
        case 3:
            return at('M', x, y - 5) + "l5,5l-5,5l-5,-5z";
        case 4:
            return at('M', x, y + 5) + "l4.7,-8.2h-9.4z";
        case 5:
            return at('M', x - 5, y - 1.5) + "h3.5v-3.5h3v3.5h3.5v3h-3.5v3.5h-3v-3.5h-3.5z";
        default:
            return at('M', x - 5, y - 2.5) + "h10v5h-10z";
    }
}

std::string text(double x, double y, const std::string& anchor, const std::string& content,
                 const std::string& more = "") {
    return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
           escape_html(content) + "</text>";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& css) {
    return "<path class=\"" + css + "\" d=\"" + at('M', x1, y1) + at('L', x2, y2) + "\"/>";
}

struct Frame {
    Scale x, y;
};

Frame fit_frame(const Plot& plot) {
    std::vector<double> xs, ys;
    for (const Series& series : plot.series)
        for (const Point& point : series.points)
            if (can_show(plot.x.scale, point.x) && can_show(plot.y.scale, point.y)) {
                xs.push_back(point.x);
                ys.push_back(point.y);
            }
    for (const Guide& guide : plot.guides) xs.push_back(guide.x);
    return {fit_scale(plot.x.scale, xs), fit_scale(plot.y.scale, ys)};
}

double x_of(double share) {
    return left + share * plot_width;
}
double y_of(double share) {
    return top + (1.0 - share) * plot_height;
}

std::string draw_axes(const Plot& plot, const Frame& frame) {
    std::string out;
    for (const Tick& tick : ticks(frame.x)) {
        const double x = x_of(place(frame.x, tick.value).value_or(0.0));
        out += line(x, top, x, top + plot_height, "grid");
        if (!tick.label.empty()) out += text(x, top + plot_height + 17, "middle", tick.label);
    }
    for (const Tick& tick : ticks(frame.y)) {
        const double y = y_of(place(frame.y, tick.value).value_or(0.0));
        out += line(left, y, left + plot_width, y, "grid");
        if (!tick.label.empty()) out += text(left - 7, y + 4, "end", tick.label);
    }
    out += line(left, top, left, top + plot_height, "axis");
    out += line(left, top + plot_height, left + plot_width, top + plot_height, "axis");
    out += text(left + plot_width / 2, height - 8, "middle", plot.x.label);
    const double middle = top + plot_height / 2;
    return out + text(13, middle, "middle", plot.y.label, " transform=\"rotate(-90 13 " + number(middle) + ")\"");
}

std::string draw_guides(const Plot& plot, const Frame& frame) {
    std::string out;
    for (const Guide& guide : plot.guides)
        if (const auto share = place(frame.x, guide.x)) {
            out += line(x_of(*share), top, x_of(*share), top + plot_height, "guide");
            out += text(x_of(*share), top - 6, "middle", guide.label);
        }
    return out;
}

std::string draw_series(const Series& series, std::size_t style, const Frame& frame) {
    std::string path, marks;
    for (const Point& point : series.points) {
        const auto x = place(frame.x, point.x), y = place(frame.y, point.y);
        if (!x || !y) continue;
        path += at(path.empty() ? 'M' : 'L', x_of(*x), y_of(*y));
        if (series.markers)
            marks += "<path class=\"mark\" d=\"" + marker(style, x_of(*x), y_of(*y)) + "\"><title>" +
                     escape_html(point.title) + "</title></path>";
    }
    std::string out = "<g class=\"s" + std::to_string(style % plot_styles) + "\">";
    if (series.line && !path.empty())
        out += "<path class=\"line" + std::string(series.dashed ? " dashed" : "") + "\" d=\"" + path + "\"/>";
    return out + marks + "</g>\n";
}

std::string draw_legend_entry(const Series& series, std::size_t style) {
    std::string swatch =
        "<svg class=\"plot\" width=\"26\" height=\"14\" viewBox=\"0 0 26 14\" aria-hidden=\"true\"><g class=\"s" +
        std::to_string(style % plot_styles) + "\">";
    if (series.line) swatch += line(1, 7, 25, 7, series.dashed ? "line dashed" : "line");
    if (series.markers) swatch += "<path class=\"mark\" d=\"" + marker(style, 13, 7) + "\"/>";
    return "<li>" + swatch + "</g></svg> " + escape_html(series.name) + "</li>";
}

}  // namespace

Scale fit_scale(AxisScale kind, const std::vector<double>& values) {
    std::vector<double> shown;
    for (const double value : values)
        if (can_show(kind, value)) shown.push_back(clamped(kind, value));
    if (shown.empty()) return {kind, kind == AxisScale::linear ? 0.0 : 1.0, kind == AxisScale::linear ? 1.0 : 10.0};

    const auto [low, high] = std::minmax_element(shown.begin(), shown.end());
    if (kind == AxisScale::logarithmic) {
        const double margin = std::max(std::pow(*high / *low, 0.06), 1.3);
        return {kind, *low / margin, *high * margin};
    }
    const double start = std::min(*low, 0.0), end = std::max(*high, 0.0);
    const double span = std::max(end - start, smallest_value);
    return {kind, start < 0.0 ? start - 0.06 * span : 0.0, end > 0.0 || start == 0.0 ? end + 0.06 * span : 0.0};
}

std::optional<double> place(const Scale& scale, double value) {
    if (!can_show(scale.kind, value)) return std::nullopt;
    const double v = clamped(scale.kind, value);
    if (scale.kind == AxisScale::linear) return (v - scale.low) / (scale.high - scale.low);
    return std::log(v / scale.low) / std::log(scale.high / scale.low);
}

std::vector<Tick> ticks(const Scale& scale) {
    std::vector<Tick> out = scale.kind == AxisScale::linear ? linear_ticks(scale) : logarithmic_ticks(scale);
    if (std::none_of(out.begin(), out.end(), [](const Tick& tick) { return !tick.label.empty(); })) {
        const double middle = scale.kind == AxisScale::linear ? (scale.low + scale.high) / 2
                                                              : std::sqrt(scale.low) * std::sqrt(scale.high);
        out = {{middle, tick_label(middle)}};
    }
    return out;
}

std::string plot_css() {
    constexpr const char* light[plot_styles] = {"#0072b2", "#d55e00", "#007a5a", "#b0568a",
                                                "#a87500", "#2b8fc4", "#555555"};
    constexpr const char* dark[plot_styles] = {"#4aa8e0", "#f08040", "#2ec49a", "#e094c0",
                                               "#f0b840", "#8fd0f5", "#bbbbbb"};
    std::string out;
    const auto colours = [&](const auto& palette) {
        for (std::size_t i = 0; i < plot_styles; ++i) out += ".s" + std::to_string(i) + "{--c:" + palette[i] + "}";
    };
    colours(light);
    out += "@media(prefers-color-scheme:dark){";
    colours(dark);
    return out +
           "}\n.plot text{fill:currentColor;font-size:12px}.plot .grid{stroke:currentColor;opacity:.12}.plot "
           ".axis{stroke:currentColor;opacity:.6}.plot .guide{stroke:currentColor;opacity:.5;stroke-dasharray:2 "
           "3}.plot .line{fill:none;stroke:var(--c);stroke-width:2}.plot .dashed{stroke-dasharray:6 4}.plot "
           ".mark{fill:var(--c);stroke:var(--page);stroke-width:.8}\n";
}

std::string to_figure(const Plot& plot) {
    const Frame frame = fit_frame(plot);
    std::string out = "<figure><figcaption>" + escape_html(plot.title) +
                      "</figcaption>\n<svg class=\"plot\" viewBox=\"0 0 " + number(width) + " " + number(height) +
                      "\" role=\"img\" aria-label=\"" + escape_html(plot.title) + "\">" + draw_axes(plot, frame) +
                      draw_guides(plot, frame) + "\n";
    std::string legend;
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
        const std::size_t style = plot.series[i].style.value_or(i);
        out += draw_series(plot.series[i], style, frame);
        legend += draw_legend_entry(plot.series[i], style);
    }
    return out + "</svg>\n<ul class=\"legend\">" + legend + "</ul></figure>\n";
}

}  // namespace lodestream::report
