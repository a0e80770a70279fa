#include "client/report/document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/client/report/constructed_data.h"

namespace lodestream::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string evil = "</script><script>alert('1')</script>\"\\\x1b\xFF\n&";

ReportData hostile_data() {
    ReportData data = testing::report_data();
    data.assets[0].asset.name = evil;
    for (DeviceResult& device : data.assets[0].devices) device.plan.budget.limited_by = evil;
    data.problems = {evil};
    data.provenance.command = evil;
    return data;
}

ReportData data_without_finite_numbers() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    ReportData data = testing::report_data();
    AssetResult& asset = data.assets[0];
    asset.diagonal = 0.0;
    asset.full_bytes = 0;
    asset.asset.bake_ms = infinity;
    for (DeviceResult& device : asset.devices) {
        device.plan.dlr = std::nan("");
        device.plan.level.rms_error_percent = infinity;
        device.replan_ms = std::nan("");
        for (ModeResult& mode : device.modes) {
            mode.bytes = 0;
            mode.image.percent = std::nan("");
            mode.frame_ms = infinity;
        }
    }
    for (LadderLevel& rung : asset.ladder) {
        rung.level.triangles = 0;
        rung.level.rms_error = std::nan("");
    }
    return data;
}

TEST(ReportJson, HasOneKeyASectionWithRows) {
    const auto json = nlohmann::json::parse(json_document(testing::report_data()));
    for (const char* key :
         {"budget", "simplification", "codec", "shading", "end_to_end", "hlod", "points", "frame_rate"}) {
        ASSERT_TRUE(json.contains(key)) << key;
        ASSERT_TRUE(json[key].is_array()) << key;
        EXPECT_FALSE(json[key].empty()) << key;
    }
}

TEST(ReportJson, RowsCarryTheContractsFieldNames) {
    const auto json = nlohmann::json::parse(json_document(testing::report_data()));
    const auto expect_fields = [&](const char* key, std::initializer_list<const char*> fields) {
        for (const char* field : fields) EXPECT_TRUE(json[key][0].contains(field)) << key << "." << field;
    };
    expect_fields("budget", {"asset", "device", "dlr", "ncp", "rup", "budget_triangles", "limited_by", "triangles",
                             "gouraud", "flat", "capacity_mhz"});
    expect_fields("simplification", {"asset", "triangles", "vertices", "rms_error", "max_error", "rms_error_percent",
                                     "bytes", "encode_ms", "cut_ms", "bake_ms"});
    expect_fields("codec", {"asset", "triangles", "bytes", "bytes_per_triangle", "rms_error_percent", "shading"});
    expect_fields("shading", {"asset", "shading", "distance", "gouraud", "flat", "frame_ms", "image_error_percent"});
    expect_fields("end_to_end", {"asset", "device", "level", "downlink_mbps", "rtt_ms", "plan_ms", "fetch_ms",
                                 "link_ms", "decode_ms", "frame_ms", "time_ms", "error_px", "rms_error_percent"});
    expect_fields("points", {"model", "level", "instances", "points", "recall", "precision", "f_measure"});
    expect_fields("hlod", {"asset", "method", "budget_triangles", "triangles", "tiles", "bytes", "error_px", "frame_ms",
                           "image_error_percent"});
}

TEST(ReportJson, TimesAddUp) {
    const auto json = nlohmann::json::parse(json_document(testing::report_data()));
    for (const auto& row : json["end_to_end"]) {
        double sum = 0.0;
        for (const char* part : {"plan_ms", "fetch_ms", "link_ms", "decode_ms", "frame_ms"})
            sum += row[part].get<double>();
        EXPECT_NEAR(row["time_ms"].get<double>(), sum, 1e-9);
    }
}

TEST(ReportJson, SaysWhereItComesFrom) {
    const auto json = nlohmann::json::parse(json_document(testing::report_data()));
    EXPECT_EQ(json["run"]["commit"], "0123abcd");
    EXPECT_EQ(json["run"]["command"], "lodestream-client report --out x");
    EXPECT_EQ(json["run"]["cpu"], "A CPU");
}

TEST(ReportJson, StaysJsonWithHostileNamesAndNumbersThatAreNotFinite) {
    const auto hostile = nlohmann::json::parse(json_document(hostile_data()));
    EXPECT_THAT(hostile["budget"][0]["asset"].get<std::string>(), HasSubstr("</script>"));
    const auto json = nlohmann::json::parse(json_document(data_without_finite_numbers()));
    EXPECT_TRUE(json["budget"][0]["dlr"].is_null());
    EXPECT_TRUE(nlohmann::json::accept(json_document({})));
}

TEST(ReportHtml, EverySectionIsThereAndEveryTableNamesCommandCommitAndMachine) {
    const std::string html = html_document(testing::report_data());
    for (const char* key : {"budget", "simplification", "codec", "shading", "end_to_end"})
        EXPECT_THAT(html, HasSubstr("<section id=\"" + std::string(key) + "\">"));
    const std::regex caption("</table></div><figcaption>([^\n]*)</figcaption>");
    std::size_t captions = 0;
    for (std::sregex_iterator it(html.begin(), html.end(), caption), end; it != end; ++it, ++captions)
        for (const char* part : {"lodestream-client report --out x", "0123abcd", "A CPU", "2 cores", "A renderer"})
            EXPECT_THAT((*it)[1].str(), HasSubstr(part));
    EXPECT_GE(captions, 6u);
}

TEST(ReportHtml, LoadsNothingFromOutside) {
    const std::string html = html_document(testing::report_data());
    const std::regex source("(src|href)=\"([^\"]*)\"|url\\(|@import|<script");
    for (std::sregex_iterator it(html.begin(), html.end(), source), end; it != end; ++it)
        EXPECT_TRUE((*it)[2].str().starts_with("data:image/png;base64,") || (*it)[2].str().starts_with("#"))
            << it->str();
}

TEST(ReportHtml, HostileNamesStayText) {
    const std::string html = html_document(hostile_data());
    EXPECT_THAT(html, Not(HasSubstr("<script")));
    EXPECT_THAT(html, Not(HasSubstr("\x1b")));
    EXPECT_THAT(html, Not(HasSubstr("\xFF")));
    EXPECT_THAT(html, HasSubstr("&lt;script&gt;"));
}

TEST(ReportHtml, ShowsNoNumberThatIsNotFinite) {
    const std::regex not_finite("[>\\s\",(-](nan|inf)[<\\s\",)%]", std::regex::icase);
    for (const ReportData& data : {data_without_finite_numbers(), ReportData{}}) {
        EXPECT_FALSE(std::regex_search(html_document(data), not_finite));
        EXPECT_FALSE(std::regex_search(json_document(data), not_finite));
    }
}

TEST(ReportHtml, SaysWhatIsMissing) {
    ReportData data = testing::report_data();
    EXPECT_THAT(html_document(data), Not(HasSubstr("Not in this report")));
    data.problems = {"ship: still baking"};
    EXPECT_THAT(html_document(data), HasSubstr("<li>ship: still baking</li>"));
}

}  // namespace
}  // namespace lodestream::report
