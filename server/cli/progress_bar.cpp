#include "server/cli/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace lodestream::cli {

namespace {

constexpr int bar_width = 24;
constexpr double least_s = 0.2;  // before that a rate says nothing

}  // namespace

std::string progress_line(const std::string& name, std::uint64_t triangles, double share, double elapsed_s) {
    share = std::clamp(share, 0.0, 1.0);
    const int filled = static_cast<int>(share * bar_width);
    std::string line = name + " [" + std::string(static_cast<std::size_t>(filled), '#') +
                       std::string(static_cast<std::size_t>(bar_width - filled), '.') + "]";
    char figures[96];
    std::snprintf(figures, sizeof figures, " %3d %%", static_cast<int>(share * 100.0));
    line += figures;
    if (!(share > 0.0) || elapsed_s < least_s) return line;
    const double done = share * static_cast<double>(triangles);
    std::snprintf(figures, sizeof figures, "  %.2f Mtri/s  %.0f s to go", done / elapsed_s / 1e6,
                  std::ceil(elapsed_s * (1.0 - share) / share));
    return line + figures;
}

ProgressBar::ProgressBar() : is_terminal_(::isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
    if (is_terminal_) std::fprintf(stderr, "\r\033[K");
}

void ProgressBar::show(const std::string& name, std::uint64_t triangles, double share) const {
    if (!is_terminal_) return;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    std::fprintf(stderr, "\r%s\033[K", progress_line(name, triangles, share, elapsed.count()).c_str());
}

}  // namespace lodestream::cli
