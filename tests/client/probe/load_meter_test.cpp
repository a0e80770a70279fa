#include "client/probe/load_meter.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <ctime>
#include <thread>
#include <vector>

namespace lodestream::probe {
namespace {

using Clock = std::chrono::steady_clock;

void busy(double seconds) {
    const auto start = Clock::now();
    while (std::chrono::duration<double>(Clock::now() - start).count() < seconds) continue;
}

TEST(LoadMeter, ReadsBusyAndAllTicks) {
    const auto ticks = parse_cpu_ticks("cpu  10 2 3 100 5 1 1 8 0 0\ncpu0 1 2");
    ASSERT_TRUE(ticks);
    EXPECT_EQ(ticks->busy, 25.0);
    EXPECT_EQ(ticks->all, 130.0);
}

TEST(LoadMeter, RefusesOtherText) {
    EXPECT_FALSE(parse_cpu_ticks(""));
    EXPECT_FALSE(parse_cpu_ticks("cpu0 1 2 3 4 5 6 7 8"));
    EXPECT_FALSE(parse_cpu_ticks("cpu 1 2 3"));
    EXPECT_FALSE(parse_cpu_ticks("cpu a b c d e f g h"));
}

TEST(LoadMeter, SaysNothingAboutNoTime) {
    EXPECT_FALSE(LoadMeter().other_cores());
}

TEST(LoadMeter, ReadsWhatAThreadWaited) {
    EXPECT_EQ(*parse_waited_ns("1200 345 6"), 345.0);
    for (const char* bad : {"", "1200", "1200 x", "1200 -5 1"}) EXPECT_FALSE(parse_waited_ns(bad)) << bad;
}

// More threads than cores: some of them have to wait.
TEST(LoadMeter, SeesThatThreadsWait) {
    const double before_ms = waited_ms();
    double waited = 0.0;
    {
        std::vector<std::jthread> threads;
        for (unsigned i = 0; i < 2 * std::thread::hardware_concurrency() + 1; ++i)
            threads.emplace_back([] { busy(0.5); });
        std::this_thread::sleep_for(std::chrono::milliseconds(400));
        waited = waited_ms() - before_ms;  // of threads that still run
    }
    EXPECT_GT(waited, 50.0);
}

// Machines that run tests have other load, which may only add.
TEST(LoadMeter, SeesAnotherProcessThatIsBusy) {
    const pid_t child = ::fork();
    if (child == 0) {
        busy(20.0);
        ::_exit(0);
    }
    const LoadMeter meter;
    std::this_thread::sleep_for(std::chrono::seconds(2));
    const auto other = meter.other_cores();
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    ASSERT_TRUE(other);
    EXPECT_GT(*other, 0.1);
}

TEST(LoadMeter, DoesNotCountOurOwnWork) {
    const LoadMeter meter;
    const std::clock_t before = std::clock();
    busy(1.0);
    const double own = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    const auto other = meter.other_cores();
    ASSERT_TRUE(other);
    EXPECT_LT(*other + own, std::thread::hardware_concurrency() + 0.1);
}

}  // namespace
}  // namespace lodestream::probe
