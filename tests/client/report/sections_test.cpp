#include "client/report/sections.h"
#include "client/report/section_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/report/constructed_data.h"

namespace lodestream::report {
namespace {

using ::testing::HasSubstr;

std::string joined(const std::vector<std::string>& lines) {
    std::string out;
    for (const std::string& line : lines) out += line + "\n";
    return out;
}

const Section& section(const std::vector<Section>& all, const std::string& key) {
    return *std::find_if(all.begin(), all.end(), [&](const Section& s) { return s.key == key; });
}

TEST(Sections, LinkTimeIsBytesOverRateAndTwoRoundTrips) {
    EXPECT_DOUBLE_EQ(link_ms({2.0, 80.0}, 250'000), 1000.0 + 160.0);
    EXPECT_DOUBLE_EQ(link_ms({100.0, 0.0}, 0.0), 0.0);
}

TEST(Sections, OverviewHasOneRowAnAssetAndDevice) {
    ReportData data = testing::report_data();
    data.assets.push_back(testing::asset_result("ship"));
    EXPECT_EQ(overview_table(data).rows.size(), 4u);
}

TEST(Sections, EndToEndHasARowForEveryLevelDeviceAndLinkAndTheDevicesOwnLevel) {
    const std::vector<Section> all = sections(testing::report_data());
    EXPECT_EQ(section(all, "end_to_end").rows.rows.size(), (3u + 1u) * 2u * std::size(links));
}

TEST(Sections, AJourneyTakesWhatWasMeasuredOverTheLinkAndIsComputedElse) {
    ReportData data = testing::report_data();
    DeviceResult& device = data.assets[0].devices[0];
    const DeviceRow row{&data.assets[0], &device};
    const ModeResult& sent = hybrid_of(device);
    EXPECT_DOUBLE_EQ(cut_journey(row, 1).time_ms(),
                     device.replan_ms + sent.fetch_ms + link_ms(links[1], 900.0) + sent.decode_ms + sent.frame_ms);
    device.linked_plan_ms[1] = 90.0;
    device.linked_fetch_ms[1] = 400.0;
    EXPECT_DOUBLE_EQ(cut_journey(row, 1).time_ms(), 490.0 + sent.decode_ms + sent.frame_ms);
    data.assets[0].ladder[0].linked_fetch_ms[1] = 700.0;
    const std::vector<Journey> rungs = rung_journeys(row, 1);
    EXPECT_EQ(rungs[0].linked_ms, 790.0);
    EXPECT_FALSE(rungs[1].linked_ms);
    EXPECT_FALSE(cut_journey(row, 2).linked_ms);
}

TEST(Sections, CodecHasARowForEveryLevelAndEveryShadingModeOfADevice) {
    const std::vector<Section> all = sections(testing::report_data());
    EXPECT_EQ(section(all, "codec").rows.rows.size(), 3u + 2u * 3u);
}

TEST(Sections, HlodHasTheTilesOfScenesBesideTheirPlansAndTheirLadder) {
    ReportData data = testing::report_data();
    EXPECT_EQ(section(sections(data), "hlod").rows.rows.size(), 2u + 1u + 3u);
    EXPECT_EQ(section(sections(data), "hlod").plots[0].series.size(), 3u);
    data.assets[0].hlod.clear();
    data.assets[0].plans.clear();
    data.assets[0].asset.hierarchy.reset();
    EXPECT_TRUE(section(sections(data), "hlod").rows.rows.empty());
    EXPECT_THAT(section(sections(data), "hlod").text_html, HasSubstr("No scene"));
}

TEST(Sections, PointsHaveTheirScoresAndThePlansChoices) {
    ReportData data = testing::report_data();
    const std::vector<Section> all = sections(data);
    EXPECT_EQ(section(all, "points").rows.rows.size(), 2u);
    EXPECT_EQ(section(all, "points").shown->rows.size(), 2u);
    EXPECT_EQ(section(all, "points").plots[0].series.size(), 2u);
    EXPECT_THAT(section(all, "points").text_html, HasSubstr("2 of 2 rows"));
    data.assets[0].choices[0].chose_points = true;
    EXPECT_THAT(section(sections(data), "points").text_html, HasSubstr("1 of 2 rows"));
    data.assets[0].points.clear();
    data.assets[0].choices.clear();
    EXPECT_THAT(section(sections(data), "points").text_html, HasSubstr("No model"));
}

TEST(Sections, EveryRowHasACellForEveryColumn) {
    for (const Section& s : sections(testing::report_data())) {
        EXPECT_FALSE(s.rows.rows.empty()) << s.key;
        for (const auto& row : s.rows.rows) EXPECT_EQ(row.size(), s.rows.columns.size()) << s.key;
    }
}

TEST(Sections, ShadingCountsTheModelsWhereHybridBeatsBothPureModes) {
    ReportData data = testing::report_data();
    EXPECT_THAT(section(sections(data), "shading").text_html, HasSubstr("<strong>1 of 1</strong> models"));
    for (ShadingSample& sample : data.assets[0].shading)
        if (sample.is_chosen) sample.result.image.percent = 2.0;
    EXPECT_THAT(section(sections(data), "shading").text_html, HasSubstr("<strong>0 of 1</strong> models"));
    data.assets[0].shading.clear();
    EXPECT_FALSE(section(sections(data), "shading").shown.has_value());
}

// 4 lights, half a triangle a pixel: the last column.
TEST(Sections, ShadingMapsWhereFlatSavesTimeByLightsAndTrianglesAPixel) {
    ReportData data = testing::report_data();
    const auto map = [&] { return section(sections(data), "shading").text_html; };
    EXPECT_THAT(map(), HasSubstr("<td class=\"n\">4</td>"));
    EXPECT_THAT(map(), HasSubstr("50 %: hybrid can pay"));
    for (ShadingSample& sample : data.assets[0].shading) sample.result.frame_ms = 8.0;
    EXPECT_THAT(map(), HasSubstr("100 %: all Gouraud"));
    EXPECT_THAT(map(), ::testing::Not(HasSubstr("hybrid can pay")));
    for (ShadingSample& sample : data.assets[0].shading) sample.result.frame_ms = 0.0;
    EXPECT_THAT(map(), ::testing::Not(HasSubstr("Where hybrid pays in measured time")));
}

TEST(Sections, SummarySaysNeverMoreOnlyWhereHybridIsNeverLarger) {
    ReportData data = testing::report_data();
    EXPECT_THAT(joined(summary_html(data)), HasSubstr("never more"));
    data.assets[0].devices[0].modes[0].bytes = 1001;
    EXPECT_THAT(joined(summary_html(data)), HasSubstr("but more in 1 of 2 cases"));
}

TEST(Sections, SummarySaysHowManyLevelsWereNotWorthSplitting) {
    ReportData data = testing::report_data();
    EXPECT_THAT(joined(summary_html(data)), ::testing::Not(HasSubstr("went all Gouraud")));
    data.assets[0].devices[0].plan.shading.distance = 0.5;
    data.assets[0].devices[0].modes[0].flat = 0;
    EXPECT_THAT(joined(summary_html(data)), HasSubstr("1 of 2 went all Gouraud"));
}

TEST(Sections, SummaryCountsWhereHybridLiesBetweenFlatAndGouraud) {
    ReportData data = testing::report_data();
    EXPECT_THAT(joined(summary_html(data)), HasSubstr("Of the 2 levels that mix both kinds of triangles, 2 have"));
    data.assets[0].devices[1].modes[0].image.percent = 9.0;
    EXPECT_THAT(joined(summary_html(data)), HasSubstr("Of the 2 levels that mix both kinds of triangles, 1 have"));
}

TEST(Sections, SummaryCountsBudgetsThatWereExceeded) {
    ReportData data = testing::report_data();
    data.assets[0].devices[0].plan.level.triangles = 101;
    EXPECT_THAT(joined(summary_html(data)), HasSubstr("<strong>1 of 2</strong> plans"));
}

TEST(Sections, WithoutAssetsThereIsASentenceAndNoRow) {
    const ReportData data;
    EXPECT_EQ(summary_html(data).size(), 1u);
    for (const Section& s : sections(data)) EXPECT_TRUE(s.rows.rows.empty());
}

}  // namespace
}  // namespace lodestream::report
