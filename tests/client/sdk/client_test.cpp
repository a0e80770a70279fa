#include "client/sdk/client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <thread>

#include "proto/gzip.h"
#include "tests/client/sdk/canned_server.h"
#include "tests/support/meshes.h"

namespace lodestream::sdk {
namespace {

using lodestream::testing::CannedServer;
using lodestream::testing::http_reply;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* json_type = "application/json";
constexpr const char* glb_type = "model/gltf-binary";
constexpr const char* problem_type = "application/problem+json";

std::string json_reply(const std::string& body) {
    return http_reply(200, json_type, body);
}

proto::Asset teapot(proto::AssetStatus status) {
    proto::Asset asset;
    asset.id = "a1";
    asset.name = "teapot";
    asset.kind = "mesh";
    asset.triangles = 4;
    asset.vertices = 4;
    asset.status = status;
    return asset;
}

proto::PlanRequest pda() {
    proto::PlanRequest request;
    request.asset = "teapot";
    request.budget.device.cpu_mhz = 300;
    return request;
}

proto::PlanResponse plan_of(std::uint64_t triangles, std::uint64_t bytes) {
    proto::PlanResponse plan;
    plan.budget.triangles = triangles;
    plan.budget.limited_by = "device";
    plan.level.triangles = triangles;
    plan.shading.flat = triangles;
    plan.shading.mode = "flat";
    plan.content.url = "/v1/content/abc.glb";
    plan.content.bytes = bytes;
    return plan;
}

std::string tetrahedron_glb() {
    mesh::Model model;
    model.materials.resize(1);
    mesh::Mesh level = lodestream::testing::tetrahedron();
    const std::vector<std::uint8_t> flat(level.triangles.size(), 0);
    codec::EncodeOptions options;
    options.grid.bits = 12;
    const auto encoded = codec::encode_level(model, level, flat, options);
    EXPECT_TRUE(encoded) << encoded.error().message;
    if (!encoded) return {};
    const auto* bytes = reinterpret_cast<const char*>(encoded->glb.data());
    return {bytes, encoded->glb.size()};
}

Client open(const CannedServer& server) {
    return *Client::open(server.url());
}

TEST(ServerUrl, TakesHostPortAndAddressesInBrackets) {
    const auto plain = parse_server_url("http://example.org");
    ASSERT_TRUE(plain);
    EXPECT_EQ(plain->host, "example.org");
    EXPECT_EQ(plain->port, 80);
    const auto ported = parse_server_url("http://127.0.0.1:8080/");
    ASSERT_TRUE(ported);
    EXPECT_EQ(ported->host, "127.0.0.1");
    EXPECT_EQ(ported->port, 8080);
    const auto ipv6 = parse_server_url("http://[::1]:90");
    ASSERT_TRUE(ipv6);
    EXPECT_EQ(ipv6->host, "::1");
    EXPECT_EQ(ipv6->port, 90);
}

TEST(ServerUrl, RefusesWhatIsNoHttpServer) {
    for (const char* url : {"", "http://", "localhost:8080", "ftp://a", "http://a:0", "http://a:65536", "http://a:-1",
                            "http://a:8x", "http://a:", "http://a/b", "http://a b", "http://[::1", "http://[::1]x",
                            "http://a\r\nHost: b", "http://user@a", "http:///x"})
        EXPECT_FALSE(parse_server_url(url)) << url;
    const auto tls = parse_server_url("https://a");
    ASSERT_FALSE(tls);
    EXPECT_EQ(tls.error().code, ErrorCode::unsupported);
    EXPECT_FALSE(parse_server_url(std::string(1 << 20, 'a')));
}

// A plan of `points` points and the file that it names, which holds three.
std::vector<lodestream::testing::CannedReply> replies_with_points(std::uint64_t points, std::uint64_t budget) {
    codec::Points content;
    content.cloud.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    Box box;
    for (const Vec3f& p : content.cloud.positions) box.add(Vec3d(p));
    content.grid = codec::point_grid(box);
    content.levels = {{3, {0.1, 0.2}, 0.5}};
    const auto encoded = codec::encode_points(content);
    EXPECT_TRUE(encoded);
    const std::string glb(reinterpret_cast<const char*>(encoded->glb.data()), encoded->glb.size());
    proto::PlanResponse plan;
    plan.content.url = "/v1/content/points.glb";
    plan.content.bytes = glb.size();
    plan.level.points = points;
    plan.budget.points = budget;
    plan.budget.limited_by = "device";
    return {{json_reply(proto::to_json(plan))}, {http_reply(200, glb_type, glb)}};
}

TEST(Client, LoadsPointsWhereThePlanSendsThem) {
    CannedServer server(replies_with_points(3, 10));
    proto::PlanRequest request = pda();
    request.primitives = proto::Primitives::points;
    const auto loaded = open(server).load(request);
    ASSERT_TRUE(loaded) << loaded.error().message;
    ASSERT_TRUE(loaded->points);
    EXPECT_EQ(loaded->points->cloud.positions.size(), 3u);
    EXPECT_TRUE(loaded->content.primitives.empty());
    EXPECT_THAT(server.requests().front(), HasSubstr("\"primitives\":\"points\""));
}

TEST(Client, RefusesPointsThatContradictThePlan) {
    CannedServer fewer(replies_with_points(4, 10));
    EXPECT_THAT(open(fewer).load(pda()).error().message, HasSubstr("holds 3 points, the plan said 4"));
    CannedServer over(replies_with_points(3, 2));
    EXPECT_THAT(open(over).load(pda()).error().message, HasSubstr("level.points exceeds the budget"));
}

TEST(Client, ListsAssetsOverOneKeptConnection) {
    const std::string list = proto::to_json(std::vector<proto::Asset>{teapot(proto::AssetStatus::ready)});
    CannedServer server({{json_reply(list)}, {json_reply(list)}});
    Client client = open(server);
    for (int i = 0; i < 2; ++i) {
        const auto assets = client.assets();
        ASSERT_TRUE(assets) << assets.error().message;
        ASSERT_EQ(assets->size(), 1u);
        EXPECT_EQ(assets->front().name, "teapot");
    }
    EXPECT_EQ(server.connections(), 1);
    EXPECT_THAT(server.requests().front(), HasSubstr("GET /v1/assets HTTP/1.1\r\n"));
}

TEST(Client, TakesBodiesAsGzipWithinTheirLimit) {
    const auto reply = [](std::string body) {
        return lodestream::testing::CannedReply{
            http_reply(200, "application/json", body, "Content-Encoding: gzip\r\n")};
    };
    const std::string sound = proto::gzip(proto::to_json(std::vector<proto::Asset>{}));
    CannedServer server({reply(sound), reply(sound.substr(0, sound.size() - 1)),
                         reply(proto::gzip(std::string(std::size_t{200} << 20, ' ')))});
    Client client = open(server);
    EXPECT_TRUE(client.assets());
    const auto cut_off = client.assets();
    ASSERT_FALSE(cut_off);
    EXPECT_EQ(cut_off.error().code, ErrorCode::invalid_input);
    const auto bomb = client.assets();
    ASSERT_FALSE(bomb);
    EXPECT_EQ(bomb.error().code, ErrorCode::limit_exceeded);
    EXPECT_THAT(server.requests()[0], HasSubstr("Accept-Encoding: gzip"));
}

TEST(Client, ConnectsAnewWhereTheServerClosedTheKeptConnection) {
    const std::string list = proto::to_json(std::vector<proto::Asset>{});
    CannedServer server({{json_reply(list), true}, {json_reply(list)}});
    Client client = open(server);
    ASSERT_TRUE(client.assets());
    const auto again = client.assets();
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(server.connections(), 2);
}

TEST(Client, EncodesIdsIntoThePath) {
    CannedServer server({{json_reply(proto::to_json(teapot(proto::AssetStatus::ready)))}});
    ASSERT_TRUE(open(server).asset("a b/../c?d\r\nX: y"));
    EXPECT_THAT(server.requests().front(), HasSubstr("GET /v1/assets/a%20b%2F..%2Fc%3Fd%0D%0AX%3A%20y HTTP/1.1\r\n"));
}

TEST(Client, SaysThatNobodyListens) {
    std::string url;
    {
        CannedServer gone({});
        url = gone.url();
    }
    auto client = Client::open(url);
    ASSERT_TRUE(client);
    const auto assets = client->assets();
    ASSERT_FALSE(assets);
    EXPECT_EQ(assets.error().code, ErrorCode::unavailable);
    EXPECT_THAT(assets.error().message, HasSubstr("cannot connect to 127.0.0.1:"));
}

TEST(Client, GivesTheServersDetailOfAProblem) {
    proto::Problem problem;
    problem.status = 404;
    problem.title = "Not Found";
    problem.detail = "no asset \"kettle\"\nand \x1b[31mno other";
    CannedServer server({{http_reply(404, problem_type, proto::to_json(problem))}});
    const auto plan = open(server).plan(pda());
    ASSERT_FALSE(plan);
    EXPECT_EQ(plan.error().code, ErrorCode::not_found);
    EXPECT_EQ(plan.error().message, "no asset \"kettle\" and  [31mno other (HTTP 404)");
}

TEST(Client, MapsStatusToErrorCode) {
    const std::vector<std::pair<int, ErrorCode>> expected{
        {400, ErrorCode::invalid_input},  {401, ErrorCode::unauthorized}, {409, ErrorCode::conflict},
        {413, ErrorCode::limit_exceeded}, {415, ErrorCode::unsupported},  {422, ErrorCode::invalid_input},
        {429, ErrorCode::unavailable},    {500, ErrorCode::io},           {503, ErrorCode::unavailable}};
    for (const auto& [status, code] : expected) {
        CannedServer server({{http_reply(status, "text/plain", "sorry")}});
        const auto assets = open(server).assets();
        ASSERT_FALSE(assets);
        EXPECT_EQ(assets.error().code, code) << status;
        EXPECT_THAT(assets.error().message, HasSubstr("HTTP " + std::to_string(status)));
    }
}

TEST(Client, SurvivesAProblemThatIsNoJson) {
    CannedServer server({{http_reply(400, problem_type, "{{{{")}});
    const auto assets = open(server).assets();
    ASSERT_FALSE(assets);
    EXPECT_EQ(assets.error().code, ErrorCode::invalid_input);
}

TEST(Client, DoesNotFollowRedirects) {
    CannedServer server({{http_reply(302, "text/plain", "", "Location: http://127.0.0.1:1/\r\n")}});
    const auto bytes = open(server).fetch("/v1/content/abc.glb", 10);
    ASSERT_FALSE(bytes);
    EXPECT_THAT(bytes.error().message, HasSubstr("redirect"));
    EXPECT_EQ(server.connections(), 1);
}

TEST(Client, RefusesAnAnswerThatIsNotWhatWasAskedFor) {
    for (const char* body : {"", "[]", "{}", "{\"assets\":{}}", "\xff\xfe", "{\"assets\":[1]}"}) {
        CannedServer server({{json_reply(body)}});
        EXPECT_FALSE(open(server).assets()) << body;
    }
}

TEST(Client, RefusesBytesThatAreNotHttp) {
    for (const char* bytes : {"garbage\r\n\r\n", "HTTP/9.9 200 OK\r\n\r\n", "HTTP/1.1 99999 OK\r\n\r\n", "\r\n\r\n\r\n",
                              "HTTP/1.1 200", "HTTP/1.1 200 OK\r\nContent-Length: -1\r\n\r\n",
                              "HTTP/1.1 200 OK\r\nContent-Length: 99999999999999999999999\r\n\r\n",
                              "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nFFFFFFFFFFFFFFFFFFF\r\n"}) {
        CannedServer server({{bytes, true}});
        const auto assets = open(server).assets();
        ASSERT_FALSE(assets) << bytes;
        EXPECT_EQ(assets.error().code, ErrorCode::io) << bytes << ": " << assets.error().message;
    }
}

TEST(Client, RefusesEndlessHeaders) {
    std::string header = "HTTP/1.1 200 OK\r\n";
    while (header.size() < 4 * max_header_bytes) header += "X-More: " + std::string(1000, 'x') + "\r\n";
    CannedServer server({{header, true}});
    EXPECT_FALSE(open(server).assets());
}

TEST(Client, RefusesAJsonBodyThatDeclaresMoreThanTheLimit) {
    const std::string declared = std::to_string(max_json_bytes + 1);
    CannedServer server({{"HTTP/1.1 200 OK\r\nContent-Length: " + declared + "\r\n\r\n{}", true}});
    const auto assets = open(server).assets();
    ASSERT_FALSE(assets);
    EXPECT_EQ(assets.error().code, ErrorCode::limit_exceeded);
}

TEST(Client, RefusesATruncatedBody) {
    CannedServer server({{"HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\nonly this", true}});
    const auto bytes = open(server).fetch("/v1/content/abc.glb", 100);
    ASSERT_FALSE(bytes);
    EXPECT_EQ(bytes.error().code, ErrorCode::io);
    EXPECT_THAT(bytes.error().message, HasSubstr("before the response was complete"));
}

TEST(Client, RefusesContentOfAnotherLengthThanThePlanSaid) {
    for (const std::string body : {"short", "exactly as long as it should not be"}) {
        CannedServer server({{http_reply(200, glb_type, body)}, {http_reply(200, glb_type, body)}});
        EXPECT_FALSE(open(server).fetch("/v1/content/abc.glb", 10)) << body;
    }
    CannedServer until_close({{"HTTP/1.1 200 OK\r\n\r\nten bytes!", true}});
    EXPECT_TRUE(open(until_close).fetch("/v1/content/abc.glb", 10));
    CannedServer cut_off({{"HTTP/1.1 200 OK\r\n\r\nten byt", true}});
    EXPECT_FALSE(open(cut_off).fetch("/v1/content/abc.glb", 10));
}

TEST(Client, FetchesChunkedContent) {
    CannedServer server(
        {{"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n4\r\nten \r\n6\r\nbytes!\r\n0\r\n\r\n"}});
    const auto bytes = open(server).fetch("/v1/content/abc.glb", 10);
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_EQ(bytes->size(), 10u);
}

// Only what a link must at least take is certain: a busy machine takes longer.
TEST(Client, ALinkCarriesNoMoreThanItsRateAndAnswersNoSoonerThanItsRoundTrip) {
    const std::string body(25'000, 'x');
    CannedServer server({{http_reply(200, glb_type, body)}, {http_reply(200, glb_type, "y")}});
    Result<Client> client = Client::open(server.url(), Link{1.0, 30.0});
    ASSERT_TRUE(client.ok()) << client.error().message;
    const auto elapsed_ms = [start = std::chrono::steady_clock::now()] {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    };
    const auto content = client->fetch("/v1/content/abc.glb", body.size());
    ASSERT_TRUE(content.ok()) << content.error().message;
    EXPECT_EQ(content->size(), body.size());
    const double first_ms = elapsed_ms();
    EXPECT_GE(first_ms, 200.0 - 5.0 + 2 * 30.0);  // 200 kbit, the connection and the request
    ASSERT_TRUE(client->fetch("/v1/content/abc.glb", 1).ok());
    EXPECT_GE(elapsed_ms() - first_ms, 30.0);
}

TEST(Client, RefusesALinkThatCannotBe) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Link link : {Link{-1.0, 1.0}, Link{nan, 1.0}, Link{1.0, -1.0}, Link{1.0, nan}})
        EXPECT_FALSE(Client::open("http://127.0.0.1:1", link).ok());
}

TEST(Client, FetchRefusesUrlsOfOtherPlacesWithoutAsking) {
    CannedServer server({});
    Client client = open(server);
    for (const char* url :
         {"", "/", "v1/content/a.glb", "http://elsewhere/a.glb", "//elsewhere/a.glb", "/a b", "/a\r\nX: y"})
        EXPECT_FALSE(client.fetch(url, 1)) << url;
    EXPECT_FALSE(client.fetch("/v1/content/a.glb", max_content_bytes + 1));
    EXPECT_EQ(server.connections(), 0);
}

TEST(Client, RefusesPlansThatContradictThemselves) {
    const auto refused = [](auto damage) {
        proto::PlanResponse plan = plan_of(4, 100);
        damage(plan);
        CannedServer server({{json_reply(proto::to_json(plan))}});
        return !open(server).plan(pda());
    };
    EXPECT_FALSE(refused([](proto::PlanResponse&) {}));
    EXPECT_TRUE(refused([](proto::PlanResponse& p) { p.content.url = "http://elsewhere/a.glb"; }));
    EXPECT_TRUE(refused([](proto::PlanResponse& p) { p.content.url = "//elsewhere"; }));
    EXPECT_TRUE(refused([](proto::PlanResponse& p) { p.content.bytes = max_content_bytes + 1; }));
    EXPECT_TRUE(refused([](proto::PlanResponse& p) { p.shading.flat = 3; }));
    EXPECT_TRUE(refused([](proto::PlanResponse& p) { p.shading.gouraud = 5; }));
    EXPECT_TRUE(refused([](proto::PlanResponse& p) { p.budget.triangles = 3; }));
}

TEST(Client, SendsThePlanRequestAsJson) {
    CannedServer server({{json_reply(proto::to_json(plan_of(4, 100)))}});
    ASSERT_TRUE(open(server).plan(pda()));
    const std::string request = server.requests().front();
    EXPECT_THAT(request, HasSubstr("POST /v1/plans HTTP/1.1\r\n"));
    EXPECT_THAT(request, HasSubstr("Content-Type: application/json\r\n"));
    EXPECT_TRUE(request.ends_with(proto::to_json(pda())));
}

TEST(Client, LoadsPlanFetchesAndDecodes) {
    const std::string glb = tetrahedron_glb();
    CannedServer server({{json_reply(proto::to_json(plan_of(4, glb.size())))}, {http_reply(200, glb_type, glb)}});
    const auto loaded = open(server).load(pda());
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(loaded->bytes, glb.size());
    ASSERT_EQ(loaded->content.primitives.size(), 1u);
    EXPECT_EQ(loaded->content.primitives[0].mesh.triangles.size(), 4u);
    EXPECT_GE(loaded->timing.decode_ms, 0.0);
    EXPECT_THAT(server.requests().at(1), HasSubstr("GET /v1/content/abc.glb HTTP/1.1\r\n"));
}

TEST(Client, LoadRefusesALevelWithOtherTrianglesThanThePlan) {
    const std::string glb = tetrahedron_glb();
    CannedServer server({{json_reply(proto::to_json(plan_of(5, glb.size())))}, {http_reply(200, glb_type, glb)}});
    const auto loaded = open(server).load(pda());
    ASSERT_FALSE(loaded);
    EXPECT_THAT(loaded.error().message, HasSubstr("the plan said 5"));
}

TEST(Client, LoadRefusesGarbageInsteadOfAGlb) {
    std::string damaged = tetrahedron_glb();
    damaged.resize(damaged.size() / 2);
    for (const std::string& glb : {std::string(64, 'x'), std::string("glTF"), damaged}) {
        CannedServer server({{json_reply(proto::to_json(plan_of(4, glb.size())))}, {http_reply(200, glb_type, glb)}});
        const auto loaded = open(server).load(pda());
        ASSERT_FALSE(loaded);
        EXPECT_THAT(loaded.error().message, HasSubstr("/v1/content/abc.glb"));
        EXPECT_THAT(loaded.error().message, Not(HasSubstr("\n")));
    }
}

TEST(Client, UploadsWithNameAndToken) {
    CannedServer server({{http_reply(202, json_type, proto::to_json(teapot(proto::AssetStatus::baking)))}});
    const std::string model = "ply\n";
    const auto asset = open(server).upload("tea pot", std::as_bytes(std::span(model)), "secret");
    ASSERT_TRUE(asset) << asset.error().message;
    const std::string request = server.requests().front();
    EXPECT_THAT(request, HasSubstr("POST /v1/assets?name=tea%20pot HTTP/1.1\r\n"));
    EXPECT_THAT(request, HasSubstr("Authorization: Bearer secret\r\n"));
    EXPECT_TRUE(request.ends_with("\r\n\r\nply\n"));
}

TEST(Client, ATilesetIsNewerOrThereIsNone) {
    const std::string tileset =
        R"({"asset":{"version":"1.1","tilesetVersion":"8"},"root":{"boundingVolume":{"box":[0,0,0,1,0,0,0,1,0,0,0,1]},"geometricError":0,"content":{"uri":"/v1/content/x.glb"}}})";
    CannedServer server({{"HTTP/1.1 304 Not Modified\r\n\r\n"}, {http_reply(200, "application/json", tileset)}});
    auto client = open(server);
    const auto none = client.newer_tileset("a b", 7);
    ASSERT_TRUE(none) << none.error().message;
    EXPECT_FALSE(*none);
    const auto newer = client.newer_tileset("a b", 7);
    ASSERT_TRUE(newer && *newer);
    EXPECT_EQ((*newer)->revision, 8u);
    EXPECT_THAT(server.requests()[0], HasSubstr("GET /v1/assets/a%20b/tileset.json?after=7 "));
}

TEST(Client, SendsChangesOfNodesWithItsToken) {
    CannedServer server({{http_reply(200, "application/json", R"({"revision":5,"moved_objects":1})")}});
    auto client = open(server);
    const auto changed = client.change_nodes("ship", {{3, std::nullopt, false}}, "secret");
    ASSERT_TRUE(changed) << changed.error().message;
    EXPECT_EQ(changed->revision, 5u);
    EXPECT_THAT(server.requests()[0], HasSubstr("PATCH /v1/assets/ship/nodes "));
    EXPECT_THAT(server.requests()[0], HasSubstr("Bearer secret"));
    EXPECT_THAT(server.requests()[0], HasSubstr(R"({"nodes":[{"node":3,"visible":false}]})"));
}

TEST(Client, NeverUploadsTwice) {
    const std::string list = proto::to_json(std::vector<proto::Asset>{});
    CannedServer server({{json_reply(list)}, {"", true}, {"", true}});
    Client client = open(server);
    ASSERT_TRUE(client.assets());
    EXPECT_FALSE(client.upload("teapot", {}));
    EXPECT_EQ(server.requests().size(), 2u);
}

TEST(Client, HearsARefusalThatComesBeforeTheBodyIsSent) {
    proto::Problem problem;
    problem.status = 413;
    problem.detail = "larger than 512 MiB";
    CannedServer server({{http_reply(413, problem_type, proto::to_json(problem)), false, true}});
    const std::vector<std::byte> model(1 << 16);
    const auto asset = open(server).upload("teapot", model);
    ASSERT_FALSE(asset);
    EXPECT_EQ(asset.error().code, ErrorCode::limit_exceeded);
    EXPECT_THAT(asset.error().message, HasSubstr("larger than 512 MiB"));
}

TEST(Client, WaitsUntilAnAssetIsReadyByName) {
    const auto list = [](proto::AssetStatus status) {
        return json_reply(proto::to_json(std::vector<proto::Asset>{teapot(status)}));
    };
    CannedServer server({{list(proto::AssetStatus::baking)},
                         {list(proto::AssetStatus::ready)},
                         {json_reply(proto::to_json(teapot(proto::AssetStatus::ready)))}});
    const auto asset = open(server).wait_ready("teapot", 30.0);
    ASSERT_TRUE(asset) << asset.error().message;
    EXPECT_EQ(asset->status, proto::AssetStatus::ready);
    EXPECT_EQ(server.requests().size(), 3u);
}

TEST(Client, WaitEndsWhereTheAssetFailedIsMissingOrStaysBaking) {
    proto::Asset failed = teapot(proto::AssetStatus::failed);
    failed.error = "no triangles";
    CannedServer failing({{json_reply(proto::to_json(std::vector<proto::Asset>{failed}))}});
    const auto broken = open(failing).wait_ready("a1", 30.0);
    ASSERT_FALSE(broken);
    EXPECT_THAT(broken.error().message, HasSubstr("no triangles"));

    CannedServer empty({{json_reply(proto::to_json(std::vector<proto::Asset>{}))}});
    const auto missing = open(empty).wait_ready("a1", 30.0);
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, ErrorCode::not_found);

    CannedServer slow({{json_reply(proto::to_json(std::vector<proto::Asset>{teapot(proto::AssetStatus::baking)}))}});
    const auto late = open(slow).wait_ready("a1", 0.0);
    ASSERT_FALSE(late);
    EXPECT_EQ(late.error().code, ErrorCode::unavailable);
}

TEST(Client, IsFoundByNameOrIdWithItsDetails) {
    const std::string list = json_reply(proto::to_json(std::vector<proto::Asset>{teapot(proto::AssetStatus::ready)}));
    const std::string details = json_reply(proto::to_json(teapot(proto::AssetStatus::ready)));
    CannedServer server({{list}, {details}, {list}, {details}, {list}});
    Client client = open(server);
    for (const char* name : {"teapot", "a1"}) {
        const auto asset = client.find_asset(name);
        ASSERT_TRUE(asset) << asset.error().message;
        EXPECT_EQ(asset->id, "a1");
    }
    const auto missing = client.find_asset("kettle");
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, ErrorCode::not_found);
    EXPECT_THAT(server.requests()[1], HasSubstr("GET /v1/assets/a1 "));
}

TEST(Client, CancellingEndsARequestThatTheServerLetsWait) {
    CannedServer server({{"HTTP/1.1 200 Fine\r\nContent-Length: 100\r\n\r\nhalf of"}});
    Client client = open(server);
    std::thread canceller([&] {
        while (server.requests().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        client.cancel();
    });
    const auto start = std::chrono::steady_clock::now();
    const auto bytes = client.fetch("/v1/content/x.glb", 100);
    canceller.join();
    ASSERT_FALSE(bytes);
    EXPECT_EQ(bytes.error().code, ErrorCode::unavailable);
    EXPECT_FALSE(client.assets()) << "cancelled for good";
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

}  // namespace
}  // namespace lodestream::sdk
