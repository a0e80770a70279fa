#include "client/report/server_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <iterator>

namespace lodestream::report {
namespace {

namespace fs = std::filesystem;

// A stand-in for the server: a shell script in a folder of its own.
class ServerProcessTest : public ::testing::Test {
  protected:
    void SetUp() override {
        std::string pattern = (fs::temp_directory_path() / "server-process-test-XXXXXX").string();
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        folder = pattern;
    }
    void TearDown() override { fs::remove_all(folder); }

    fs::path script(const std::string& body) const {
        const fs::path path = folder / "server";
        std::ofstream(path) << "#!/bin/sh\n" << body;
        fs::permissions(path, fs::perms::owner_all);
        return path;
    }

    fs::path folder;
};

TEST(ServerAddress, IsReadOnlyFromAWholeLine) {
    EXPECT_EQ(find_address("listening on http://127.0.0.1:80"), "");
    EXPECT_EQ(find_address("listening on http://127.0.0.1:8081\n"), "http://127.0.0.1:8081");
    EXPECT_EQ(find_address("a warning\nlistening on http://127.0.0.1:9\nmore\n"), "http://127.0.0.1:9");
    EXPECT_EQ(find_address("not listening on anything\n"), "");
}

TEST_F(ServerProcessTest, IsStoppedAndItsStoreRemovedAtTheEnd) {
    const fs::path facts = folder / "facts";
    const fs::path program =
        script("echo \"$$ $5\" > " + facts.string() +
               "\nmkdir \"$5\"\necho listening on http://127.0.0.1:1\nwhile :; do sleep 0.05; done\n");
    pid_t pid = 0;
    std::string store;
    {
        auto server = ServerProcess::start(program, std::nullopt);
        ASSERT_TRUE(server.ok()) << server.error().message;
        EXPECT_EQ(server->url(), "http://127.0.0.1:1");
        std::ifstream(facts) >> pid >> store;
        ASSERT_GT(pid, 0);
        EXPECT_EQ(kill(pid, 0), 0);
        EXPECT_TRUE(fs::exists(store));
    }
    EXPECT_EQ(kill(pid, 0), -1);
    EXPECT_FALSE(fs::exists(store));
}

TEST_F(ServerProcessTest, HandsOnTheAssetsFolder) {
    const fs::path facts = folder / "facts";
    const fs::path program =
        script("echo \"$@\" > " + facts.string() + "\necho listening on http://127.0.0.1:1\nexec sleep 60\n");
    const auto server = ServerProcess::start(program, fs::path("/some/models"));
    ASSERT_TRUE(server.ok());
    std::ifstream file(facts);
    const std::string arguments{std::istreambuf_iterator<char>(file), {}};
    EXPECT_THAT(arguments, ::testing::StartsWith("serve --listen 127.0.0.1:0 --store "));
    EXPECT_THAT(arguments, ::testing::HasSubstr(" --samples --assets /some/models"));
}

TEST_F(ServerProcessTest, AServerThatEndsAtOnceIsAnErrorWithItsLastLine) {
    const auto server = ServerProcess::start(script("echo first >&2\necho no such folder >&2\nexit 1\n"), std::nullopt);
    ASSERT_FALSE(server.ok());
    EXPECT_EQ(server.error().code, ErrorCode::unavailable);
    EXPECT_THAT(server.error().message, ::testing::EndsWith("no such folder"));
}

TEST_F(ServerProcessTest, AMissingProgramIsNotFound) {
    const auto server = ServerProcess::start(folder / "nothing", std::nullopt);
    ASSERT_FALSE(server.ok());
    EXPECT_EQ(server.error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace lodestream::report
