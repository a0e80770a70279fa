#include "client/report/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>

namespace lodestream::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::vector<std::vector<double>> awkward_values() {
    return {{},
            {0.0},
            {-5.0},
            {5.0, 5.0},
            {-3.0, 4.0},
            {std::nan(""), infinity, -infinity},
            {1e-300, 1e300},
            {std::numeric_limits<double>::max(), std::numeric_limits<double>::denorm_min()},
            {-std::numeric_limits<double>::max(), std::numeric_limits<double>::max()},
            {1e15, 1e15 + 1.0},
            {-1e15, -1e15 - 1.0},
            {0.301, 0.302}};
}

TEST(Plot, EveryScaleIsFiniteRisingAndHasFewTicksInsideOneOfThemLabelled) {
    for (const AxisScale kind : {AxisScale::linear, AxisScale::logarithmic})
        for (const auto& values : awkward_values()) {
            const Scale scale = fit_scale(kind, values);
            ASSERT_TRUE(std::isfinite(scale.low) && std::isfinite(scale.high));
            ASSERT_LT(scale.low, scale.high);
            if (kind == AxisScale::logarithmic) {
                ASSERT_GT(scale.low, 0.0);
            }
            const std::vector<Tick> marks = ticks(scale);
            ASSERT_FALSE(marks.empty());
            EXPECT_LE(marks.size(), 320u);
            EXPECT_LE(std::count_if(marks.begin(), marks.end(), [](const Tick& t) { return !t.label.empty(); }), 12);
            EXPECT_TRUE(std::any_of(marks.begin(), marks.end(), [](const Tick& t) { return !t.label.empty(); }));
            EXPECT_TRUE(std::is_sorted(marks.begin(), marks.end(),
                                       [](const Tick& a, const Tick& b) { return a.value < b.value; }));
            for (const Tick& tick : marks) {
                const auto share = place(scale, tick.value);
                ASSERT_TRUE(share.has_value());
                EXPECT_GE(*share, -1e-9);
                EXPECT_LE(*share, 1.0 + 1e-9);
            }
        }
}

TEST(Plot, AScaleHoldsTheValuesItWasFittedTo) {
    for (const AxisScale kind : {AxisScale::linear, AxisScale::logarithmic}) {
        const Scale scale = fit_scale(kind, {3.0, 700.0, 20.0});
        for (const double value : {3.0, 700.0, 20.0}) {
            EXPECT_GE(*place(scale, value), 0.0);
            EXPECT_LE(*place(scale, value), 1.0);
        }
    }
}

TEST(Plot, LinearScalesHoldZero) {
    EXPECT_EQ(fit_scale(AxisScale::linear, {90.0, 100.0}).low, 0.0);
    EXPECT_LT(fit_scale(AxisScale::linear, {-1.0, 100.0}).low, -1.0);
    EXPECT_EQ(fit_scale(AxisScale::linear, {-90.0, -100.0}).high, 0.0);
}

TEST(Plot, LogarithmicAxesShowNoZeroNoNegativeAndNoNan) {
    const Scale scale = fit_scale(AxisScale::logarithmic, {1.0, 100.0});
    for (const double value : {0.0, -1.0, std::nan(""), infinity}) EXPECT_FALSE(place(scale, value).has_value());
    EXPECT_NEAR(*place(scale, 10.0), 0.5, 1e-12);
}

TEST(Plot, LinearTicksAreRoundNumbers) {
    std::vector<std::string> labels;
    for (const Tick& tick : ticks({AxisScale::linear, 0.0, 106.0})) labels.push_back(tick.label);
    EXPECT_EQ(labels, (std::vector<std::string>{"0", "20", "40", "60", "80", "100"}));
}

TEST(Plot, LogarithmicTicksLabelDecades) {
    std::vector<std::string> labels;
    for (const Tick& tick : ticks({AxisScale::logarithmic, 0.5, 2e6}))
        if (!tick.label.empty()) labels.push_back(tick.label);
    EXPECT_THAT(labels, ::testing::IsSupersetOf({"10", "1000", "100 k"}));
}

Plot plot_of(std::vector<Point> points) {
    Series series;
    series.name = "series";
    series.points = std::move(points);
    return {"title", {"x", AxisScale::logarithmic}, {"y", AxisScale::logarithmic}, {series}, {}};
}

std::ptrdiff_t marks_in(const std::string& svg) {
    const std::regex mark("class=\"mark\"[^>]*><title>");
    return std::distance(std::sregex_iterator(svg.begin(), svg.end(), mark), std::sregex_iterator());
}

TEST(Plot, PointsThatAnAxisCannotShowAreLeftOutAndTheOthersDrawn) {
    const std::string svg =
        to_figure(plot_of({{1, 1, "a"}, {0, 1, "b"}, {2, std::nan(""), "c"}, {infinity, 3, "d"}, {4, 5, "e"}}));
    EXPECT_EQ(marks_in(svg), 2);
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(Plot, WithoutAnyPointItIsStillAPlot) {
    const std::string svg = to_figure(plot_of({}));
    EXPECT_EQ(marks_in(svg), 0);
    EXPECT_THAT(svg, HasSubstr("class=\"axis\""));
}

TEST(Plot, EveryTextIsEscaped) {
    const std::string evil = "<b>&\"'";
    Plot plot = plot_of({{1, 1, evil}});
    plot.title = plot.x.label = plot.y.label = plot.series[0].name = evil;
    plot.guides.push_back({1.0, evil});
    const std::string svg = to_figure(plot);
    EXPECT_THAT(svg, Not(HasSubstr("<b>")));
    EXPECT_THAT(svg, HasSubstr("&lt;b&gt;&amp;&quot;&#39;"));
}

TEST(Plot, MoreSeriesThanColoursRepeatThem) {
    Plot plot = plot_of({{1, 1, "a"}});
    while (plot.series.size() <= plot_styles) plot.series.push_back(plot.series.front());
    EXPECT_THAT(to_figure(plot), Not(HasSubstr("class=\"s7\"")));
    EXPECT_THAT(plot_css(), HasSubstr(".s6{"));
}

}  // namespace
}  // namespace lodestream::report
