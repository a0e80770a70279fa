#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "client/report/section_rows.h"
#include "tests/client/report/constructed_data.h"

namespace lodestream::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::size_t column(const Table& table, const std::string& key) {
    const auto found =
        std::find_if(table.columns.begin(), table.columns.end(), [&](const Column& c) { return c.key == key; });
    return static_cast<std::size_t>(found - table.columns.begin());
}

TEST(FrameRateSection, HasARowForEveryFlightExposureAndSimulatedMotion) {
    const Section section = frame_rate_section(testing::report_data());
    EXPECT_EQ(section.key, "frame_rate");
    EXPECT_EQ(section.rows.rows.size(), 6u + 2u + 6u);
    EXPECT_EQ(section.shown->rows.size(), 6u);
    EXPECT_EQ(section.plots.size(), 4u);
}

TEST(FrameRateSection, CellsAreOfTheirOwnRow) {
    const Table rows = frame_rate_section(testing::report_data()).rows;
    EXPECT_EQ(std::get<double>(rows.rows[0][column(rows, "within_deadline_percent")]), 50.0);
    EXPECT_EQ(std::get<std::uint64_t>(rows.rows[6][column(rows, "exposures")]), 1u);
    EXPECT_EQ(std::get<double>(rows.rows[7][column(rows, "image_error_percent")]), 1.0);
    EXPECT_EQ(std::get<double>(rows.rows[8][column(rows, "within_deadline_percent")]), 90.0);
    EXPECT_TRUE(std::holds_alternative<std::monostate>(rows.rows[8][column(rows, "average_fps")]));
}

TEST(FrameRateSection, SaysWherePredictiveIsBehind) {
    ReportData data = testing::report_data();
    EXPECT_THAT(frame_rate_section(data).text_html, HasSubstr("every one"));
    data.frame_rate->sweep[1].within_deadline = 0.91;
    EXPECT_THAT(frame_rate_section(data).text_html, HasSubstr("less often than another on 1 of the 20 motions"));
}

TEST(FrameRateSection, SaysHowFarTheProbeIsOffFrameTimes) {
    ReportData data = testing::report_data();
    EXPECT_THAT(frame_rate_section(data).text_html, Not(HasSubstr("From the probe")));
    std::size_t frames = 0;
    for (LadderLevel& level : data.assets[0].ladder)
        for (DrawnLevel& drawn : level.drawn) {
            drawn.predicted_ms = (frames == 0 ? 0.5 : 1.1) * drawn.frame_ms;
            ++frames;
        }
    const Section section = frame_rate_section(data);
    EXPECT_THAT(section.text_html, HasSubstr("error of 10 % in the median"));
    EXPECT_THAT(section.text_html, HasSubstr("50 % at the worst, over " + std::to_string(frames) + " levels"));
    const auto& row = section.rows.rows.back();
    EXPECT_EQ(std::get<std::string>(row[column(section.rows, "series")]), "predicted");
    EXPECT_EQ(std::get<std::string>(row[column(section.rows, "model")]), data.assets[0].asset.name);
    EXPECT_EQ(std::get<std::uint64_t>(row[column(section.rows, "frames")]), frames);
    EXPECT_NEAR(std::get<double>(row[column(section.rows, "worst_prediction_error_percent")]), 50.0, 1e-9);
}

TEST(FrameRateSection, SaysWhenTheFlightsWereDisturbed) {
    ReportData data = testing::report_data();
    EXPECT_THAT(frame_rate_section(data).text_html, Not(HasSubstr("Disturbed")));
    data.frame_rate->flights[2].other_cores = 1.25;
    EXPECT_THAT(frame_rate_section(data).text_html, HasSubstr("other processes kept up to 1.25 cores busy"));
}

TEST(FrameRateSection, WithoutMeasurementsSaysSo) {
    ReportData data = testing::report_data();
    data.frame_rate.reset();
    const Section section = frame_rate_section(data);
    EXPECT_TRUE(section.rows.rows.empty());
    EXPECT_THAT(section.text_html, HasSubstr("Not measured"));
}

}  // namespace
}  // namespace lodestream::report
