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

constexpr const char* points_of_a_bunny = R"({
  "run": {"command": "bench --json <x>", "commit": "abc", "date": "2026-01-02T03:04:05Z", "cpu": "a CPU", "cores": 2},
  "models": [{"model": "bunny", "triangles": 100,
    "scores": [
      {"level": "L0", "is_scaled": false, "points": 50, "instances": 3, "views": 2, "recall": 1.0, "precision": 0.5,
       "f_measure": 0.7},
      {"level": "all", "is_scaled": false, "points": 50, "instances": 8, "views": 2, "recall": 1.0, "precision": 0.9,
       "f_measure": 0.95, "paper_f": 0.9}],
    "settings": [
      {"varied": "side", "filter": "median", "slices": 100, "side": 20, "point_size": 1.0, "points": 40, "holes": 12,
       "hole_px": 30, "views": 4, "recall": 1.0, "precision": 0.9, "f_measure": 0.95},
      {"varied": "filter", "filter": "none", "slices": 100, "side": 100, "point_size": 0.5, "points": 40, "holes": 8,
       "hole_px": 30, "views": 4, "recall": 1.0, "precision": 0.9, "f_measure": 0.95}],
    "crowds": [{"instances": 25, "full_triangles": 2500, "points": 200, "full_ms": 12.0, "points_ms": 4.0,
                "paper_gain": 1.1, "scaled_gain": 1.05}],
    "choices": [
      {"device": "pda", "points_per_triangle": 0.5, "frame_share": 1.0, "distance": 3.0, "triangles": 100,
       "points": 50, "triangles_percent": 4.0, "points_percent": 9.0, "chose_points": false},
      {"device": "pda", "points_per_triangle": 8.0, "frame_share": 1.0, "distance": 3.0, "triangles": 100,
       "points": 800, "triangles_percent": 4.0, "points_percent": 2.0, "chose_points": true, "crossing": 9.0},
      {"device": "pda", "points_per_triangle": 8.0, "frame_share": 1.0, "distance": 6.0, "triangles": 100,
       "points": 800, "triangles_percent": 4.0, "points_percent": 2.0, "chose_points": false}],
    "pictures": [{"title": "crowd", "panels": ["full", "points"], "png": "aGk="},
                 {"title": "slices", "png": "aG8="}]}]})";

constexpr const char* two_ships = R"({
  "run": {"command": "bench --growth <x>", "commit": "abc", "date": "2026-01-02T03:04:05Z", "cpu": "a CPU", "cores": 2},
  "models": [{"model": "ship", "bakes": [
    {"objects": 10, "triangles": 1000, "tiles": 3, "bytes": 500, "wall_ms": 60.0, "cpu_ms": 100.0, "tiles_ms": 20.0,
     "peak_memory_bytes": 7000},
    {"objects": 100, "triangles": 10000, "tiles": 30, "bytes": 5000, "wall_ms": 700.0, "cpu_ms": 1500.0,
     "tiles_ms": 200.0, "peak_memory_bytes": 70000}]}]})";

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

class PointRuns : public WithFile {
  protected:
    Result<proto::PointsRun> read(const std::string& text) const { return read_points(holding(text)); }
};

class SceneRuns : public WithFile {
  protected:
    Result<proto::SceneRun> read(const std::string& text) const { return read_scenes(holding(text)); }
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

// The cell of this key in the first row.
Cell first_cell(const Table& table, const std::string& key) {
    for (std::size_t c = 0; c < table.columns.size(); ++c)
        if (table.columns[c].key == key) return table.rows.at(0).at(c);
    ADD_FAILURE() << "no column " << key;
    return {};
}

double first_number(const Table& table, const std::string& key) {
    return std::get<double>(first_cell(table, key));
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

TEST_F(PointRuns, ShowTheWholeCrowdBesideThePapersAndKeepEveryLevelAsARow) {
    const Result<proto::PointsRun> run = read(points_of_a_bunny);
    ASSERT_TRUE(run) << run.error().message;
    const Section section = points_scores_section(*run);
    EXPECT_EQ(section.rows.rows.size(), 2u);
    ASSERT_TRUE(section.shown);
    ASSERT_EQ(section.shown->rows.size(), 1u);
    EXPECT_EQ(first_cell(*section.shown, "f_measure"), Cell(0.95));
    EXPECT_EQ(first_cell(*section.shown, "paper_f"), Cell(0.9));
    EXPECT_THAT(section.text_html, HasSubstr("bench --json &lt;x&gt;"));
    ASSERT_EQ(section.strips.size(), 1u);
    EXPECT_EQ(section.strips[0].png_base64, "aGk=");
    EXPECT_EQ(section.strips[0].labels, (std::vector<std::string>{"full", "points"}));
}

TEST_F(PointRuns, PlotHolesOverWhatIsVaried) {
    const Section section = points_settings_section(*read(points_of_a_bunny));
    EXPECT_EQ(section.rows.rows.size(), 2u);
    ASSERT_EQ(section.plots.size(), 6u);  // holes and F over T3, T1 and T2
    ASSERT_EQ(section.plots[0].series.size(), 1u);
    ASSERT_EQ(section.plots[0].series[0].points.size(), 1u);
    EXPECT_EQ(section.plots[0].series[0].points[0].x, 20.0);
    EXPECT_EQ(section.plots[0].series[0].points[0].y, 3.0);
    ASSERT_TRUE(section.shown);
    EXPECT_EQ(first_cell(*section.shown, "filter"), Cell("none"));
    EXPECT_EQ(section.strips.size(), 1u);
}

TEST_F(PointRuns, TellTheGainBesideThePapers) {
    const Section section = points_crowds_section(*read(points_of_a_bunny));
    EXPECT_EQ(first_cell(section.rows, "gain"), Cell(3.0));
    EXPECT_EQ(first_cell(section.rows, "paper_gain"), Cell(1.1));
    EXPECT_EQ(first_cell(section.rows, "scaled_gain"), Cell(1.05));
}

TEST_F(PointRuns, TellWhereThePlanTakesWhatIsNearer) {
    const Section section = points_choices_section(*read(points_of_a_bunny));
    EXPECT_EQ(section.rows.rows.size(), 3u);
    ASSERT_EQ(section.plots.size(), 1u);  // of one device and share
    ASSERT_EQ(section.plots[0].series.size(), 2u);
    EXPECT_EQ(section.plots[0].series[0].points[0].y, 2.25);
    EXPECT_EQ(section.plots[0].series[1].points.size(), 2u);
    ASSERT_TRUE(section.shown);
    ASSERT_EQ(section.shown->rows.size(), 2u);
    EXPECT_EQ(first_number(*section.shown, "right_percent"), 100.0);
    EXPECT_THAT(section.text_html, HasSubstr("on 66.7 % of 3 cases. Points are nearer on 2, and on 1 of these"));
}

TEST_F(PointRuns, AreSectionsOnlyOfWhatWasMeasured) {
    ReportData data = testing::report_data();
    data.points = *read(points_of_a_bunny);
    EXPECT_EQ(sections(data).size(), sections(testing::report_data()).size() + 4);
    data.points->crowds.clear();
    EXPECT_EQ(sections(data).size(), sections(testing::report_data()).size() + 3);
}

TEST_F(PointRuns, AnythingElseIsRefusedWithItsPlace) {
    std::string not_base64 = points_of_a_bunny;
    not_base64.replace(not_base64.find("aGk="), 4, "\\\"><b");
    for (const std::string& text : {std::string("{}"), std::string(R"({"models": [{"scores": 3}]})"), not_base64}) {
        const Result<proto::PointsRun> refused = read(text);
        ASSERT_FALSE(refused) << text;
        EXPECT_EQ(refused.error().code, ErrorCode::invalid_input);
        EXPECT_THAT(refused.error().message, HasSubstr("benchmark.json"));
    }
}

TEST_F(SceneRuns, PlotBakeTimesBesideAStraightLine) {
    const Result<proto::SceneRun> run = read(two_ships);
    ASSERT_TRUE(run) << run.error().message;
    const Section section = scenes_section(*run);
    EXPECT_EQ(section.rows.rows.size(), 2u);
    EXPECT_EQ(first_cell(section.rows, "cpu_us_per_triangle"), Cell(100.0));
    EXPECT_EQ(first_cell(section.rows, "peak_memory_bytes"), Cell(std::uint64_t{7000}));
    ASSERT_EQ(section.plots.size(), 1u);
    ASSERT_EQ(section.plots[0].series.size(), 2u);
    EXPECT_EQ(section.plots[0].series[0].points[1].y, 1.5);
    EXPECT_EQ(section.plots[0].series[1].points[1].y, 1.0);
    EXPECT_THAT(section.text_html, HasSubstr("bench --growth &lt;x&gt;"));

    ReportData data = testing::report_data();
    data.scenes = *run;
    EXPECT_EQ(sections(data).size(), sections(testing::report_data()).size() + 1);
}

TEST_F(SceneRuns, AnythingElseIsRefusedWithItsPlace) {
    for (const char* text : {"{}", R"({"models": [{"model": "ship", "bakes": [{"objects": 3}]}]})", "\xff"}) {
        const Result<proto::SceneRun> refused = read(text);
        ASSERT_FALSE(refused) << text;
        EXPECT_EQ(refused.error().code, ErrorCode::invalid_input);
        EXPECT_THAT(refused.error().message, HasSubstr("benchmark.json"));
    }
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
