// The real lodestream-server program over a real socket and a real store.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "proto/messages.h"
#include "tests/server/http/raw_client.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace lodestream {
namespace {

namespace fs = std::filesystem;
using http::RawClient;
using http::RawResponse;
using nlohmann::json;
using ::testing::HasSubstr;

constexpr auto patience = std::chrono::seconds(240);  // for a small bake on a slow machine under a sanitizer

class Program : public testing::Program {
  public:
    explicit Program(std::vector<std::string> arguments) : testing::Program(LODESTREAM_SERVER, std::move(arguments)) {}
};

class Server : public testing::ServerProgram {
  public:
    explicit Server(const fs::path& store, const std::vector<std::string>& more = {})
        : ServerProgram(LODESTREAM_SERVER, store.string(), more),
          port(static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)))) {}

    RawResponse call(const std::string& method, const std::string& target, const std::string& body = {},
                     const std::string& fields = {}) {
        RawClient client(port);
        client.send(method + " " + target + " HTTP/1.1\r\nHost: test\r\n" + fields +
                    "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
        return client.receive();
    }
    json get(const std::string& target) { return json::parse(call("GET", target).body); }

    // Polls until the asset leaves `baking`.
    json wait_for(const std::string& id) {
        const auto deadline = std::chrono::steady_clock::now() + patience;
        json asset = get("/v1/assets/" + id);
        while (asset.value("status", "") == "baking" && std::chrono::steady_clock::now() < deadline) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            asset = get("/v1/assets/" + id);
        }
        return asset;
    }

    const std::uint16_t port;
};

// A field of n×n quads with hills, as OBJ.
std::string field(int n) {
    std::string text;
    for (int z = 0; z <= n; ++z)
        for (int x = 0; x <= n; ++x)
            text += "v " + std::to_string(x) + " " + std::to_string((x * 7 + z * 13) % 11 * 0.05) + " " +
                    std::to_string(z) + "\n";
    for (int z = 0; z < n; ++z)
        for (int x = 0; x < n; ++x) {
            const int a = z * (n + 1) + x + 1;
            text += "f " + std::to_string(a) + " " + std::to_string(a + n + 1) + " " + std::to_string(a + n + 2) + " " +
                    std::to_string(a + 1) + "\n";
        }
    return text;
}

std::string plan_for(const std::string& asset, double cpu_mhz) {
    return R"({"asset":")" + asset + R"(","device":{"cpu_mhz":)" + std::to_string(cpu_mhz) + "}}";
}

TEST(ServerProgram, ServesAModelFromUploadToRemoval) {
    testing::TemporaryFolder folder;
    Server server(folder.path() / "store");
    EXPECT_EQ(server.call("GET", "/readyz").status, 200);

    const RawResponse created = server.call("POST", "/v1/assets?name=field", field(40));
    ASSERT_EQ(created.status, 202) << created.body;
    EXPECT_EQ(created.headers.at("location"), "/v1/assets/field");
    const json asset = server.wait_for("field");
    ASSERT_EQ(asset["status"], "ready") << asset;
    EXPECT_EQ(asset["triangles"], 3200);
    EXPECT_EQ(asset["levels"][0]["triangles"], 3200);
    for (std::size_t i = 1; i < asset["levels"].size(); ++i)
        EXPECT_LT(asset["levels"][i]["triangles"], asset["levels"][i - 1]["triangles"]);

    const RawResponse answer = server.call("POST", "/v1/plans", plan_for("field", 300));
    ASSERT_EQ(answer.status, 200) << answer.body;
    const auto plan = proto::parse_plan_response(answer.body);
    ASSERT_TRUE(plan) << plan.error().message;
    EXPECT_EQ(plan->budget.limited_by, "device");
    EXPECT_LE(plan->level.triangles, plan->budget.triangles);
    EXPECT_EQ(plan->shading.gouraud + plan->shading.flat, plan->level.triangles);

    const RawResponse level = server.call("GET", plan->content.url);
    EXPECT_EQ(level.status, 200);
    EXPECT_EQ(level.body.size(), plan->content.bytes);
    EXPECT_EQ(level.body.substr(0, 4), "glTF");
    EXPECT_EQ(server.call("GET", plan->content.url, {}, "If-None-Match: " + level.headers.at("etag") + "\r\n").status,
              304);
    EXPECT_EQ(server.call("GET", plan->content.url, {}, "Range: bytes=0-3\r\n").body, "glTF");
    EXPECT_EQ(json::parse(server.call("POST", "/v1/plans", plan_for("field", 300)).body)["content"]["url"],
              plan->content.url);
    EXPECT_EQ(server.get("/v1/assets/field/tileset.json")["root"]["content"]["uri"], asset["levels"].back()["url"]);
    EXPECT_THAT(server.call("GET", "/metrics").body, HasSubstr("lodestream_plans_total{limited_by=\"device\"} 2\n"));

    EXPECT_EQ(server.call("DELETE", "/v1/assets/field").status, 204);
    EXPECT_EQ(server.call("GET", plan->content.url).status, 404);
    EXPECT_EQ(server.get("/v1/assets")["assets"].size(), 0u);
    server.signal(SIGTERM);
    EXPECT_EQ(server.wait(), 0);
}

TEST(ServerProgram, KeepsItsAssetsAcrossARestart) {
    testing::TemporaryFolder folder;
    std::string url;
    {
        Server server(folder.path() / "store");
        ASSERT_EQ(server.call("POST", "/v1/assets?name=field", field(12)).status, 202);
        url = server.wait_for("field")["levels"][0]["url"];
        server.signal(SIGINT);
        EXPECT_EQ(server.wait(), 0);
    }
    Server server(folder.path() / "store");
    EXPECT_EQ(server.get("/v1/assets/field")["status"], "ready");
    EXPECT_EQ(server.call("GET", url).status, 200);
    EXPECT_EQ(server.call("POST", "/v1/plans", plan_for("field", 50)).status, 200);
}

// The killed process's bake has begun when it tells progress.
void wait_for_progress(Server& server, const std::string& id) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (std::chrono::steady_clock::now() < deadline) {
        const json asset = server.get("/v1/assets/" + id);
        if (asset["status"] != "baking" || asset["progress"] > 0.0) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

void kill_while_baking(Server& server, const std::string& id) {
    wait_for_progress(server, id);
    ASSERT_EQ(server.get("/v1/assets/" + id)["status"], "baking");
    server.signal(SIGKILL);
    EXPECT_EQ(server.wait(), -SIGKILL);
}

TEST(ServerProgram, GoesOnWithABakeAfterAKill) {
    testing::TemporaryFolder folder;
    const fs::path store = folder.path() / "store";
    {
        Server server(store);
        ASSERT_EQ(server.call("POST", "/v1/assets?name=field", field(300)).status, 202);
        kill_while_baking(server, "field");
    }
    Server server(store);
    EXPECT_TRUE(fs::is_empty(store / "incoming"));
    EXPECT_EQ(server.call("POST", "/v1/plans", plan_for("field", 300)).status, 200);  // first levels are still there
    const json asset = server.wait_for("field");
    ASSERT_EQ(asset["status"], "ready") << asset;
    EXPECT_EQ(asset["triangles"], 180000);
    for (const json& level : asset["levels"]) EXPECT_EQ(server.call("GET", level["url"]).body.size(), level["bytes"]);
}

TEST(ServerProgram, ABakeThatEndsTheProgramTwiceIsGivenUp) {
    testing::TemporaryFolder folder;
    const fs::path store = folder.path() / "store";
    {
        Server server(store);
        ASSERT_EQ(server.call("POST", "/v1/assets?name=field", field(300)).status, 202);
        kill_while_baking(server, "field");
    }
    {
        Server server(store);
        kill_while_baking(server, "field");
    }
    Server server(store);
    EXPECT_EQ(server.get("/v1/assets/field")["status"], "failed");
    EXPECT_THAT(server.get("/v1/assets/field")["error"].get<std::string>(), HasSubstr("ended the program 2 times"));
    ASSERT_EQ(server.call("POST", "/v1/assets?name=field", field(12)).status, 202);
    EXPECT_EQ(server.wait_for("field")["status"], "ready");
}

TEST(ServerProgram, GoesOnAfterAStopInTheMiddleOfABake) {
    testing::TemporaryFolder folder;
    for (int stops = 0; stops < 3; ++stops) {
        Server server(folder.path() / "store");
        if (stops == 0) {
            ASSERT_EQ(server.call("POST", "/v1/assets?name=field", field(300)).status, 202);
        }
        wait_for_progress(server, "field");
        server.signal(SIGTERM);
        EXPECT_EQ(server.wait(), 0);
    }
    Server server(folder.path() / "store");
    EXPECT_EQ(server.wait_for("field")["status"], "ready");
}

TEST(ServerProgram, TheCommandGoesOnWithWhatAServerLeft) {
    testing::TemporaryFolder folder;
    const std::string store = (folder.path() / "store").string();
    {
        Server server(store);
        ASSERT_EQ(server.call("POST", "/v1/assets?name=field", field(300)).status, 202);
        kill_while_baking(server, "field");
    }
    Program bake({"bake", "--resume", "--store", store, "--json"});
    EXPECT_EQ(json::parse(bake.read_line())["asset"], "field");
    EXPECT_EQ(bake.wait(), 0);
    Program nothing({"bake", "--store", store});
    EXPECT_EQ(nothing.wait(), 2);
}

TEST(ServerProgram, CtrlCCancelsABake) {
    testing::TemporaryFolder folder;
    const std::string store = (folder.path() / "store").string();
    Program bake({"bake", "sample:terrain:200000", "sample:teapot", "--store", store});
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    bake.signal(SIGINT);
    EXPECT_EQ(bake.read_line(), "");
    EXPECT_EQ(bake.wait(), 1);
    Server server(store);
    const json answer = server.get("/v1/assets");
    for (const json& asset : answer["assets"]) EXPECT_EQ(asset["status"], "failed");
}

// Polls until the server has `count` assets, however they are.
std::vector<std::string> names_of(Server& server, std::size_t count) {
    std::vector<std::string> names;
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (names.size() < count && std::chrono::steady_clock::now() < deadline) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        names.clear();
        const json assets = server.get("/v1/assets");
        for (const json& asset : assets.at("assets")) names.push_back(asset.at("name"));
    }
    return names;
}

TEST(ServerProgram, FilesOfOneNameInSubFoldersAreAssetsOfTheirOwn) {
    testing::TemporaryFolder folder;
    const fs::path models = folder.path() / "models";
    for (const char* name : {"field.obj", "a/field.obj", "b/field.obj", "b/Field.obj"}) {
        fs::create_directories((models / name).parent_path());
        std::ofstream(models / name) << field(4);
    }
    std::ofstream(models / "upload.obj") << field(3);
    {
        Server server(folder.path() / "store");
        EXPECT_EQ(server.call("POST", "/v1/assets?name=upload", field(5)).status, 202);
        server.wait_for("upload");
    }
    const std::vector<std::string> expected{"Field.obj", "b-field.obj", "field", "field.obj-2", "upload", "upload.obj"};
    for (int start = 0; start < 2; ++start) {  // a restart gives the same names
        Server server(folder.path() / "store", {"--assets", models.string()});
        EXPECT_THAT(names_of(server, expected.size()), ::testing::UnorderedElementsAreArray(expected)) << start;
        EXPECT_EQ(server.wait_for("upload").at("triangles"), 50);
        EXPECT_EQ(server.wait_for("upload.obj").at("triangles"), 18);
        server.signal(SIGTERM);
        EXPECT_EQ(server.wait(), 0);
    }
}

TEST(ServerProgram, AsksForItsToken) {
    testing::TemporaryFolder folder;
    std::ofstream(folder.path() / "token") << "s3cret\n";
    Server server(folder.path() / "store", {"--token-file", (folder.path() / "token").string()});
    EXPECT_EQ(server.call("POST", "/v1/assets?name=field", field(4)).status, 401);
    EXPECT_EQ(server.call("POST", "/v1/assets?name=field", field(4), "Authorization: Bearer s3cret\r\n").status, 202);
}

TEST(ServerProgram, BakesBesideARunningServer) {
    testing::TemporaryFolder folder;
    const fs::path store = folder.path() / "store";
    std::ofstream(folder.path() / "field.obj") << field(12);
    Server server(store);
    Program bake({"bake", (folder.path() / "field.obj").string(), "--store", store.string(), "--json"});
    const json record = json::parse(bake.read_line());
    EXPECT_EQ(bake.wait(), 0);
    EXPECT_EQ(record["asset"], "field");
    const json asset = server.get("/v1/assets/field");
    EXPECT_EQ(asset["status"], "ready");
    EXPECT_EQ(server.call("GET", asset["levels"][0]["url"]).status, 200);
    EXPECT_EQ(server.call("POST", "/v1/plans", plan_for("field", 50)).status, 200);
}

TEST(ServerProgram, SaysInOneLineWhyItCannotServe) {
    testing::TemporaryFolder folder;
    Server server(folder.path() / "store");
    Program second({"serve", "--listen", "127.0.0.1:" + std::to_string(server.port), "--store",
                    (folder.path() / "other").string()});
    EXPECT_EQ(second.read_line(), "");
    EXPECT_EQ(second.wait(), 1);
    std::ofstream(folder.path() / "file") << "x";
    Program third({"serve", "--store", (folder.path() / "file").string()});
    EXPECT_EQ(third.wait(), 1);
    Program fourth({"serve"});
    EXPECT_EQ(fourth.wait(), 2);
}

}  // namespace
}  // namespace lodestream
