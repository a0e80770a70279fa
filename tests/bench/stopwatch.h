// Wall clock and CPU time of this process, all threads together.
#pragma once

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>

namespace lodestream::bench {

struct Duration {
    double wall_ms = 0.0;
    double cpu_ms = 0.0;  // more than the wall's where several threads ran
};

class Stopwatch {
  public:
    Duration elapsed() const {
        const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - wall_start_;
        return {wall.count(), process_cpu_ms() - cpu_start_ms_};
    }

  private:
    static double process_cpu_ms() {
        timespec now{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
        return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
    }

    std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
    double cpu_start_ms_ = process_cpu_ms();
};

// CPU time of the fastest of so many turns.
template <class Work>
double least_ms(int turns, const Work& work) {
    double least = std::numeric_limits<double>::infinity();
    for (int turn = 0; turn < turns; ++turn) {
        const Stopwatch watch;
        work();
        least = std::min(least, watch.elapsed().cpu_ms);
    }
    return least;
}

}  // namespace lodestream::bench
