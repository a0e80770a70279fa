#include "server/cli/progress_bar.h"

#include <gtest/gtest.h>

namespace lodestream::cli {
namespace {

TEST(ProgressLine, TellsShareRateAndTimeToGo) {
    EXPECT_EQ(progress_line("bunny", 4'000'000, 0.5, 2.0),
              "bunny [############............]  50 %  1.00 Mtri/s  2 s to go");
    EXPECT_EQ(progress_line("bunny", 4'000'000, 1.0, 8.0),
              "bunny [########################] 100 %  0.50 Mtri/s  0 s to go");
}

TEST(ProgressLine, SaysNoRateBeforeThereIsOne) {
    EXPECT_EQ(progress_line("b", 1000, 0.0, 5.0), "b [........................]   0 %");
    EXPECT_EQ(progress_line("b", 1000, 0.25, 0.01), "b [######..................]  25 %");
}

TEST(ProgressLine, StaysInsideItsBar) {
    EXPECT_EQ(progress_line("b", 1000, 7.0, 0.0), "b [########################] 100 %");
    EXPECT_EQ(progress_line("b", 1000, -1.0, 0.0), "b [........................]   0 %");
}

}  // namespace
}  // namespace lodestream::cli
