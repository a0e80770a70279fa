// Real meshes from ../shared/data, read by a loader of a few lines: only plain OFF files.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>

#include "common/metric/surface_distance.h"
#include "common/simplify/history.h"
#include "tests/common/simplify/shapes.h"

namespace lodestream::simplify {
namespace {

mesh::Mesh read_off(const std::filesystem::path& path) {
    std::ifstream in(path);
    std::string word;
    std::size_t vertices = 0, faces = 0, edges = 0;
    const auto skip_comments = [&] {
        while ((in >> std::ws).peek() == '#') std::getline(in, word);
    };
    skip_comments();
    in >> word;
    skip_comments();
    in >> vertices >> faces >> edges;
    skip_comments();
    mesh::Mesh m;
    for (std::size_t v = 0; v < vertices; ++v) {
        Vec3f p{0.0f};
        in >> p.x >> p.y >> p.z;
        m.positions.push_back(p);
    }
    skip_comments();
    for (std::size_t f = 0; f < faces; ++f) {
        std::size_t corners = 0;
        in >> corners;
        std::vector<std::uint32_t> polygon(corners);
        for (std::uint32_t& v : polygon) in >> v;
        for (std::size_t k = 2; k < corners; ++k) m.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
        std::getline(in, word);
    }
    return mesh::compact(m);
}

struct Expected {
    const char* file;
    double rms_percent;       // at a tenth of the triangles
    double rms_percent_at_1;  // at a hundredth
};

class RealModel : public ::testing::TestWithParam<Expected> {};

TEST_P(RealModel, IsCutWithinTheExpectedError) {
    LODESTREAM_NEED_SHARED_DATA();
    const Expected& expected = GetParam();
    const mesh::Mesh m = read_off(testing::shared_data() / expected.file);
    ASSERT_FALSE(m.triangles.empty());
    const std::size_t n = m.triangles.size();

    const auto start = std::chrono::steady_clock::now();
    const Result<History> history = record_history(m);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    ASSERT_TRUE(history.ok());
    EXPECT_TRUE(validate(view(*history)).ok());

    const metric::SurfaceIndex index(m);
    const double diagonal = mesh::bounds(m).diagonal();
    const auto rms_percent = [&](std::size_t budget) {
        const mesh::Mesh level = cut(*history, budget);
        EXPECT_LE(level.triangles.size(), budget);
        EXPECT_GE(level.triangles.size() + 1, budget);
        return 100 * metric::measure(index, m, level).rms / diagonal;
    };
    const double at_10 = rms_percent(n / 10), at_1 = rms_percent(n / 100);
    std::printf("%s: %zu triangles, %.0f ktri/s, RMS %.4f %% at 10 %%, %.4f %% at 1 %%\n", expected.file, n,
                static_cast<double>(n) / took.count(), at_10, at_1);
    EXPECT_LE(at_10, expected.rms_percent);
    EXPECT_LE(at_1, expected.rms_percent_at_1);
}

INSTANTIATE_TEST_SUITE_P(Models, RealModel,
                         ::testing::Values(Expected{"classic/bunny_7k.off", 0.16, 1.2},
                                           Expected{"classic/armadillo_52k.off", 0.055, 0.3},
                                           Expected{"hard/elephant_with_holes.off", 0.6, 7},
                                           Expected{"hard/cheese_genus.off", 0.65, 6},
                                           Expected{"hard/bones_26comp.off", 0.4, 4},
                                           Expected{"hard/blobby_shuffled_orientation.off", 0.1, 0.8},
                                           Expected{"hard/boeing_soup.off", 0.25, 8}));

}  // namespace
}  // namespace lodestream::simplify
