#include "client/probe/machine.h"

#include <gtest/gtest.h>

namespace lodestream::probe {
namespace {

constexpr const char* cpuinfo =
    "processor\t: 0\nmodel name\t: A CPU @ 2.00GHz: fast\ncpu MHz\t\t: 1800.5\n\n"
    "processor\t: 1\nmodel name\t: Another\ncpu MHz\t\t: 2400.25\n";

TEST(Machine, ReadsFieldsOfCpuinfo) {
    EXPECT_EQ(first_value(cpuinfo, "model name"), "A CPU @ 2.00GHz: fast");
    EXPECT_EQ(first_value(cpuinfo, "flags"), "");
    EXPECT_EQ(*largest_value(cpuinfo, "cpu MHz"), 2400.25);
    EXPECT_FALSE(largest_value(cpuinfo, "model name"));
    EXPECT_FALSE(largest_value("", "cpu MHz"));
}

TEST(Machine, ReadsDisplayModes) {
    EXPECT_EQ(parse_mode("1920x1080")->width, 1920u);
    EXPECT_EQ(parse_mode("1920x1080i")->height, 1080u);
    for (const char* bad : {"", "1920", "x1080", "0x5", "1e99x5", "axb"}) EXPECT_FALSE(parse_mode(bad)) << bad;
}

TEST(Machine, KnowsThisOne) {
    const Machine machine = read_machine();
    EXPECT_GE(machine.cpu_cores, 1u);
    ASSERT_TRUE(machine.memory_mb);
    EXPECT_GT(*machine.memory_mb, 1.0);
}

}  // namespace
}  // namespace lodestream::probe
