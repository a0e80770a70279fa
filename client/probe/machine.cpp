#include "client/probe/machine.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>
#include <vector>

namespace lodestream::probe {

namespace {

constexpr std::size_t max_file_bytes = 4u << 20;

std::string read_text(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::string text;
    for (std::istreambuf_iterator<char> at(file), end; at != end && text.size() < max_file_bytes; ++at) text += *at;
    return text;
}

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

std::optional<double> number(std::string_view text) {
    double value = 0.0;
    text = trimmed(text);
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && stop != text.data() ? std::optional(value) : std::nullopt;
}

// Every value of a field in lines of "field : value".
std::vector<std::string_view> values(std::string_view text, std::string_view field) {
    std::vector<std::string_view> found;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        const std::size_t colon = line.find(':');
        if (colon != std::string_view::npos && trimmed(line.substr(0, colon)) == field)
            found.push_back(trimmed(line.substr(colon + 1)));
    }
    return found;
}

std::optional<double> cpu_mhz(std::string_view cpuinfo) {
    if (const auto mhz = largest_value(cpuinfo, "cpu MHz"); mhz && *mhz > 0.0) return mhz;
    const auto khz = number(read_text("/sys/devices/system/cpu/cpu0/cpufreq/cpuinfo_max_freq"));
    return khz && *khz > 0.0 ? std::optional(*khz / 1000.0) : std::nullopt;
}

std::optional<double> memory_mb() {
    const auto total_kb = largest_value(read_text("/proc/meminfo"), "MemTotal");
    const auto limit_bytes = number(read_text("/sys/fs/cgroup/memory.max"));
    std::optional<double> megabytes;
    if (total_kb && *total_kb > 0.0) megabytes = *total_kb * 1024.0 / 1e6;
    if (limit_bytes && *limit_bytes > 0.0) megabytes = std::min(megabytes.value_or(1e12), *limit_bytes / 1e6);
    return megabytes;
}

std::optional<budget::Display> connected_display() {
    std::error_code error;
    for (std::filesystem::directory_iterator it("/sys/class/drm", error), end; !error && it != end;
         it.increment(error)) {
        if (trimmed(read_text(it->path() / "status")) != "connected") continue;
        const std::string modes = read_text(it->path() / "modes");
        if (const auto display = parse_mode(std::string_view(modes).substr(0, modes.find('\n')))) return display;
    }
    return std::nullopt;
}

}  // namespace

std::string first_value(std::string_view cpuinfo, std::string_view field) {
    const auto found = values(cpuinfo, field);
    return found.empty() ? "" : std::string(found.front());
}

std::optional<double> largest_value(std::string_view cpuinfo, std::string_view field) {
    std::optional<double> largest;
    for (const std::string_view value : values(cpuinfo, field))
        if (const auto read = number(value)) largest = std::max(largest.value_or(*read), *read);
    return largest;
}

std::optional<budget::Display> parse_mode(std::string_view mode) {
    const std::size_t by = mode.find('x');
    if (by == std::string_view::npos) return std::nullopt;
    const auto width = number(mode.substr(0, by)), height = number(mode.substr(by + 1));
    if (!width || !height || !(*width >= 1.0 && *width <= 65'536.0 && *height >= 1.0 && *height <= 65'536.0))
        return std::nullopt;
    return budget::Display{static_cast<std::uint32_t>(*width), static_cast<std::uint32_t>(*height)};
}

Machine read_machine() {
    const std::string cpuinfo = read_text("/proc/cpuinfo");
    Machine machine;
    machine.name = first_value(cpuinfo, "model name");
    machine.cpu_mhz = cpu_mhz(cpuinfo);
    machine.cpu_cores = std::max(1u, std::thread::hardware_concurrency());
    machine.memory_mb = memory_mb();
    machine.display = connected_display();
    return machine;
}

}  // namespace lodestream::probe
