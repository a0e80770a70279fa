#include "server/http/service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <future>
#include <set>

#include "proto/gzip.h"
#include "proto/tileset.h"
#include "server/bake/tile_tree.h"
#include "tests/server/http/harness.h"

namespace lodestream::http {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* plan_body = R"({"asset":"teapot","device":{"cpu_mhz":300},"reference":{"triangles":2000}})";

// One baked teapot for the tests that only read.
class ReadyService : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        shared = std::make_unique<Harness>();
        shared->bake("teapot");
    }
    static void TearDownTestSuite() { shared.reset(); }
    Harness& harness() { return *shared; }
    Response get(const std::string& path, std::map<std::string, std::string> headers = {}) {
        return shared->get(path, std::move(headers));
    }
    Response plan(const std::string& body) { return shared->call("POST", "/v1/plans", body); }
    std::string content_url() { return json_of(plan(plan_body))["content"]["url"]; }

  private:
    static inline std::unique_ptr<Harness> shared;
};

TEST_F(ReadyService, TellsItsHealth) {
    EXPECT_EQ(get("/livez").body, "ok\n");
    EXPECT_EQ(get("/readyz").status, 200);
    Harness other;
    other.service.stop_accepting();
    EXPECT_EQ(other.get("/livez").status, 200);
    const Response response = other.get("/readyz");
    expect_problem(response, 503, "stopping");
    EXPECT_TRUE(response.headers.contains("retry-after"));
}

TEST_F(ReadyService, IsNotReadyWhenTheStoreTakesNoWrites) {
    Harness other;
    std::filesystem::remove(other.folder.path() / "store" / "incoming");
    expect_problem(other.get("/readyz"), 503, "no writes");
}

TEST_F(ReadyService, ListsAssetsAndTheirLadders) {
    const Response response = get("/v1/assets");
    EXPECT_EQ(response.status, 200);
    EXPECT_EQ(response.headers.at("content-type"), "application/json");
    const json assets = json_of(response)["assets"];
    ASSERT_EQ(assets.size(), 1u);
    EXPECT_EQ(assets[0]["id"], "teapot");
    EXPECT_EQ(assets[0]["kind"], "mesh");
    EXPECT_EQ(assets[0]["status"], "ready");
    EXPECT_EQ(assets[0]["triangles"], 512);
    EXPECT_GE(assets[0]["levels"].size(), 2u);
    EXPECT_EQ(json_of(get("/v1/assets/teapot")), assets[0]);
    expect_problem(get("/v1/assets/nobody"), 404, "nobody");
}

TEST_F(ReadyService, EveryLevelOfTheLadderCanBeFetched) {
    const json asset = json_of(get("/v1/assets/teapot"));
    for (const json& level : asset["levels"]) {
        const Response response = get(level["url"]);
        ASSERT_EQ(response.status, 200) << level;
        EXPECT_EQ(response.file_length, level["bytes"]);
    }
}

TEST_F(ReadyService, PlansWithinTheBudget) {
    const Response response = plan(plan_body);
    ASSERT_EQ(response.status, 200) << response.body;
    EXPECT_EQ(response.headers.at("cache-control"), "no-store");
    const json answer = json_of(response);
    EXPECT_EQ(answer["ncp"], 176);
    EXPECT_EQ(answer["budget"]["limited_by"], "device");
    EXPECT_LE(answer["level"]["triangles"], 176);
    EXPECT_GE(answer["level"]["triangles"], 175);
    EXPECT_EQ(answer["shading"]["gouraud"].get<int>() + answer["shading"]["flat"].get<int>(),
              answer["level"]["triangles"]);
    EXPECT_EQ(get(answer["content"]["url"]).file_length, answer["content"]["bytes"]);
}

TEST_F(ReadyService, RefusesPlansThatItCannotRead) {
    expect_problem(plan("{"), 400, "not valid JSON");
    expect_problem(plan(""), 400, "not valid JSON");
    expect_problem(plan(R"({"asset":"teapot"})"), 400, "device is missing");
    expect_problem(plan(R"({"asset":"teapot","device":{"cpu_mhz":-3}})"), 400, "device.cpu_mhz");
    expect_problem(plan(R"({"asset":"nobody","device":{"cpu_mhz":3}})"), 404, "nobody");
    expect_problem(harness().call("POST", "/v1/plans", plan_body, {{"content-type", "application/xml"}}), 415,
                   "application/json");
    expect_problem(harness().call("POST", "/v1/plans", plan_body, {{"content-encoding", "gzip"}}), 415, "gzip");
    for (const char* type :
         {"application/json", "Application/JSON; charset=utf-8", "application/x-www-form-urlencoded", "text/plain"})
        EXPECT_EQ(harness().call("POST", "/v1/plans", plan_body, {{"content-type", type}}).status, 200) << type;
}

TEST_F(ReadyService, ContentIsImmutable) {
    const std::string url = content_url();
    const Response response = get(url);
    EXPECT_EQ(response.status, 200);
    const std::string hash = url.substr(url.rfind('/') + 1, 64);
    EXPECT_EQ(response.headers.at("etag"), '"' + hash + '"');
    EXPECT_EQ(response.headers.at("cache-control"), "public, max-age=31536000, immutable");
    EXPECT_EQ(response.headers.at("content-type"), "model/gltf-binary");
    EXPECT_EQ(response.headers.at("accept-ranges"), "bytes");
    EXPECT_EQ(response.headers.at("x-content-type-options"), "nosniff");
    ASSERT_TRUE(response.file);
    EXPECT_EQ(response.file_length, std::filesystem::file_size(response.file->path));
}

TEST_F(ReadyService, ContentIsNotSentAgainToWhoHasIt) {
    const std::string url = content_url();
    const std::string etag = get(url).headers.at("etag");
    for (const std::string& field : {etag, "W/" + etag, std::string("*"), "\"x\", " + etag}) {
        const Response response = get(url, {{"if-none-match", field}, {"range", "bytes=0-1"}});
        EXPECT_EQ(response.status, 304) << field;
        EXPECT_FALSE(response.file);
        EXPECT_EQ(response.headers.at("etag"), etag);
        EXPECT_TRUE(response.headers.contains("cache-control"));
    }
    EXPECT_EQ(get(url, {{"if-none-match", "\"other\""}}).status, 200);
}

TEST_F(ReadyService, TextsArePackedForWhoTakesIt) {
    const Response whole = get("/openapi.json");
    EXPECT_FALSE(whole.headers.contains("content-encoding"));
    EXPECT_EQ(whole.headers.at("vary"), "Accept-Encoding");
    const Response packed = get("/openapi.json", {{"accept-encoding", "br, gzip"}});
    EXPECT_EQ(packed.headers.at("content-encoding"), "gzip");
    EXPECT_LT(packed.body.size(), whole.body.size() / 3);
    EXPECT_EQ(*proto::gunzip(packed.body, whole.body.size()), whole.body);
    EXPECT_FALSE(get("/livez", {{"accept-encoding", "gzip"}}).headers.contains("content-encoding"));
}

TEST_F(ReadyService, ContentIsPackedWholeUnderATagOfItsOwn) {
    const std::string url = content_url();
    const Response plain = get(url, {{"accept-encoding", "gzip;q=0"}});
    ASSERT_TRUE(plain.file);
    const Response packed = get(url, {{"accept-encoding", "gzip"}});
    EXPECT_EQ(packed.headers.at("content-encoding"), "gzip");
    EXPECT_EQ(packed.headers.at("vary"), plain.headers.at("vary"));
    EXPECT_NE(packed.headers.at("etag"), plain.headers.at("etag"));
    EXPECT_LT(packed.body.size(), plain.file_length);
    std::ifstream file(plain.file->path, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    EXPECT_EQ(*proto::gunzip(packed.body, bytes.size()), bytes);
    const std::string tag = packed.headers.at("etag");
    EXPECT_EQ(get(url, {{"accept-encoding", "gzip"}, {"if-none-match", tag}}).status, 304);
    const Response range = get(url, {{"accept-encoding", "gzip"}, {"range", "bytes=0-3"}});
    EXPECT_EQ(range.status, 206);
    EXPECT_FALSE(range.headers.contains("content-encoding"));
    EXPECT_EQ(get(url, {{"range", "bytes=0-3"}, {"if-range", tag}}).status, 200);
}

TEST_F(ReadyService, ContentComesInRanges) {
    const std::string url = content_url();
    const std::uint64_t size = get(url).file_length;
    const Response part = get(url, {{"range", "bytes=4-7"}});
    EXPECT_EQ(part.status, 206);
    EXPECT_EQ(part.file_offset, 4u);
    EXPECT_EQ(part.file_length, 4u);
    EXPECT_EQ(part.headers.at("content-range"), "bytes 4-7/" + std::to_string(size));
    const Response behind = get(url, {{"range", "bytes=" + std::to_string(size) + "-"}});
    expect_problem(behind, 416, std::to_string(size));
    EXPECT_EQ(behind.headers.at("content-range"), "bytes */" + std::to_string(size));
    EXPECT_EQ(get(url, {{"range", "bytes=0-1,4-5"}}).status, 200);
    const std::string etag = get(url).headers.at("etag");
    EXPECT_EQ(get(url, {{"range", "bytes=0-1"}, {"if-range", etag}}).status, 206);
    EXPECT_EQ(get(url, {{"range", "bytes=0-1"}, {"if-range", "\"other\""}}).status, 200);
    EXPECT_EQ(get(url, {{"range", "bytes=0-1"}, {"if-range", "W/" + etag}}).status, 200);
    EXPECT_EQ(get(url, {{"range", "bytes=0-1"}, {"if-range", "Tue, 15 Nov 1994 12:45:26 GMT"}}).status, 200);
    EXPECT_EQ(harness().call("HEAD", url, {}, {{"range", "bytes=0-1"}}).status, 200);
}

TEST_F(ReadyService, ContentIsNothingButHashes) {
    for (const char* path :
         {"/v1/content/x.glb", "/v1/content/../../etc/passwd.glb", "/v1/content/.glb", "/v1/content/",
          "/v1/content/0000000000000000000000000000000000000000000000000000000000000000.glb"})
        expect_problem(get(path), 404, "");
    std::string url = content_url();
    expect_problem(get(url.substr(0, url.size() - 4) + ".bin"), 404, "");
}

TEST_F(ReadyService, TilesetListsTheLadder) {
    const Response response = get("/v1/assets/teapot/tileset.json");
    ASSERT_EQ(response.status, 200) << response.body;
    const json asset = json_of(get("/v1/assets/teapot"));
    EXPECT_EQ(json_of(response)["root"]["content"]["uri"], asset["levels"].back()["url"]);
    expect_problem(get("/v1/assets/nobody/tileset.json"), 404, "nobody");
}

// A chain of tiles, two below each but the last, in place of those that a bake has made.
bake::TileTree tall_tree(std::uint32_t tiles) {
    bake::TileTree tree;
    for (std::uint32_t i = 0; i < tiles; ++i) {
        scene::LodNode& node = tree.nodes.emplace_back();
        node.box = {Vec3d(0.0), Vec3d(1.0)};
        node.error = static_cast<double>(tiles - i);
        if (i > 0) node.parent = (i - 1) / 2;
        if (2 * i + 2 < tiles) {
            node.first_child = 2 * i + 1;
            node.child_count = 2;
        }
        tree.hashes.push_back(std::string(64, static_cast<char>('0' + i % 10)));
        tree.bytes.push_back(1);
    }
    return tree;
}

TEST(Tilesets, OfManyTilesAreServedInDocuments) {
    Harness harness;
    harness.bake("ship", "sample:ship:3");
    const auto put = [&](std::uint32_t tiles) {
        ASSERT_TRUE(harness.store.put_content("ship", bake::tiles_key, "tiles", serialize(tall_tree(tiles))).ok());
    };
    put(2'001);
    const std::string path = "/v1/assets/ship/tileset.json";
    const auto root = proto::parse_tileset(harness.get(path).body);
    ASSERT_TRUE(root.ok()) << root.error().message;
    std::size_t tiles = root->nodes.size(), documents = 0;
    for (const std::string& address : root->documents) {
        if (address.empty()) continue;
        ASSERT_THAT(address, StartsWith(path + "?tile="));
        const std::string id = address.substr(path.size() + 6, address.find('&') - path.size() - 6);
        const Response response = harness.call("GET", path, {}, {}, {{"tile", id}, {"version", "1"}});
        ASSERT_EQ(response.status, 200) << response.body;
        EXPECT_EQ(response.headers.at("cache-control"), "no-cache");
        tiles += proto::parse_document(response.body, Mat4d(1.0))->nodes.size() - 1;
        ++documents;
    }
    EXPECT_GT(documents, 3u);
    EXPECT_EQ(tiles, 2'001u);
    const auto ask = [&](std::map<std::string, std::string> query) {
        return harness.call("GET", path, {}, {}, std::move(query));
    };
    expect_problem(ask({{"tile", "2001"}}), 404, "no tile 2001");
    expect_problem(ask({{"tile", "-1"}}), 400, "tile must be");
    expect_problem(ask({{"tile", "1"}, {"after", "0"}}), 400, "after is of the whole");
    put(2'003);  // not what was told before
    EXPECT_EQ(ask({{"tile", "2002"}}).status, 200);
    put(3);
    EXPECT_TRUE(proto::parse_tileset(harness.get(path).body)->documents.empty());
    expect_problem(ask({{"tile", "1"}}), 404, "no tile 1");
}

TEST_F(ReadyService, ServesItsPageAndItsDescription) {
    const Response page = get("/");
    EXPECT_THAT(page.headers.at("content-type"), StartsWith("text/html"));
    EXPECT_THAT(page.headers.at("content-security-policy"), HasSubstr("default-src 'none'"));
    EXPECT_THAT(page.body, StartsWith("<!doctype html>"));
    EXPECT_THAT(page.body, HasSubstr("fetch(\"v1/assets\")"));
    EXPECT_EQ(json_of(get("/openapi.json"))["openapi"], "3.1.0");
}

TEST_F(ReadyService, AnswersWhatOpenApiSaysItAnswers) {
    const json paths = json_of(get("/openapi.json"))["paths"];
    const std::string hash = content_url().substr(12, 64);
    for (const auto& [path, item] : paths.items())
        for (const char* method : {"get", "head", "post", "patch", "delete"}) {
            std::string concrete = path;
            if (const auto at = concrete.find("{id}"); at != std::string::npos) concrete.replace(at, 4, "teapot");
            if (const auto at = concrete.find("{hash}"); at != std::string::npos) concrete.replace(at, 6, hash);
            std::string upper = method;
            for (char& c : upper) c = static_cast<char>(std::toupper(c));
            if (upper == "DELETE" && item.contains("delete")) continue;  // the asset is shared
            const int status = harness().call(upper, concrete).status;
            if (item.contains(method)) {
                EXPECT_TRUE(item[method]["responses"].contains(std::to_string(status)))
                    << upper << ' ' << path << ' ' << status;
            } else if (upper == "HEAD" && item.contains("get")) {
                EXPECT_EQ(status, harness().call("GET", concrete).status) << path;
            } else {
                EXPECT_EQ(status, 405) << upper << ' ' << path;
            }
        }
}

TEST_F(ReadyService, SaysWhichMethodsAPathHas) {
    const Response response = harness().call("PATCH", "/v1/assets/teapot");
    expect_problem(response, 405, "PATCH");
    EXPECT_EQ(response.headers.at("allow"), "DELETE, GET, HEAD, OPTIONS");
    EXPECT_EQ(harness().call("GET", "/v1/plans").headers.at("allow"), "OPTIONS, POST");
    expect_problem(get("/v2"), 404, "/v2");
    expect_problem(get("/v1/assets/"), 404, "");
    expect_problem(get("/v1/assets/a/b"), 404, "");
    expect_problem(get(""), 404, "");
}

TEST_F(ReadyService, LetsOtherOriginsReadAndPlan) {
    EXPECT_EQ(get("/v1/assets").headers.at("access-control-allow-origin"), "*");
    EXPECT_EQ(plan(plan_body).headers.at("access-control-allow-origin"), "*");
    EXPECT_EQ(plan("{").headers.at("access-control-allow-origin"), "*");
    EXPECT_THAT(get(content_url()).headers.at("access-control-expose-headers"), HasSubstr("ETag"));
    const Response preflight = harness().call("OPTIONS", "/v1/plans", {}, {{"origin", "http://viewer.example"}});
    EXPECT_EQ(preflight.status, 204);
    EXPECT_EQ(preflight.headers.at("access-control-allow-origin"), "*");
    EXPECT_THAT(preflight.headers.at("access-control-allow-methods"), HasSubstr("POST"));
    EXPECT_THAT(preflight.headers.at("access-control-allow-headers"), HasSubstr("Content-Type"));
    EXPECT_EQ(harness().call("OPTIONS", "*").status, 204);
    EXPECT_EQ(harness().call("OPTIONS", "/nowhere").status, 404);
}

TEST_F(ReadyService, DoesNotLetOtherOriginsChangeAssets) {
    const Response preflight = harness().call("OPTIONS", "/v1/assets");
    EXPECT_EQ(preflight.headers.at("access-control-allow-methods").find("POST"), std::string::npos);
    const std::map<std::string, std::string> foreign{{"origin", "http://evil.example"}, {"host", "127.0.0.1:8080"}};
    expect_problem(harness().call("DELETE", "/v1/assets/teapot", {}, foreign), 403, "origin");
    expect_problem(harness().call("POST", "/v1/assets", off_tetrahedron(), foreign, {{"name", "x"}}), 403, "origin");
    expect_problem(harness().call("DELETE", "/v1/assets/teapot", {}, {{"origin", "null"}, {"host", "h"}}), 403,
                   "origin");
    const std::map<std::string, std::string> own{{"origin", "http://LocalHost:8080"}, {"host", "localhost:8080"}};
    expect_problem(harness().call("DELETE", "/v1/assets/nobody", {}, own), 404, "nobody");
}

TEST(Service, CountsWhatItDoesUnderBoundedLabels) {
    Harness harness;
    harness.bake("teapot");
    harness.get("/livez");
    harness.call("HEAD", "/v1/assets");
    harness.call("BREW", "/coffee");
    harness.get("/secret/path/of/someone");
    harness.call("POST", "/v1/plans", plan_body);
    static_cast<void>(harness.service.refuse(431, "too long"));
    static_cast<void>(harness.service.refuse_early({"GET", "/nothing", {}, {}, {}}));
    const Response response = harness.get("/metrics");
    EXPECT_THAT(response.headers.at("content-type"), StartsWith("text/plain; version=0.0.4"));
    for (const char* line : {"lodestream_http_requests_total{method=\"GET\",route=\"/livez\",status=\"200\"} 1\n",
                             "lodestream_http_requests_total{method=\"GET\",route=\"none\",status=\"404\"} 2\n",
                             "lodestream_http_requests_total{method=\"other\",route=\"none\",status=\"404\"} 1\n",
                             "lodestream_http_requests_total{method=\"other\",route=\"none\",status=\"431\"} 1\n",
                             "lodestream_http_response_bytes_total{route=\"/v1/assets\"} 0\n",
                             "lodestream_plans_total{limited_by=\"device\"} 1\n",
                             "lodestream_bakes_total{result=\"ready\"} 1\n", "lodestream_assets{status=\"ready\"} 1\n"})
        EXPECT_THAT(response.body, HasSubstr(line));
    EXPECT_EQ(response.body.find("secret"), std::string::npos);
}

TEST(Service, UploadsBakesAndRemoves) {
    Harness harness;
    const Response created = harness.call("POST", "/v1/assets", obj_field(12), {}, {{"name", "My Field.obj"}});
    ASSERT_EQ(created.status, 202) << created.body;
    EXPECT_EQ(created.headers.at("location"), "/v1/assets/my-field.obj");
    EXPECT_EQ(json_of(created)["status"], "baking");
    EXPECT_EQ(json_of(created)["name"], "My Field.obj");
    EXPECT_EQ(json_of(created)["triangles"], 288);
    EXPECT_FALSE(created.headers.contains("access-control-allow-origin"));
    harness.bakes.wait_until_idle();
    const json asset = json_of(harness.get("/v1/assets/My Field.obj"));
    EXPECT_EQ(asset["id"], "my-field.obj");
    EXPECT_EQ(asset["status"], "ready") << asset;
    const std::string url = asset["levels"][0]["url"];
    EXPECT_EQ(harness.get(url).status, 200);

    EXPECT_EQ(harness.call("DELETE", "/v1/assets/my-field.obj").status, 204);
    expect_problem(harness.get("/v1/assets/my-field.obj"), 404, "");
    expect_problem(harness.get(url), 404, "");
    expect_problem(harness.call("DELETE", "/v1/assets/my-field.obj"), 404, "");
    EXPECT_EQ(harness.call("POST", "/v1/plans", R"({"asset":"my-field.obj","device":{"cpu_mhz":9}})").status, 404);
}

TEST(Service, KeepsNothingOfBadUploads) {
    Harness harness;
    const auto upload = [&](const std::string& body, std::map<std::string, std::string> headers = {},
                            std::map<std::string, std::string> query = {{"name", "x"}}) {
        return harness.call("POST", "/v1/assets", body, std::move(headers), std::move(query));
    };
    expect_problem(upload("", {}), 422, "empty");
    expect_problem(upload("this is no model at all"), 415, "");
    expect_problem(upload("OFF\n4 4 0\n0 0 0\n1 0"), 422, "");
    expect_problem(upload(off_tetrahedron(), {}, {}), 400, "name");
    expect_problem(upload(off_tetrahedron(), {}, {{"name", ""}}), 422, "name");
    expect_problem(upload(off_tetrahedron(), {}, {{"name", std::string(500, 'n')}}), 422, "name");
    expect_problem(upload(off_tetrahedron(), {{"content-type", "multipart/form-data; boundary=x"}}), 415, "form");
    EXPECT_EQ(json_of(harness.get("/v1/assets"))["assets"].size(), 0u);
    EXPECT_TRUE(std::filesystem::is_empty(harness.folder.path() / "store" / "incoming"));
}

TEST(Service, TakesANameOnce) {
    Harness harness;
    harness.bake("teapot");
    expect_problem(harness.call("POST", "/v1/assets", off_tetrahedron(), {}, {{"name", "teapot"}}), 409, "teapot");
    expect_problem(harness.call("POST", "/v1/assets", off_tetrahedron(), {}, {{"name", "TEAPOT"}}), 409, "teapot");
    EXPECT_EQ(json_of(harness.get("/v1/assets/teapot"))["triangles"], 512);
}

TEST(Service, AFailedAssetMayBeSentAgain) {
    Harness harness;
    proto::Asset failed;
    failed.id = failed.name = "x";
    failed.kind = "mesh";
    failed.status = proto::AssetStatus::failed;
    failed.error = "lightning";
    ASSERT_TRUE(harness.store.put_asset(failed));
    ASSERT_TRUE(harness.store.put_content("x", "level/old", "glb", {}));
    expect_problem(harness.call("POST", "/v1/plans", R"({"asset":"x","device":{"cpu_mhz":9}})"), 409, "lightning");
    expect_problem(harness.get("/v1/assets/x/tileset.json"), 409, "lightning");
    EXPECT_EQ(harness.call("POST", "/v1/assets", off_tetrahedron(), {}, {{"name", "x"}}).status, 202);
    harness.bakes.wait_until_idle();
    EXPECT_EQ(json_of(harness.get("/v1/assets/x"))["status"], "ready");
    EXPECT_FALSE(harness.store.content("x", "level/old"));
}

TEST(Service, AnAssetThatBakesIsNotAvailableYet) {
    Harness harness;
    proto::Asset baking;
    baking.id = baking.name = "x";
    baking.kind = "mesh";
    ASSERT_TRUE(harness.store.put_asset(baking));
    for (const Response& response : {harness.call("POST", "/v1/plans", R"({"asset":"x","device":{"cpu_mhz":9}})"),
                                     harness.get("/v1/assets/x/tileset.json")}) {
        expect_problem(response, 503, "baking");
        EXPECT_EQ(response.headers.at("retry-after"), "1");
    }
}

TEST(Service, NeedsItsTokenForChanges) {
    Harness harness({"s3cret"});
    const auto status = [&](const std::string& method, const std::string& authorization) {
        return harness
            .call(method, method == "POST" ? "/v1/assets" : "/v1/assets/nobody", "x",
                  {{"authorization", authorization}}, {{"name", "x"}})
            .status;
    };
    for (const char* wrong :
         {"", "Bearer", "Bearer ", "Bearer s3cre", "Bearer s3crets", "Basic s3cret", "s3cret", "Bearer S3CRET"}) {
        EXPECT_EQ(status("POST", wrong), 401) << wrong;
        EXPECT_EQ(status("DELETE", wrong), 401) << wrong;
    }
    EXPECT_EQ(status("POST", "Bearer s3cret"), 415);
    EXPECT_EQ(status("DELETE", "bearer  s3cret"), 404);
    EXPECT_EQ(harness.call("POST", "/v1/assets").headers.at("www-authenticate"), "Bearer");
    EXPECT_EQ(harness.get("/v1/assets").status, 200);
    const std::map<std::string, std::string> cross{
        {"origin", "http://tool.example"}, {"host", "h"}, {"authorization", "Bearer s3cret"}};
    EXPECT_EQ(harness.call("DELETE", "/v1/assets/nobody", {}, cross).status, 404);
}

TEST(Service, RefusesFromTheHeaderWhatNeedsNoBody) {
    Harness harness({"s3cret"});
    EXPECT_EQ(harness.service.refuse_early({"POST", "/v1/assets", {{"name", "x"}}, {}, {}})->status, 401);
    EXPECT_EQ(harness.service.refuse_early({"POST", "/nowhere", {}, {}, {}})->status, 404);
    EXPECT_EQ(harness.service.refuse_early({"PUT", "/v1/plans", {}, {}, {}})->status, 405);
    EXPECT_FALSE(harness.service.refuse_early({"POST", "/v1/plans", {}, {}, {}}));
    EXPECT_FALSE(harness.service.refuse_early(
        {"POST", "/v1/assets", {{"name", "x"}}, {{"authorization", "Bearer s3cret"}}, {}}));
}

TEST(Service, RemovingCancelsTheBake) {
    Harness harness;
    ASSERT_EQ(harness.bakes.submit("big", std::filesystem::path("sample:terrain:60000"))->status,
              proto::AssetStatus::baking);
    ASSERT_TRUE(harness.bakes.submit("next", std::filesystem::path("sample:terrain:10000")));
    EXPECT_EQ(harness.call("DELETE", "/v1/assets/next").status, 204);
    EXPECT_EQ(harness.call("DELETE", "/v1/assets/big").status, 204);
    harness.bakes.wait_until_idle();
    EXPECT_EQ(json_of(harness.get("/v1/assets"))["assets"].size(), 0u);
    EXPECT_EQ(harness.bakes.counts().cancelled, 2u);
    EXPECT_EQ(harness.bake("big").status, proto::AssetStatus::ready);
}

TEST(BakeQueue, TellsProgressThatRises) {
    Harness harness;
    ASSERT_TRUE(harness.bakes.submit("field", std::filesystem::path("sample:terrain:15000")));
    std::set<double> seen;
    double last = 0.0;
    for (;;) {
        const json asset = json_of(harness.get("/v1/assets/field"));
        if (asset["status"] != "baking") break;
        const double progress = asset["progress"];
        if (progress > 0.0 && progress < 1.0) seen.insert(progress);
        EXPECT_GE(progress, 0.0);
        EXPECT_LE(progress, 1.0);
        last = std::max(last, progress);
    }
    EXPECT_GE(seen.size(), 2u);
    EXPECT_EQ(json_of(harness.get("/v1/assets/field"))["progress"], 1.0);
}

TEST(BakeQueue, AStopLeavesBakesThatTheNextStartGoesOnWith) {
    testing::TemporaryFolder folder;
    {
        store::Store store = open_store(folder.path() / "store");
        planner::Planner planner(store);
        BakeQueue bakes(store, planner);
        ASSERT_TRUE(bakes.submit("a", std::filesystem::path("sample:terrain:40000")));
        for (const char* name : {"b", "c"}) ASSERT_TRUE(bakes.submit(name, std::filesystem::path("sample:teapot:512")));
    }
    store::Store store = open_store(folder.path() / "store");
    const auto assets = store.assets();
    ASSERT_EQ(assets->size(), 3u);
    for (const proto::Asset& asset : *assets) EXPECT_NE(asset.status, proto::AssetStatus::failed) << asset.error;
    EXPECT_EQ(store.asset("a")->status, proto::AssetStatus::baking);
    planner::Planner planner(store);
    BakeQueue bakes(store, planner);
    bakes.wait_until_idle();
    for (const char* id : {"a", "b", "c"}) EXPECT_EQ(store.asset(id)->status, proto::AssetStatus::ready) << id;
}

TEST(BakeQueue, WaitingAssetsHaveFirstLevels) {
    Harness harness;
    ASSERT_TRUE(harness.bakes.submit("first", std::filesystem::path("sample:terrain:40000")));
    ASSERT_TRUE(harness.bakes.submit("second", std::filesystem::path("sample:terrain:30000")));
    const Response plan = harness.call("POST", "/v1/plans", R"({"asset":"second","device":{"cpu_mhz":300}})");
    ASSERT_EQ(plan.status, 200) << plan.body;
    EXPECT_EQ(plan.headers.at("cache-control"), "no-store");
    EXPECT_THAT(json_of(plan)["warnings"][0].get<std::string>(), HasSubstr("a first level"));
    EXPECT_EQ(harness.get(json_of(plan)["content"]["url"]).file_length, json_of(plan)["content"]["bytes"]);
    EXPECT_EQ(json_of(harness.get("/v1/assets/second"))["levels"].size(), 3u);
    expect_problem(harness.get("/v1/assets/second/tileset.json"), 503, "baking");
}

TEST(BakeQueue, RefusesWhatNeedsMoreMemoryThanItMay) {
    testing::TemporaryFolder folder;
    store::Store store = open_store(folder.path() / "store");
    planner::Planner planner(store);
    bake::Limits limits;
    limits.max_memory_bytes = 1'000'000;
    BakeQueue bakes(store, planner, limits);
    const auto refused = bakes.submit("a", std::filesystem::path("sample:terrain:40000"));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::limit_exceeded);
    EXPECT_TRUE(store.assets()->empty());
    EXPECT_TRUE(bakes.submit("b", std::filesystem::path("sample:teapot:512")));
}

TEST(BakeQueue, OriginIsKeptWithTheAsset) {
    Harness harness;
    ASSERT_TRUE(harness.bakes.submit("a", std::filesystem::path("sample:teapot:512"), "from there"));
    EXPECT_EQ(harness.store.content("a", BakeQueue::origin_key)->record, "from there");
}

TEST(BakeQueue, OneNameIsSubmittedOnceHoweverManyTry) {
    Harness harness;
    std::vector<std::future<bool>> tries;
    for (int i = 0; i < 8; ++i)
        tries.push_back(std::async(std::launch::async, [&] {
            return harness.bakes.submit("same", std::filesystem::path("sample:teapot:512")).ok();
        }));
    int accepted = 0;
    for (auto& attempt : tries) accepted += attempt.get();
    EXPECT_EQ(accepted, 1);
    harness.bakes.wait_until_idle();
    EXPECT_EQ(harness.store.asset("same")->status, proto::AssetStatus::ready);
}

TEST(BakeQueue, ImportsFilesAndSaysWhyItCannot) {
    Harness harness;
    const auto file = harness.folder.path() / "t.off";
    std::ofstream(file) << off_tetrahedron();
    EXPECT_TRUE(harness.bakes.submit("t", file));
    EXPECT_EQ(harness.bakes.submit("u", harness.folder.path() / "missing.off").error().code, ErrorCode::not_found);
    EXPECT_FALSE(harness.bakes.submit("v", std::filesystem::path("sample:cube")));
    harness.bakes.wait_until_idle();
    EXPECT_EQ(harness.store.asset("t")->triangles, 4u);
    EXPECT_EQ(harness.store.assets()->size(), 1u);
}

}  // namespace
}  // namespace lodestream::http
