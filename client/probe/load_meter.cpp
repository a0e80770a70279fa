#include "client/probe/load_meter.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

namespace lodestream::probe {

namespace {

constexpr double shortest_s = 0.05;  // a tick is 0.01 s

double own_cpu_s() {
    rusage usage{};
    if (getrusage(RUSAGE_SELF, &usage) != 0) return 0.0;
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::optional<CpuTicks> read_ticks() {
    std::ifstream file("/proc/stat");
    std::string line;
    if (!std::getline(file, line)) return std::nullopt;
    return parse_cpu_ticks(line);
}

}  // namespace

std::optional<CpuTicks> parse_cpu_ticks(std::string_view text) {
    constexpr std::string_view heading = "cpu ";
    // user nice system idle iowait irq softirq steal
    std::array<double, 8> ticks{};
    if (!text.starts_with(heading)) return std::nullopt;
    const char* at = text.data() + heading.size();
    const char* end = text.data() + text.size();
    for (double& value : ticks) {
        while (at != end && *at == ' ') ++at;
        const auto [stop, error] = std::from_chars(at, end, value);
        if (error != std::errc()) return std::nullopt;
        at = stop;
    }
    const double idle = ticks[3] + ticks[4];
    double all = 0.0;
    for (const double value : ticks) all += value;
    return CpuTicks{all - idle, all};
}

std::optional<double> parse_waited_ns(std::string_view text) {
    const std::size_t space = text.find(' ');
    if (space == std::string_view::npos) return std::nullopt;
    double ns = 0.0;
    const auto [stop, error] = std::from_chars(text.data() + space + 1, text.data() + text.size(), ns);
    return error == std::errc() && ns >= 0.0 ? std::optional(ns) : std::nullopt;
}

double waited_ms() {
    double ns = 0.0;
    std::error_code error;
    for (std::filesystem::directory_iterator task("/proc/self/task", error), end; !error && task != end;
         task.increment(error)) {
        std::ifstream file(task->path() / "schedstat");
        std::string line;
        if (std::getline(file, line)) ns += parse_waited_ns(line).value_or(0.0);
    }
    return 1e-6 * ns;
}

LoadMeter::LoadMeter() : start_(std::chrono::steady_clock::now()), ticks_(read_ticks()), own_s_(own_cpu_s()) {}

std::optional<double> LoadMeter::other_cores() const {
    const double passed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const auto ticks = read_ticks();
    const double ticks_per_s = static_cast<double>(sysconf(_SC_CLK_TCK));
    if (!ticks_ || !ticks || passed_s < shortest_s || !(ticks_per_s > 0.0)) return std::nullopt;
    const double busy_s = (ticks->busy - ticks_->busy) / ticks_per_s;
    return std::max(0.0, (busy_s - (own_cpu_s() - own_s_)) / passed_s);
}

}  // namespace lodestream::probe
