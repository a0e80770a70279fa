// A service over a fresh store, as the tests of this folder use it.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "server/http/service.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::http {

inline store::Store open_store(const std::filesystem::path& folder) {
    auto store = store::Store::open(folder);
    if (!store) throw std::runtime_error(store.error().message);
    return std::move(*store);
}

struct Harness {
    explicit Harness(ServiceOptions options = {}) : service(store, planner, bakes, scenes, std::move(options)) {}

    testing::TemporaryFolder folder;
    store::Store store = open_store(folder.path() / "store");
    planner::Planner planner{store};
    BakeQueue bakes{store, planner};
    live::LiveScenes scenes{store};
    Service service;

    // A small asset, baked.
    proto::Asset bake(const std::string& name, const std::string& sample = "sample:teapot:512") {
        auto asset = bakes.submit(name, std::filesystem::path(sample));
        if (!asset) throw std::runtime_error(asset.error().message);
        bakes.wait_until_idle();
        return store.asset(asset->id).value();
    }

    Response call(const std::string& method, const std::string& path, const std::string& body = {},
                  std::map<std::string, std::string> headers = {}, std::map<std::string, std::string> query = {}) {
        const auto* bytes = reinterpret_cast<const std::byte*>(body.data());
        return service.handle({method, path, std::move(query), std::move(headers), {bytes, bytes + body.size()}});
    }
    Response get(const std::string& path, std::map<std::string, std::string> headers = {}) {
        return call("GET", path, {}, std::move(headers));
    }
};

inline nlohmann::json json_of(const Response& response) {
    return nlohmann::json::parse(response.body);
}

inline void expect_problem(const Response& response, int status, const std::string& words) {
    EXPECT_EQ(response.status, status) << response.body;
    ASSERT_TRUE(response.headers.contains("content-type"));
    EXPECT_EQ(response.headers.at("content-type"), "application/problem+json");
    const auto problem = json_of(response);
    EXPECT_EQ(problem["status"], status);
    for (const char* member : {"type", "title", "detail"}) EXPECT_TRUE(problem[member].is_string()) << member;
    EXPECT_NE(problem["detail"].get<std::string>().find(words), std::string::npos) << problem["detail"];
}

// A tetrahedron as OFF and a quad field of n×n as OBJ.
inline std::string off_tetrahedron() {
    return "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
}
inline std::string obj_field(int n) {
    std::string text;
    for (int z = 0; z <= n; ++z)
        for (int x = 0; x <= n; ++x)
            text += "v " + std::to_string(x) + " " + std::to_string((x * 7 + z * 13) % 5 * 0.1) + " " +
                    std::to_string(z) + "\n";
    for (int z = 0; z < n; ++z)
        for (int x = 0; x < n; ++x) {
            const int a = z * (n + 1) + x + 1;
            text += "f " + std::to_string(a) + " " + std::to_string(a + n + 1) + " " + std::to_string(a + n + 2) + " " +
                    std::to_string(a + 1) + "\n";
        }
    return text;
}

}  // namespace lodestream::http
