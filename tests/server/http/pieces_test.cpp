// The small pure parts: targets, ranges, tilesets, figures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/http/byte_range.h"
#include "server/http/metrics.h"
#include "server/http/target.h"

namespace lodestream::http {
namespace {

using ::testing::HasSubstr;

TEST(Target, TakesPathAndQueryApart) {
    const auto target = parse_target("/v1/assets/tea%20pot%C3%A9?name=a+b%26c&empty&x=1=2&name=second&&=none");
    ASSERT_TRUE(target) << target.error().message;
    EXPECT_EQ(target->path, "/v1/assets/tea pot\xc3\xa9");
    EXPECT_EQ(target->query, (std::map<std::string, std::string>{{"name", "a b&c"}, {"empty", ""}, {"x", "1=2"}}));
}

TEST(Target, TakesEveryFormThatAProxyMaySend) {
    EXPECT_EQ(parse_target("http://host:80/a?b=c")->path, "/a");
    EXPECT_EQ(parse_target("http://host")->path, "/");
    EXPECT_EQ(parse_target("http://host?x=1")->query.at("x"), "1");
    EXPECT_EQ(parse_target("*")->path, "*");
    EXPECT_EQ(parse_target("")->path, "/");
}

TEST(Target, RefusesWhatIsNotText) {
    for (const char* text :
         {"/%", "/%4", "/%zz", "/a%00b", "/%0a", "/%7f", "/%ff", "/%c0%af", "/%ed%a0%80", "/%f4%90%80%80", "/%e2%82",
          "/x?name=%ff", "/x?%00=1", "relative", "/%f5%80%80%80", "/%e0%80%80", "/%f0%80%80%80"})
        EXPECT_FALSE(parse_target(text)) << text;
    EXPECT_TRUE(parse_target("/%f0%9f%ab%96%e2%82%ac%ed%9f%bf"));
}

RangeAnswer part(std::uint64_t offset, std::uint64_t length) {
    return {RangeAnswer::Kind::part, offset, length};
}
bool operator==(const RangeAnswer& a, const RangeAnswer& b) {
    return a.kind == b.kind && (a.kind != RangeAnswer::Kind::part || (a.offset == b.offset && a.length == b.length));
}

TEST(ByteRange, AnswersOneRange) {
    EXPECT_TRUE(answer_range("bytes=0-0", 10) == part(0, 1));
    EXPECT_TRUE(answer_range("bytes=3-5", 10) == part(3, 3));
    EXPECT_TRUE(answer_range("bytes=3-", 10) == part(3, 7));
    EXPECT_TRUE(answer_range("bytes=3-99", 10) == part(3, 7));
    EXPECT_TRUE(answer_range("bytes=-4", 10) == part(6, 4));
    EXPECT_TRUE(answer_range("bytes=-99", 10) == part(0, 10));
    EXPECT_TRUE(answer_range("bytes=9-99999999999999999999999", 10) == part(9, 1));
    EXPECT_TRUE(answer_range("bytes=0-18446744073709551615", 10) == part(0, 10));
}

TEST(ByteRange, SaysWhatCannotBeSatisfied) {
    for (const char* field : {"bytes=10-", "bytes=10-20", "bytes=-0", "bytes=99999999999999999999999-"})
        EXPECT_EQ(answer_range(field, 10).kind, RangeAnswer::Kind::unsatisfiable) << field;
    for (const char* field : {"bytes=0-", "bytes=-5", "bytes=0-0"})
        EXPECT_EQ(answer_range(field, 0).kind, RangeAnswer::Kind::unsatisfiable) << field;
}

TEST(ByteRange, IgnoresWhatItDoesNotKnow) {
    for (const char* field : {"", "bytes", "bytes=", "bytes=-", "bytes=a-b", "bytes=5-3", "bytes=0-1,3-4", "items=0-1",
                              "bytes=1-2x", "bytes= -", "bytes=--1"})
        EXPECT_EQ(answer_range(field, 10).kind, RangeAnswer::Kind::whole) << field;
}

TEST(EntityTag, ComparesWeakly) {
    EXPECT_TRUE(names_etag("\"a\"", "\"a\""));
    EXPECT_TRUE(names_etag("\"x\", W/\"a\"", "\"a\""));
    EXPECT_TRUE(names_etag("*", "\"a\""));
    EXPECT_FALSE(names_etag("\"ab\"", "\"a\""));
    EXPECT_FALSE(names_etag("a", "\"a\""));
    EXPECT_FALSE(names_etag("", "\"a\""));
}

TEST(Metrics, GivesEachFamilyOnceWithItsType) {
    Metrics metrics;
    metrics.count_request("GET", "/v1/content/{hash}.glb", 200, 0.003, 1000);
    metrics.count_request("GET", "/v1/content/{hash}.glb", 304, 0.0001, 0);
    metrics.count_request("POST", "/v1/plans", 200, 99.0, 500);
    metrics.count_plan("network");
    proto::Asset asset;
    asset.status = proto::AssetStatus::ready;
    const std::string text = metrics.text({1, 2, 3, 4}, {asset});
    for (const char* line :
         {"lodestream_http_requests_total{method=\"GET\",route=\"/v1/content/{hash}.glb\",status=\"304\"} 1\n",
          "lodestream_http_request_duration_seconds_bucket{route=\"/v1/content/{hash}.glb\",le=\"0.0005\"} 1\n",
          "lodestream_http_request_duration_seconds_bucket{route=\"/v1/content/{hash}.glb\",le=\"0.005\"} 2\n",
          "lodestream_http_request_duration_seconds_bucket{route=\"/v1/plans\",le=\"10\"} 0\n",
          "lodestream_http_request_duration_seconds_bucket{route=\"/v1/plans\",le=\"+Inf\"} 1\n",
          "lodestream_http_request_duration_seconds_count{route=\"/v1/plans\"} 1\n",
          "lodestream_http_response_bytes_total{route=\"/v1/content/{hash}.glb\"} 1000\n",
          "lodestream_plans_total{limited_by=\"network\"} 1\n", "lodestream_plans_total{limited_by=\"device\"} 0\n",
          "lodestream_bakes_total{result=\"failed\"} 2\n", "lodestream_bakes_waiting 4\n",
          "lodestream_assets{status=\"ready\"} 1\n", "# TYPE lodestream_http_request_duration_seconds histogram\n",
          "# TYPE lodestream_plans_total counter\n"})
        EXPECT_THAT(text, HasSubstr(line));
    std::map<std::string, int> types;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with("# TYPE ")) ++types[line];
    for (const auto& [line, count] : types) EXPECT_EQ(count, 1) << line;
    EXPECT_EQ(text.back(), '\n');
}

}  // namespace
}  // namespace lodestream::http
