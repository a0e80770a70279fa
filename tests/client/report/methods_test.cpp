#include "client/report/methods.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "client/report/section_rows.h"
#include "tests/client/report/constructed_data.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::report {
namespace {

using ::testing::HasSubstr;

constexpr const char* two_methods = R"({
  "run": {"command": "bench --json <x>", "commit": "abc", "date": "2026-01-02T03:04:05Z", "cpu": "a CPU", "cores": 2},
  "models": [{"model": "bunny", "triangles": 1000, "vertices": 500, "methods": [
    {"method": "ours", "levels": [
      {"asked": 100, "triangles": 100, "wall_ms": 4.0, "cpu_ms": 6.0, "rms_error_percent": 0.5, "max_error_percent": 2.0,
       "image_rms": 9.0, "own_normals_image_rms": 8.0},
      {"asked": 10, "triangles": 10, "wall_ms": 4.0, "cpu_ms": 6.0, "rms_error_percent": 3.0}]},
    {"method": "meshopt", "levels": [{"asked": 100, "triangles": 98, "wall_ms": 2.0, "cpu_ms": 2.0, "image_rms": 11.0}]}
  ]}], "verdicts": []})";

class Methods : public ::testing::Test {
  protected:
    Result<proto::MethodRun> read(const std::string& text) const {
        const auto file = folder_.path() / "methods.json";
        std::ofstream(file) << text;
        return read_methods(file);
    }

  private:
    lodestream::testing::TemporaryFolder folder_;
};

TEST_F(Methods, AreReadWithWhereTheyWereMeasured) {
    const Result<proto::MethodRun> read_back = read(two_methods);
    ASSERT_TRUE(read_back) << read_back.error().message;
    EXPECT_EQ(read_back->commit, "abc");
    ASSERT_EQ(read_back->levels.size(), 3u);
    EXPECT_EQ(read_back->levels[0].image_rms, 8.0);   // with the method's own normals where it has any
    EXPECT_EQ(read_back->levels[2].image_rms, 11.0);  // else with made ones
    EXPECT_FALSE(read_back->levels[2].rms_error_percent);
}

TEST_F(Methods, EveryLevelIsARowAndEachShareHasAPlotOfBothErrors) {
    ReportData data = testing::report_data();
    data.methods = *read(two_methods);
    const Section section = methods_section(*data.methods);
    EXPECT_EQ(section.rows.rows.size(), 3u);
    ASSERT_EQ(section.plots.size(), 4u);  // 10 % and 1 %, distance and picture
    EXPECT_EQ(section.plots[0].series.size(), 2u);
    EXPECT_EQ(section.plots[0].series[1].points.size(), 0u);  // meshopt's distance was not measured
    EXPECT_EQ(section.plots[1].series[1].points.size(), 1u);
    EXPECT_THAT(section.text_html, HasSubstr("bench --json &lt;x&gt;"));
    EXPECT_EQ(sections(data).size(), sections(testing::report_data()).size() + 1);
}

TEST_F(Methods, AnythingElseIsRefusedWithItsPlace) {
    for (const char* text : {"", "[]", "{}", R"({"run": 1})", R"({"models": [{"methods": 3}]})", "\xff\xfe"}) {
        const Result<proto::MethodRun> refused = read(text);
        ASSERT_FALSE(refused) << text;
        EXPECT_EQ(refused.error().code, ErrorCode::invalid_input);
        EXPECT_THAT(refused.error().message, HasSubstr("methods.json"));
    }
    EXPECT_EQ(read_methods("/nowhere/methods.json").error().code, ErrorCode::io);
}

}  // namespace
}  // namespace lodestream::report
