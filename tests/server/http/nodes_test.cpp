// The nodes of a scene through the service, and a client that waits for a newer tileset.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <thread>

#include "server/http/http_server.h"
#include "tests/server/http/harness.h"
#include "tests/server/http/raw_client.h"

namespace lodestream::http {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

constexpr const char* nodes_path = "/v1/assets/ship/nodes";
constexpr const char* tileset_path = "/v1/assets/ship/tileset.json";

std::string lifting(int node, double by) {
    return R"({"nodes":[{"node":)" + std::to_string(node) + R"(,"translation":[0,)" + std::to_string(by) + ",0]}]}";
}

// The ship is baked once for all that only look at answers, by a harness that ends before the program does.
struct NodesTest : ::testing::Test {
    static Harness& harness() {
        if (!shared) {
            shared = std::make_unique<Harness>();
            shared->bake("ship", "sample:ship:30");
            shared->bake("teapot");
        }
        return *shared;
    }
    static void TearDownTestSuite() { shared.reset(); }
    static inline std::unique_ptr<Harness> shared;
    static Response patch(const std::string& body, std::map<std::string, std::string> headers = {}) {
        return harness().call("PATCH", nodes_path, body, std::move(headers));
    }
    static json tileset() { return json_of(harness().get(tileset_path)); }
};

TEST_F(NodesTest, AreListedInPages) {
    const json all = json_of(harness().get(nodes_path));
    EXPECT_EQ(all["count"], 31);
    ASSERT_EQ(all["nodes"].size(), 31u);
    EXPECT_EQ(all["nodes"][0]["parent"], nullptr);
    EXPECT_EQ(all["nodes"][1]["parent"], 0);
    EXPECT_EQ(all["nodes"][1]["objects"], 1);
    const json page = json_of(harness().call("GET", nodes_path, {}, {}, {{"first", "29"}, {"count", "10"}}));
    ASSERT_EQ(page["nodes"].size(), 2u);
    EXPECT_EQ(page["nodes"][0]["node"], 29);
    expect_problem(harness().call("GET", nodes_path, {}, {}, {{"first", "-1"}}), 400, "first must be");
    expect_problem(harness().get("/v1/assets/kettle/nodes"), 404, "kettle");
    expect_problem(harness().get("/v1/assets/teapot/nodes"), 409, "it is one object");
}

TEST_F(NodesTest, AChangeIsInEveryTilesetAfterIt) {
    const Response changed = patch(lifting(5, 3.0));
    ASSERT_EQ(changed.status, 200) << changed.body;
    EXPECT_EQ(json_of(changed)["moved_objects"], 1);
    const json now = tileset();
    EXPECT_GE(std::stoull(now["asset"]["tilesetVersion"].get<std::string>()),
              json_of(changed)["revision"].get<std::uint64_t>());
    EXPECT_EQ(json_of(harness().get(nodes_path))["nodes"][5]["matrix"][13], 3.0);
    const Response plan = harness().call("POST", "/v1/plans", R"({"asset":"ship","device":{"cpu_mhz":300}})");
    EXPECT_THAT(plan.body, HasSubstr("1 of its objects have moved since"));
    ASSERT_EQ(patch(lifting(5, 0.0)).status, 200);
    EXPECT_EQ(json_of(patch(R"({"nodes":[{"node":5,"visible":true}]})"))["moved_objects"], 0);
    const Response still = harness().call("POST", "/v1/plans", R"({"asset":"ship","device":{"cpu_mhz":300}})");
    EXPECT_EQ(still.body.find("moved since"), std::string::npos);
}

TEST_F(NodesTest, WhatIsWrongIsToldAndChangesNothing) {
    const std::string before = tileset().dump();
    expect_problem(patch(""), 400, "JSON");
    expect_problem(patch(R"({"nodes":[{"node":1,"translation":[0,1]}]})"), 400, "nodes[0].translation");
    expect_problem(patch(R"({"nodes":[{"node":1,"scale":[0,0,0]}]})"), 400, "singular");
    expect_problem(patch(R"({"nodes":[{"node":99,"visible":false}]})"), 404, "no node 99");
    expect_problem(patch(R"({"nodes":[{"node":0,"visible":false}]})"), 409, "nothing of the scene");
    expect_problem(patch(lifting(1, 1.0), {{"content-type", "model/gltf-binary"}}), 415, "application/json");
    expect_problem(patch(lifting(1, 1.0), {{"origin", "http://evil.example"}, {"host", "127.0.0.1"}}), 403, "origin");
    expect_problem(harness().call("PATCH", "/v1/assets/teapot/nodes", lifting(1, 1.0)), 409, "it is one object");
    expect_problem(harness().call("PATCH", "/v1/assets/kettle/nodes", lifting(1, 1.0)), 404, "kettle");
    EXPECT_EQ(tileset().dump(), before);
}

TEST_F(NodesTest, NeedATokenWhereOneIsSet) {
    Harness guarded({"secret"});
    guarded.bake("ship", "sample:ship:3");
    expect_problem(guarded.call("PATCH", nodes_path, lifting(1, 1.0)), 401, "token");
    EXPECT_EQ(guarded.call("PATCH", nodes_path, lifting(1, 1.0), {{"authorization", "Bearer secret"}}).status, 200);
    EXPECT_EQ(guarded.get(nodes_path).status, 200);
}

TEST_F(NodesTest, GoWithTheirAsset) {
    Harness own;
    own.bake("ship", "sample:ship:3");
    ASSERT_EQ(own.call("PATCH", nodes_path, lifting(1, 1.0)).status, 200);
    ASSERT_EQ(own.call("DELETE", "/v1/assets/ship").status, 204);
    expect_problem(own.call("PATCH", nodes_path, lifting(1, 1.0)), 404, "ship");
    own.bake("ship", "sample:ship:3");
    EXPECT_FALSE(json_of(own.get(tileset_path))["asset"].contains("tilesetVersion")) << "as it was baked";
}

TEST_F(NodesTest, ATilesetThatIsNoNewerIsNotSent) {
    const auto after = [&](const std::string& text) {
        return harness().call("GET", tileset_path, {}, {}, {{"after", text}});
    };
    EXPECT_EQ(after("9000000000000000").status, 304);
    expect_problem(after("x"), 400, "after must be");
    expect_problem(after("99999999999999999999999"), 400, "after must be");
}

TEST_F(NodesTest, APollWaitsForTheChangeWithoutAThread) {
    ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.threads = 1;
    std::promise<std::uint16_t> bound;
    std::stop_source stop;
    auto done = std::async(std::launch::async, [&] {
        return serve(
                   harness().service, options, [&](std::uint16_t p) { bound.set_value(p); }, stop.get_token())
            .ok();
    });
    const std::uint16_t port = bound.get_future().get();
    const std::string revision =
        std::to_string(json_of(patch(lifting(2, 0.5)))["revision"].get<std::uint64_t>() + 1'000'000'000);
    std::vector<std::unique_ptr<RawClient>> pollers;
    for (int i = 0; i < 20; ++i) {
        pollers.push_back(std::make_unique<RawClient>(port));
        pollers.back()->send("GET /v1/assets/ship/tileset.json?after=" + revision + " HTTP/1.1\r\nHost: h\r\n\r\n");
    }
    RawClient other(port);
    const auto start = std::chrono::steady_clock::now();
    other.send("GET /livez HTTP/1.1\r\nHost: h\r\n\r\n");
    EXPECT_EQ(other.receive().status, 200) << "while twenty wait";
    EXPECT_LT(std::chrono::steady_clock::now() - start, 10s);
    stop.request_stop();  // ends what waits, with an answer
    for (const auto& poller : pollers) EXPECT_EQ(poller->receive().status, 304);
    EXPECT_TRUE(done.get());
}

}  // namespace
}  // namespace lodestream::http
