#include "client/render/rasterizer_threads.h"

#include <sched.h>

#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace lodestream::render {

namespace {

constexpr std::string_view rasterizer_name = "llvmpipe-";

std::vector<int> usable_processors() {
    cpu_set_t usable;
    CPU_ZERO(&usable);
    if (sched_getaffinity(0, sizeof usable, &usable) != 0) return {};
    std::vector<int> processors;
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
        if (CPU_ISSET(cpu, &usable)) processors.push_back(cpu);
    return processors;
}

// Threads of this process that rasterize.
std::vector<pid_t> rasterizers() {
    std::vector<pid_t> threads;
    std::error_code error;
    std::filesystem::directory_iterator entry("/proc/self/task", error);
    for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
        std::string name;
        std::ifstream(entry->path() / "comm") >> name;
        if (!name.starts_with(rasterizer_name)) continue;
        const std::string number = entry->path().filename().string();
        pid_t thread = 0;
        std::from_chars(number.data(), number.data() + number.size(), thread);
        threads.push_back(thread);
    }
    return threads;
}

bool place(pid_t thread, int processor) {
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(processor, &only);
    return sched_setaffinity(thread, sizeof only, &only) == 0;
}

}  // namespace

std::size_t spread_rasterizer_threads() {
    const std::vector<int> processors = usable_processors();
    const std::vector<pid_t> threads = rasterizers();
    if (threads.size() != processors.size()) return 0;
    std::size_t placed = 0;
    for (std::size_t i = 0; i < threads.size(); ++i) placed += place(threads[i], processors[i]) ? 1 : 0;
    return placed;
}

}  // namespace lodestream::render
