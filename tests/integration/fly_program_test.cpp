// `lodestream-client fly` and `probe` as programs: against a served teapot, from the command line to the files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "proto/messages.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace lodestream {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

struct Ended {
    int code = -1;
    std::string output;  // both streams
};

Ended run(const std::string& command) {
    std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
    if (pipe == nullptr) return {};
    Ended ended;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) ended.output += static_cast<char>(c);
    const int status = ::pclose(pipe);
    ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return ended;
}

// A store of one small teapot.
std::string baked_teapot(const testing::TemporaryFolder& folder) {
    const std::string store = (folder.path() / "store").string();
    const Ended baked = run(LODESTREAM_SERVER " bake sample:teapot:800 --store " + store);
    EXPECT_EQ(baked.code, 0) << baked.output;
    return store;
}

std::vector<std::string> lines_of(const fs::path& file) {
    std::ifstream in(file);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

std::vector<double> numbers_of(const std::string& row) {
    std::istringstream in(row);
    std::vector<double> numbers;
    for (std::string cell; std::getline(in, cell, ',');) numbers.push_back(std::stod(cell));
    return numbers;
}

TEST(FlyProgram, WritesARowAndAPictureAFrame) {
    const testing::TemporaryFolder folder;
    const testing::ServerProgram server(LODESTREAM_SERVER, baked_teapot(folder));
    const fs::path motion = folder.path() / "motion.csv", out = folder.path() / "flight.csv";
    std::ofstream(motion) << "t_s,x,y,z,yaw_deg,pitch_deg\n0,,,,0,0\n0.2,,,,20,5\n0.4,0,1,5,0,-10\n";
    const Ended flown = run(LODESTREAM_CLIENT " fly --server " + server.url + " --asset teapot --motion " +
                            motion.string() + " --controller isblc --target-fps 20 --width 64 --height 48 --out " +
                            out.string() + " --frames " + (folder.path() / "frames").string());
    ASSERT_EQ(flown.code, 0) << flown.output;
    const std::vector<std::string> lines = lines_of(out);
    ASSERT_GE(lines.size(), 3u);
    EXPECT_EQ(lines[0], "t_s,frame_ms,level,triangles,speed_deg_s,error_px,switched");
    for (std::size_t i = 1; i < lines.size(); ++i) {
        const std::vector<double> row = numbers_of(lines[i]);
        ASSERT_EQ(row.size(), 7u) << lines[i];
        EXPECT_GT(row[1], 0.0);
        EXPECT_LE(row[3], 800.0);
        EXPECT_TRUE(row[6] == 0.0 || row[6] == 1.0);
    }
    const auto pictures = std::distance(fs::directory_iterator(folder.path() / "frames"), fs::directory_iterator());
    EXPECT_EQ(static_cast<std::size_t>(pictures), lines.size() - 1);
}

TEST(FlyProgram, KeepsToAPlanWhereADeviceIsGiven) {
    const testing::TemporaryFolder folder;
    const testing::ServerProgram server(LODESTREAM_SERVER, baked_teapot(folder));
    const fs::path device = folder.path() / "device.json", out = folder.path() / "flight.csv";
    std::ofstream(device) << R"({"device":{"cpu_mhz":70},"preference":{"triangles":200}})";
    const std::string common = LODESTREAM_CLIENT " fly --server " + server.url +
                               " --asset teapot --motion builtin:nod --width 320 --height 240 --out " + out.string();
    const Ended flown = run(common + " --device " + device.string());
    ASSERT_EQ(flown.code, 0) << flown.output;
    EXPECT_THAT(flown.output, HasSubstr("plans asked for: "));  // a slow machine gets less than the user's 200
    const std::vector<std::string> lines = lines_of(out);
    for (std::size_t i = 1; i < lines.size(); ++i) EXPECT_LE(numbers_of(lines[i])[3], 200.0) << lines[i];

    std::ofstream(device) << R"({"device":{"cpu_mhz":-1}})";
    const Ended refused = run(common + " --device " + device.string());
    EXPECT_EQ(refused.code, 1);
    EXPECT_THAT(refused.output, HasSubstr("device.json: device.cpu_mhz"));
}

// One level, fetched once: the border alone moves while the viewer goes away, and the picture changes within the bound.
TEST(FlyProgram, MovesTheBorderBetweenGouraudAndFlatWithTheDistance) {
    const testing::TemporaryFolder folder;
    const testing::ServerProgram server(LODESTREAM_SERVER, baked_teapot(folder));
    const fs::path motion = folder.path() / "away.csv", out = folder.path() / "flight.csv";
    std::ofstream(motion) << "0,0,0,2,0,0\n2,0,0,30,0,0\n";
    const Ended flown = run(LODESTREAM_CLIENT " fly --server " + server.url + " --asset teapot --motion " +
                            motion.string() + " --controller none --shading hybrid --split-bound 6 --target-fps 30 " +
                            "--width 160 --height 120 --out " + out.string());
    ASSERT_EQ(flown.code, 0) << flown.output;
    EXPECT_THAT(flown.output, HasSubstr("border between Gouraud and flat: moved in "));
    const std::vector<std::string> lines = lines_of(out);
    ASSERT_GE(lines.size(), 20u);
    EXPECT_EQ(lines[0],
              "t_s,frame_ms,level,triangles,speed_deg_s,error_px,switched,"
              "gouraud_triangles,split_bound_steps,split_change_steps");
    double largest_change = 0.0;
    for (std::size_t i = 1; i < lines.size(); ++i) {
        const std::vector<double> row = numbers_of(lines[i]);
        ASSERT_EQ(row.size(), 10u) << lines[i];
        EXPECT_EQ(row[2], 0.0);
        EXPECT_EQ(row[6], 0.0);
        EXPECT_LE(row[9], row[8]) << lines[i];
        largest_change = std::max(largest_change, row[9]);
    }
    EXPECT_LT(numbers_of(lines.back())[7], 0.8 * numbers_of(lines[1])[7]);
    EXPECT_GT(largest_change, 0.0);
}

TEST(FlyProgram, SaysWhatIsWrongInOneLine) {
    const testing::TemporaryFolder folder;
    const testing::ServerProgram server(LODESTREAM_SERVER, baked_teapot(folder));
    const std::string common = LODESTREAM_CLIENT " fly --server " + server.url + " --out " +
                               (folder.path() / "x.csv").string() + " --width 64 --height 48 ";
    const Ended no_asset = run(common + "--asset kettle --motion builtin:nod");
    EXPECT_EQ(no_asset.code, 1);
    EXPECT_THAT(no_asset.output, HasSubstr("no asset \"kettle\""));
    const Ended no_motion = run(common + "--asset teapot --motion builtin:dance");
    EXPECT_EQ(no_motion.code, 1);
    EXPECT_THAT(no_motion.output, HasSubstr("no built-in motion \"dance\""));
    const Ended no_controller = run(common + "--asset teapot --motion builtin:nod --controller best");
    EXPECT_EQ(no_controller.code, 2);
}

TEST(ProbeProgram, PrintsADeviceFile) {
    const Ended probed = run(LODESTREAM_CLIENT " probe --json");
    ASSERT_EQ(probed.code, 0) << probed.output;
    const auto request = proto::parse_device_file(probed.output);
    ASSERT_TRUE(request) << request.error().message << "\n" << probed.output;
    EXPECT_GT(*request->budget.device.triangles_per_second, 0.0);
}

}  // namespace
}  // namespace lodestream
