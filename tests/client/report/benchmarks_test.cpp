#include "client/report/benchmarks.h"

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

constexpr const char* two_codecs = R"({
  "run": {"command": "bench --sweep <x>", "commit": "abc", "date": "2026-01-02T03:04:05Z", "cpu": "a CPU", "cores": 2},
  "models": [{"model": "bunny", "triangles": 100, "trials": [
    {"codec": "plain", "setting": "fine", "bytes": 400, "encode_ms": 3.0, "decode_ms": 1.0, "image_rms": 1.0},
    {"codec": "plain", "setting": "coarse", "is_default": true, "bytes": 100, "encode_ms": 3.0, "decode_ms": 1.5,
     "image_rms": 4.0},
    {"codec": "draco", "setting": "fast", "bytes": 500, "encode_ms": 1.0, "decode_ms": 1.0, "image_rms": 2.0},
    {"codec": "draco", "setting": "usual", "is_default": true, "bytes": 400, "encode_ms": 1.0, "decode_ms": 2.0,
     "image_rms": 2.0}]},
  {"model": "hare", "triangles": 10, "trials": [
    {"codec": "draco", "setting": "usual", "is_default": true, "bytes": 40, "encode_ms": 1.0, "decode_ms": 2.0,
     "image_rms": 0.0},
    {"codec": "plain", "setting": "fine", "bytes": 30, "encode_ms": 3.0, "decode_ms": 1.0, "image_rms": 0.5}]}]})";

class WithFile : public ::testing::Test {
  protected:
    std::filesystem::path holding(const std::string& text) const {
        auto file = folder_.path() / "benchmark.json";
        std::ofstream(file) << text;
        return file;
    }

  private:
    lodestream::testing::TemporaryFolder folder_;
};

class Methods : public WithFile {
  protected:
    Result<proto::MethodRun> read(const std::string& text) const { return read_methods(holding(text)); }
};

class Codecs : public WithFile {
  protected:
    Result<proto::CodecRun> read(const std::string& text) const { return read_codecs(holding(text)); }
};

TEST_F(Methods, AreReadWithWhereTheyWereMeasured) {
    const Result<proto::MethodRun> read_back = read(two_methods);
    ASSERT_TRUE(read_back) << read_back.error().message;
    EXPECT_EQ(read_back->origin.commit, "abc");
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
        EXPECT_THAT(refused.error().message, HasSubstr("benchmark.json"));
    }
    EXPECT_EQ(read_methods("/nowhere/methods.json").error().code, ErrorCode::io);
}

// The column of this key in the first row.
double first_number(const Table& table, const std::string& key) {
    for (std::size_t c = 0; c < table.columns.size(); ++c)
        if (table.columns[c].key == key) return std::get<double>(table.rows.at(0).at(c));
    ADD_FAILURE() << "no column " << key;
    return not_known;
}

TEST_F(Codecs, AreComparedAtTheReferencesError) {
    ReportData data = testing::report_data();
    data.codecs = *read(two_codecs);
    ASSERT_EQ(data.codecs->trials.size(), 6u);
    const Section section = codecs_section(*data.codecs);
    EXPECT_EQ(section.rows.rows.size(), 6u);
    ASSERT_TRUE(section.shown);
    ASSERT_EQ(section.shown->rows.size(), 2u);
    // Halfway between 1 and 4 on a logarithmic scale 200 bytes, half of Draco's.
    EXPECT_NEAR(first_number(*section.shown, "plain"), 0.5, 1e-12);
    EXPECT_EQ(section.shown->columns.size(), 4u + 1u + 2u);  // no ratio of the reference to itself
    EXPECT_EQ(first_number(*section.shown, "plain_decode_ms"), 1.5);
    EXPECT_EQ(section.plots.size() + section.folded_plots.size(), 3u);  // decoding, and a model each
    EXPECT_THAT(section.text_html, HasSubstr("bench --sweep &lt;x&gt;"));
    EXPECT_EQ(sections(data).size(), sections(testing::report_data()).size() + 1);
}

TEST_F(Codecs, AnErrorThatNoSettingReachesIsNotKnown) {
    const Section section = codecs_section(*read(two_codecs));
    const auto& hare = section.shown->rows.at(1);  // nothing of plain is as near as no error at all
    EXPECT_TRUE(std::isnan(std::get<double>(hare.at(4))));
}

TEST_F(Codecs, AnythingElseIsRefusedWithItsPlace) {
    for (const char* text : {"", "[]", "{}", R"({"models": [{"trials": 3}]})", "\xff\xfe"}) {
        const Result<proto::CodecRun> refused = read(text);
        ASSERT_FALSE(refused) << text;
        EXPECT_EQ(refused.error().code, ErrorCode::invalid_input);
        EXPECT_THAT(refused.error().message, HasSubstr("benchmark.json"));
    }
}

}  // namespace
}  // namespace lodestream::report
