// Line and scatter plots as inline SVG. Text and axes use currentColor and series use CSS classes, so one plot serves
// light and dark pages; every marker carries its numbers as a hover title.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace lodestream::report {

enum class AxisScale { linear, logarithmic };

struct Axis {
    std::string label;  // with its unit
    AxisScale scale = AxisScale::linear;
};

struct Point {
    double x = 0.0;
    double y = 0.0;
    std::string title;  // shown on hover
};

// Series take colours and marker shapes by their index, or `style` where several plots must agree.
struct Series {
    std::string name;
    std::vector<Point> points;  // those that an axis cannot show (not finite; <= 0 on a logarithmic one) are left out
    bool line = true;
    bool markers = true;
    bool dashed = false;
    std::optional<std::size_t> style;
};

// A labelled vertical line.
struct Guide {
    double x = 0.0;
    std::string label;
};

struct Plot {
    std::string title;
    Axis x;
    Axis y;
    std::vector<Series> series;
    std::vector<Guide> guides;
};

// The stretch of an axis that is shown. Always low < high, finite, and > 0 where logarithmic.
struct Scale {
    AxisScale kind = AxisScale::linear;
    double low = 0.0;
    double high = 1.0;
};

// Around the values that the axis can show, with a margin; a linear scale holds 0.
Scale fit_scale(AxisScale kind, const std::vector<double>& values);

// Share of the axis in [0, 1] for values in the scale; absent where the axis cannot show the value.
std::optional<double> place(const Scale& scale, double value);

struct Tick {
    double value = 0.0;
    std::string label;  // empty: a mark without text
};

// Round values in the scale, rising: multiples of 1, 2 or 5 times a power of ten; powers of ten where logarithmic (with
// 2 and 5 between where there are few). At least one carries a label.
std::vector<Tick> ticks(const Scale& scale);

inline constexpr std::size_t plot_styles = 7;  // colours and marker shapes before they repeat

// Colours of the series classes s0 … s6 for light and dark pages (Okabe and Ito's palette for colour-blind readers).
std::string plot_css();

// <figure> with title, SVG and legend.
std::string to_figure(const Plot& plot);

}  // namespace lodestream::report
