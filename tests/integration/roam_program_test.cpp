// `lodestream-client roam` as a program: through served scenes, from the command line to the files, over real sockets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "client/sdk/client.h"
#include "common/base/transform.h"
#include "common/image/codec.h"
#include "tests/support/meshes.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace lodestream {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Json = nlohmann::json;

struct Ended {
    int code = -1;
    std::string output, errors;
};

Ended run(const std::string& command, const fs::path& folder) {
    const fs::path errors = folder / "errors.txt";
    std::FILE* pipe = ::popen((command + " 2>" + errors.string()).c_str(), "r");
    if (pipe == nullptr) return {};
    Ended ended;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) ended.output += static_cast<char>(c);
    const int status = ::pclose(pipe);
    ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    std::ifstream in(errors);
    ended.errors.assign(std::istreambuf_iterator<char>(in), {});
    return ended;
}

void write_cloud(const fs::path& file, const mesh::Mesh& mesh) {
    std::ofstream out(file);
    out << "ply\nformat ascii 1.0\nelement vertex " << mesh.positions.size()
        << "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n"
           "property float nz\nend_header\n";
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vec3f &p = mesh.positions[i], &n = mesh.normals[i];
        out << p.x << ' ' << p.y << ' ' << p.z << ' ' << n.x << ' ' << n.y << ' ' << n.z << '\n';
    }
}

image::Pixels read_picture(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    Result<image::Pixels> pixels = image::decode(std::as_bytes(std::span(text)));
    EXPECT_TRUE(pixels) << file;
    return pixels ? *std::move(pixels) : image::Pixels{};
}

// Rows by the names of their columns.
std::vector<std::map<std::string, double>> read_csv(const fs::path& file) {
    std::ifstream in(file);
    std::string line, cell;
    std::getline(in, line);
    std::vector<std::string> names;
    for (std::istringstream head(line); std::getline(head, cell, ',');) names.push_back(cell);
    std::vector<std::map<std::string, double>> rows;
    while (std::getline(in, line)) {
        std::map<std::string, double> row;
        std::istringstream cells(line);
        for (const std::string& name : names) {
            std::getline(cells, cell, ',');
            row[name] = std::stod(cell);
        }
        rows.push_back(row);
    }
    return rows;
}

class RoamProgram : public ::testing::Test {
  protected:
    std::string bake(const std::string& input) {
        const std::string store = (folder.path() / "store").string();
        const Ended baked = run(LODESTREAM_SERVER " bake " + input + " --store " + store, folder.path());
        EXPECT_EQ(baked.code, 0) << baked.errors;
        return store;
    }
    Ended roam(const std::string& url, const std::string& more) {
        return run(LODESTREAM_CLIENT " roam --server " + url + " --out " + out.string() + " --json " +
                       (more.find("--width") == std::string::npos ? "--width 96 --height 72 " : "") + more,
                   folder.path());
    }

    // Its tileset as the server writes it to files.
    Json tileset_of(const std::string& store) {
        const fs::path tiles = folder.path() / "tiles";
        const Ended listed =
            run(LODESTREAM_SERVER " tileset --store " + store + " --asset ship --out " + tiles.string(), folder.path());
        EXPECT_EQ(listed.code, 0) << listed.errors;
        std::ifstream in(tiles / "tileset.json");
        return Json::parse(in);
    }
    // From five lengths away to half a one and back, in three seconds.
    std::string there_and_back(const Json& tileset) {
        const auto box = tileset["root"]["boundingVolume"]["box"].get<std::vector<double>>();  // z upwards
        const double x = box[0], y = box[2], z = -box[1], length = 2.0 * box[3];
        const fs::path file = folder.path() / "motion.csv";
        std::ofstream motion(file);
        for (const auto& [t_s, lengths] : {std::pair{0.0, 5.0}, {1.5, 0.5}, {3.0, 5.0}})
            motion << t_s << ',' << x << ',' << y << ',' << z + lengths * length << ",0,0\n";
        return " --motion " + file.string() + " ";
    }

    const testing::TemporaryFolder folder;
    const fs::path out = folder.path() / "tour.csv";
};

TEST_F(RoamProgram, StreamsTheShipAndWritesARowAndAPictureAFrame) {
    const testing::ServerProgram server(LODESTREAM_SERVER, bake("sample:ship:30"));
    const fs::path frames = folder.path() / "frames";
    const Ended ended = roam(server.url, "--asset ship --fps 10 --tolerance-px 1 --frames " + frames.string());
    ASSERT_EQ(ended.code, 0) << ended.errors;
    EXPECT_EQ(ended.errors, "");
    const Json told = Json::parse(ended.output);
    const auto rows = read_csv(out);
    EXPECT_EQ(rows.size(), 121u);
    EXPECT_EQ(told["frames"], rows.size());
    const auto pictures = std::distance(fs::directory_iterator(frames), fs::directory_iterator());
    EXPECT_EQ(static_cast<std::size_t>(pictures), rows.size());
    double fading = 0.0, popping = 0.0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        EXPECT_EQ(rows[i].at("frame"), static_cast<double>(i));
        EXPECT_NEAR(rows[i].at("t_s"), 0.1 * static_cast<double>(i), 1e-6);
        EXPECT_LE(rows[i].at("gpu_bytes"), 256.0 * (1 << 20));
        fading += rows[i].at("fading_tiles");
        popping = std::max(popping, rows[i].at("pop_largest"));
    }
    EXPECT_GT(fading, 0.0);
    EXPECT_EQ(told["popping"]["largest"], popping);
    EXPECT_GT(told["fetched_tiles"], 2);
    EXPECT_EQ(told["failed_tiles"], 0);
    EXPECT_EQ(told["fetched_bytes"], rows.back().at("fetched_bytes"));
    EXPECT_GT(rows[60].at("triangles"), rows[2].at("triangles")) << "it refines as it comes near";
    EXPECT_EQ(rows[60].at("missing_tiles"), 0.0);
    EXPECT_EQ(rows[60].at("missed_px"), 0.0);
}

TEST_F(RoamProgram, KeepsToItsMemoryAtTheCostOfError) {
    const std::string store = bake("sample:ship:30");
    const testing::ServerProgram server(LODESTREAM_SERVER, store);
    const std::string common = "--asset ship --fps 10 --tolerance-px 0.5" + there_and_back(tileset_of(store));
    const Ended enough = roam(server.url, common), small = roam(server.url, common + "--memory-mb 0.3");
    ASSERT_EQ(enough.code + small.code, 0) << enough.errors << small.errors;
    const Json with_enough = Json::parse(enough.output), with_little = Json::parse(small.output);
    EXPECT_GT(with_enough["gpu_bytes_peak"], 0.3 * (1 << 20));
    EXPECT_LE(with_little["gpu_bytes_peak"], 0.3 * (1 << 20));
    EXPECT_GT(with_little["gpu_bytes_peak"], 0);
    EXPECT_GT(with_little["missed_px"], with_enough["missed_px"]);
}

TEST_F(RoamProgram, StreamsARealSceneOfManyObjectsAlongAMotion) {
    LODESTREAM_NEED_SHARED_DATA();
    const testing::ServerProgram server(LODESTREAM_SERVER,
                                        bake((testing::shared_data() / "scene" / "boolean_28nodes.glb").string()));
    const fs::path motion = folder.path() / "motion.csv";
    std::ofstream(motion) << "t_s,x,y,z,yaw_deg,pitch_deg\n0,0,1,20,0,0\n1,0,1,4,0,0\n2,0,1,40,0,0\n";
    const Ended ended =
        roam(server.url, "--asset boolean_28nodes --fps 15 --rtt-ms 60 --downlink-mbps 5 --motion " + motion.string());
    ASSERT_EQ(ended.code, 0) << ended.errors;
    const auto rows = read_csv(out);
    ASSERT_EQ(rows.size(), 31u);
    EXPECT_EQ(rows[0].at("tiles"), 0.0) << "nothing comes before the round trip";
    EXPECT_GT(rows.back().at("tiles"), 0.0);
    EXPECT_GE(Json::parse(ended.output)["first_picture_s"], 0.06);
}

// As tiles that came over the wire, and as one level of all its points.
TEST_F(RoamProgram, DrawsACloudAsItsPointsInOneLevelAre) {
    const fs::path cloud = folder.path() / "cloud.ply", motion = folder.path() / "still.csv";
    write_cloud(cloud, testing::sphere(250));  // 124,500 points
    std::ofstream(motion) << "t_s,x,y,z,yaw_deg,pitch_deg\n0,0,0,2.2,0,0\n1,0,0,2.2,0,0\n";
    const testing::ServerProgram server(LODESTREAM_SERVER, bake(cloud.string()));
    const fs::path frames = folder.path() / "frames", device = folder.path() / "device.json";
    const Ended ended = roam(server.url,
                             "--asset cloud --fps 10 --tolerance-px 0.1 --fov 45 --width 320 --height 240 "
                             "--motion " +
                                 motion.string() + " --frames " + frames.string());
    ASSERT_EQ(ended.code, 0) << ended.errors;
    const auto last = read_csv(out).back();
    EXPECT_EQ(last.at("missing_tiles"), 0.0);
    EXPECT_GT(last.at("tiles"), 4.0);
    EXPECT_EQ(last.at("triangles"), 0.0);
    EXPECT_GT(last.at("points"), 16'384.0) << "more than the root's";

    std::ofstream(device) << R"({"device":{"cpu_mhz":1e9,"points_per_second":1e12},"display":{"width":320,"height":240},
        "view":{"eye":[0,0,2.2],"target":[0,0,0],"fov_y_deg":45}})";
    const fs::path whole = folder.path() / "whole.png";
    const Ended viewed = run(LODESTREAM_CLIENT " view --server " + server.url + " --asset cloud --primitives points " +
                                 "--device " + device.string() + " --out " + whole.string(),
                             folder.path());
    ASSERT_EQ(viewed.code, 0) << viewed.errors;
    std::vector<fs::path> pictures;
    for (const auto& entry : fs::directory_iterator(frames)) pictures.push_back(entry.path());
    const image::Pixels expected = read_picture(whole), drawn = read_picture(*std::ranges::max_element(pictures));
    ASSERT_EQ(expected.rgba.size(), drawn.rgba.size());
    double squares = 0.0;
    std::size_t covered = 0, missing = 0;
    for (std::size_t i = 0; i < expected.rgba.size(); i += 4) {
        const int off = int{expected.rgba[i + 1]} - drawn.rgba[i + 1];
        const bool is_covered = expected.rgba[i + 1] != 255, is_drawn = drawn.rgba[i + 1] != 255;
        squares += off * off;
        covered += is_covered;
        missing += is_covered != is_drawn;
    }
    EXPECT_GT(covered, 20'000u);
    EXPECT_LT(missing, covered / 100) << "of the outline alone";
    EXPECT_LT(std::sqrt(squares / static_cast<double>(covered)), 4.0) << "steps of 255";
}

TEST_F(RoamProgram, WithoutAFadeLevelsPop) {
    const std::string store = bake("sample:ship:30");
    const testing::ServerProgram server(LODESTREAM_SERVER, store);
    const std::string common =
        "--asset ship --fps 30 --tolerance-px 1 --width 240 --height 180" + there_and_back(tileset_of(store));
    const Ended fading = roam(server.url, common), popping = roam(server.url, common + "--fade-ms 0");
    ASSERT_EQ(fading.code + popping.code, 0) << fading.errors << popping.errors;
    EXPECT_LT(Json::parse(fading.output)["popping"]["p999"].get<double>(),
              0.7 * Json::parse(popping.output)["popping"]["p999"].get<double>());
    for (const auto& row : read_csv(out)) EXPECT_EQ(row.at("fading_tiles"), 0.0);
}

TEST_F(RoamProgram, ATileThatIsDamagedIsCoveredByTheLevelAboveAndSaid) {
    const std::string store = bake("sample:ship:30");
    const Json tileset = tileset_of(store);
    const std::string common = "--asset ship --fps 10 --tolerance-px 0.1" + there_and_back(tileset);
    {
        const testing::ServerProgram server(LODESTREAM_SERVER, store);
        ASSERT_EQ(roam(server.url, common).code, 0);
        EXPECT_EQ(read_csv(out)[15].at("missed_px"), 0.0);
    }
    // All but the root's file, which its size tells, lose their middle.
    const auto root_bytes = tileset["root"]["extras"]["bytes"].get<std::uintmax_t>();
    std::size_t damaged = 0;
    for (const auto& entry : fs::recursive_directory_iterator(store)) {
        if (entry.path().extension() != ".glb" || entry.file_size() == root_bytes) continue;
        std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(static_cast<std::streamoff>(entry.file_size() / 2));
        file << std::string(std::min<std::size_t>(entry.file_size() / 4, 512), 'x');
        ++damaged;
    }
    ASSERT_GT(damaged, 0u);
    const testing::ServerProgram server(LODESTREAM_SERVER, store);
    const Ended ended = roam(server.url, common);
    ASSERT_EQ(ended.code, 0) << ended.errors;
    EXPECT_THAT(ended.errors, HasSubstr("covered by the level above: /v1/content/"));
    EXPECT_GT(Json::parse(ended.output)["failed_tiles"], 0);
    EXPECT_EQ(read_csv(out)[15].at("tiles"), 1.0);
    EXPECT_GT(read_csv(out)[15].at("missed_px"), 0.0);
}

// A still camera before the ship; half of the time in, a quarter of its containers is hidden, then they come back.
TEST_F(RoamProgram, FollowsASceneThatChangesAndFetchesOnlyWhatHas) {
    const std::string store = bake("sample:ship:60");
    const testing::ServerProgram server(LODESTREAM_SERVER, store);
    const Json tileset = tileset_of(store);
    const auto box = tileset["root"]["boundingVolume"]["box"].get<std::vector<double>>();  // z upwards
    const fs::path motion = folder.path() / "still.csv", frames = folder.path() / "frames";
    std::ofstream(motion) << 0 << ',' << box[0] << ',' << box[2] << ',' << -box[1] + 3.0 * box[3] << ",0,0\n"
                          << 6 << ',' << box[0] << ',' << box[2] << ',' << -box[1] + 3.0 * box[3] << ",0,0\n";
    std::thread change([&] {
        auto client = sdk::Client::open(server.url);
        ASSERT_TRUE(client);
        std::vector<proto::NodeChange> hidden, shown;
        for (std::uint32_t node = 46; node <= 60; ++node) {
            hidden.push_back({node, std::nullopt, false});
            shown.push_back({node, std::nullopt, true});
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2'000));
        EXPECT_TRUE(client->change_nodes("ship", hidden));
        std::this_thread::sleep_for(std::chrono::milliseconds(2'000));
        EXPECT_TRUE(client->change_nodes("ship", shown));
    });
    const Ended ended = roam(server.url, "--asset ship --fps 10 --tolerance-px 0.5 --motion " + motion.string() +
                                             " --frames " + frames.string());
    change.join();
    ASSERT_EQ(ended.code, 0) << ended.errors;
    const auto rows = read_csv(out);
    ASSERT_EQ(rows.size(), 61u);
    const Json told = Json::parse(ended.output);
    EXPECT_GE(told["revisions"], 2);
    EXPECT_EQ(told["failed_tiles"], 0);
    EXPECT_EQ(rows[38].at("missing_tiles") + rows[38].at("outdated_tiles"), 0.0);
    const auto picture = [&](int frame) {
        char name[16];
        std::snprintf(name, sizeof name, "%06d.png", frame);
        std::ifstream in(frames / name, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    EXPECT_NE(picture(18), picture(38)) << "with and without the containers";
    EXPECT_FALSE(picture(18).empty());
}

// A scene of more tiles than one document tells; some time on, an object moves.
TEST_F(RoamProgram, ReadsTheDocumentsThatItsViewNeedsAndFollowsWhatChangesInThem) {
    const testing::ServerProgram server(LODESTREAM_SERVER, bake("sample:fine-ship:500"));
    auto client = sdk::Client::open(server.url);
    ASSERT_TRUE(client);
    const auto root = client->root_document("fine-ship"), whole = client->tileset("fine-ship");
    ASSERT_TRUE(root && whole);
    ASSERT_GT(whole->nodes.size(), proto::max_document_tiles);
    ASSERT_LT(root->nodes.size(), whole->nodes.size() / 2);
    const Box& box = whole->nodes.front().box;
    const fs::path motion = folder.path() / "near.csv";
    std::ofstream file(motion);
    for (const double t_s : {0.0, 8.0})
        file << t_s << ',' << box.center().x << ',' << box.center().y << ',' << box.center().z + 0.7 * box.extent().x
             << ",0,0\n";
    file.close();
    std::thread change([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(3'000));
        EXPECT_TRUE(client->change_nodes("fine-ship", {{400, translation({0, 5, 0}), std::nullopt}}));
    });
    const Ended ended = roam(server.url, "--asset fine-ship --fps 10 --tolerance-px 0.02 --motion " + motion.string());
    change.join();
    ASSERT_EQ(ended.code, 0) << ended.errors;
    const Json told = Json::parse(ended.output);
    EXPECT_EQ(told["failed_tiles"], 0);
    EXPECT_GE(told["revisions"], 2) << "documents, and the change";
    const auto rows = read_csv(out);
    EXPECT_GT(rows.back().at("tiles"), static_cast<double>(root->nodes.size())) << "tiles of other documents";
    EXPECT_EQ(rows.back().at("missing_tiles") + rows.back().at("outdated_tiles"), 0.0);
    const auto now = client->tileset("fine-ship");
    ASSERT_TRUE(now);
    const auto moved = std::ranges::find(now->scene_nodes, 400u);
    ASSERT_NE(moved, now->scene_nodes.end());
    EXPECT_GT(now->revision, 0u);
}

TEST_F(RoamProgram, SaysWhatIsWrongInOneLine) {
    const testing::ServerProgram server(LODESTREAM_SERVER, bake("sample:teapot:800"));
    const Ended no_asset = roam(server.url, "--asset kettle");
    EXPECT_EQ(no_asset.code, 1);
    EXPECT_THAT(no_asset.errors, HasSubstr("no asset \"kettle\""));
    EXPECT_EQ(std::count(no_asset.errors.begin(), no_asset.errors.end(), '\n'), 1);
    const Ended no_motion = roam(server.url, "--asset teapot --motion builtin:dance");
    EXPECT_EQ(no_motion.code, 1);
    EXPECT_THAT(no_motion.errors, HasSubstr("no built-in motion \"dance\""));
    for (const char* wrong : {"--fps 0", "--tolerance-px -1", "--fade-ms x", "--memory-mb nan"})
        EXPECT_EQ(roam(server.url, std::string("--asset teapot ") + wrong).code, 2) << wrong;
}

}  // namespace
}  // namespace lodestream
