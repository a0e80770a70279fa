// How much of the processors others used while we measured, and how long we waited for them.
#pragma once

#include <chrono>
#include <optional>
#include <string_view>

namespace lodestream::probe {

// Of all cores together, in clock ticks since the start of the machine.
struct CpuTicks {
    double busy = 0.0;  // user, nice, system, interrupts and what a hypervisor took away
    double all = 0.0;
};

// The first line of /proc/stat; absent where the text is something else.
std::optional<CpuTicks> parse_cpu_ticks(std::string_view proc_stat);

// Milliseconds that this process's threads were ready to run and waited for a core since they started; 0 where the
// system does not say (Linux: schedstat).
double waited_ms();

// Of a schedstat file: its second number, nanoseconds; absent where the text is something else.
std::optional<double> parse_waited_ns(std::string_view schedstat);

class LoadMeter {
  public:
    LoadMeter();  // from now on

    // Cores that other processes kept busy since then, 0 … all cores; absent where the system does not say or no time
    // has passed.
    std::optional<double> other_cores() const;

  private:
    std::chrono::steady_clock::time_point start_;
    std::optional<CpuTicks> ticks_;
    double own_s_ = 0.0;
};

}  // namespace lodestream::probe
