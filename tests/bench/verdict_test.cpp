#include "tests/bench/verdict.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lodestream::bench {
namespace {

MethodResult result_of(const std::string& method, double wall_ms, double rms, double image) {
    MethodResult result;
    result.method = method;
    for (LevelResult& level : result.levels) {
        level.reached = {wall_ms, wall_ms / 2};
        level.error = metric::SurfaceError{rms, 2 * rms};
        level.image = ImageError{image, 0.0};
    }
    return result;
}

ModelResult model_of(const std::string& name, double our_ms) {
    ModelResult model{name, 1000, 500, 1.0, {}, {}};
    model.methods = {result_of("ours", our_ms, 0.02, 3.0), result_of("meshopt", 10, 0.05, 6.0),
                     result_of("cgal", 500, 0.01, 4.0), result_of("openmesh", 400, 0.03, 5.0)};
    return model;
}

const Verdict& find(const std::vector<Verdict>& all, const std::string& what) {
    for (const Verdict& verdict : all)
        if (verdict.target.what == what) return verdict;
    throw std::runtime_error(what);
}

TEST(Verdicts, ASpeedIsThePeersTimeOverOurs) {
    const Verdict verdict = find(verdicts({model_of("a", 40)}), "speed: whole history / OpenMesh to 10 %");
    EXPECT_DOUBLE_EQ(verdict.values[0], 10.0);
    EXPECT_TRUE(verdict.holds());
}

TEST(Verdicts, HoldOnlyWhereTheyHoldOnEveryModel) {
    const Verdict verdict =
        find(verdicts({model_of("a", 40), model_of("b", 80)}), "speed: whole history / OpenMesh to 10 %");
    EXPECT_TRUE(verdict.holds(0));
    EXPECT_FALSE(verdict.holds(1));
    EXPECT_FALSE(verdict.holds());
}

TEST(Verdicts, AnErrorIsOursOverThePeers) {
    const std::vector<Verdict> all = verdicts({model_of("a", 40)});
    EXPECT_DOUBLE_EQ(find(all, "RMS at 10 % / CGAL").values[0], 2.0);
    EXPECT_FALSE(find(all, "RMS at 10 % / CGAL").holds());
    EXPECT_DOUBLE_EQ(find(all, "RMS at 1 % / meshopt").values[0], 0.4);
    EXPECT_TRUE(find(all, "RMS at 1 % / meshopt").holds());
}

TEST(Verdicts, AnImageIsHeldAgainstTheBestPeer) {
    const std::vector<Verdict> all = verdicts({model_of("a", 40)});
    EXPECT_DOUBLE_EQ(find(all, "image at 10 %, made normals / best peer").values[0], 0.75);
}

TEST(Verdicts, WhatWasNotMeasuredIsNotJudged) {
    ModelResult model = model_of("a", 40);
    std::erase_if(model.methods, [](const MethodResult& m) { return m.method == "openmesh"; });
    for (const Verdict& verdict : verdicts({model})) {
        EXPECT_EQ(verdict.target.what.find("OpenMesh"), std::string::npos);
        EXPECT_EQ(verdict.target.what.find("bytes"), std::string::npos);
    }
    EXPECT_TRUE(verdicts({}).empty());
}

TEST(Busyness, IsThePeersWallOverCpuTime) {
    EXPECT_DOUBLE_EQ(busyness({model_of("a", 40)}), 2.0);
    EXPECT_TRUE(std::isnan(busyness({})));
}

}  // namespace
}  // namespace lodestream::bench
