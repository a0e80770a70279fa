#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "tests/bench/copied_process.h"
#include "tests/bench/fit.h"
#include "tests/bench/process_memory.h"
#include "tests/bench/table.h"

namespace lodestream::bench {
namespace {

TEST(FitLine, FindsTheLineThatPointsLieOn) {
    const Line line = fit_line({{1, 5}, {2, 7}, {4, 11}});
    EXPECT_DOUBLE_EQ(line.slope, 2.0);
    EXPECT_DOUBLE_EQ(line.intercept, 3.0);
    EXPECT_DOUBLE_EQ(line.r_squared, 1.0);
}

TEST(FitLine, ExplainsNothingOfWhatDoesNotDependOnX) {
    EXPECT_NEAR(fit_line({{-1, 1}, {0, -2}, {1, 1}}).r_squared, 0.0, 1e-12);
}

TEST(Percentile, IsTheNearestRank) {
    const std::vector<double> values{40, 10, 30, 20};
    EXPECT_EQ(percentile(values, 0.0), 10);
    EXPECT_EQ(percentile(values, 0.5), 20);
    EXPECT_EQ(percentile(values, 0.51), 30);
    EXPECT_EQ(percentile(values, 1.0), 40);
}

TEST(RunInCopy, BringsWhatTheCopySendsAndNoneOfItsChanges) {
    std::vector<int> here{1, 2, 3}, got;
    const auto work = [&](std::FILE* out) {
        here.push_back(4);
        send(here, out);
    };
    run_in_copy(work, [&](std::FILE* in) { got = receive<int>(in); });
    EXPECT_EQ(got, (std::vector<int>{1, 2, 3, 4}));
    EXPECT_EQ(here, (std::vector<int>{1, 2, 3}));
}

TEST(RunInCopy, SaysThatTheCopySentTooLittle) {
    const auto half = [](std::FILE* out) {
        const std::size_t count = 8;
        send_bytes(&count, sizeof count, out);
    };
    EXPECT_THROW(run_in_copy(half, [](std::FILE* in) { receive<int>(in); }), std::runtime_error);
}

constexpr std::size_t block_bytes = 64 << 20;

std::unique_ptr<char[]> touched_block() {
    auto block = std::make_unique_for_overwrite<char[]>(block_bytes);
    volatile char* bytes = block.get();
    for (std::size_t i = 0; i < block_bytes; i += 1024) bytes[i] = 1;
    return block;
}

TEST(PeakGrowth, CountsWhatWasTouchedAndFreedAgain) {
    EXPECT_GE(peak_growth_bytes([] { touched_block(); }), block_bytes - resident_count_error_bytes);
}

TEST(PeakGrowth, LeavesOutWhatWasThereBefore) {
    const auto before = touched_block();
    EXPECT_LT(peak_growth_bytes([&] { static_cast<volatile char*>(before.get())[0] = 2; }), block_bytes / 2);
}

TEST(PeakGrowth, SaysThatTheWorkFailed) {
    EXPECT_THROW(peak_growth_bytes([] { throw std::runtime_error("on purpose"); }), std::runtime_error);
}

TEST(Table, AlignsTheFirstColumnLeftAndTheOthersRight) {
    EXPECT_EQ(to_text({{"a", "count"}, {"long", "7"}}), "a     count\nlong      7\n");
}

TEST(Brief, HasThreeSignificantDigits) {
    EXPECT_EQ(brief(1234.5), "1234");
    EXPECT_EQ(brief(12.345), "12.3");
    EXPECT_EQ(brief(0.012345), "0.0123");
    EXPECT_EQ(brief(std::nan("")), "-");
}

}  // namespace
}  // namespace lodestream::bench
