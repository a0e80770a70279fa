// A bar with rate and time to go on stderr, where that is a terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace lodestream::cli {

// "name [########........]  50 %  1.2 Mtri/s  3 s to go". `elapsed_s`: since share was 0. Until there is anything to go
// by, only the bar.
std::string progress_line(const std::string& name, std::uint64_t triangles, double share, double elapsed_s);

class ProgressBar {
  public:
    ProgressBar();
    ~ProgressBar();  // wipes the line
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    void show(const std::string& name, std::uint64_t triangles, double share) const;

  private:
    bool is_terminal_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace lodestream::cli
