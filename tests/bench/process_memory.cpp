#include "tests/bench/process_memory.h"

#include <malloc.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <string>

#include "tests/bench/copied_process.h"

namespace lodestream::bench {

namespace {

// A line like "VmHWM:     1234 kB" of the kernel's status of this process.
std::uint64_t status_bytes(const std::string& key) {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
        std::uint64_t kilobytes = 0;
        if (word == key && status >> kilobytes) return 1024 * kilobytes;
    }
    throw std::runtime_error("the kernel does not tell " + key);
}

void reset_high_water_mark() {
    std::ofstream mark("/proc/self/clear_refs");
    mark << "5" << std::flush;
    if (!mark) throw std::runtime_error("the kernel does not reset the high-water mark of resident memory");
}

std::uint64_t growth_here(const std::function<void()>& work) {
    malloc_trim(0);
    reset_high_water_mark();
    const std::uint64_t before = status_bytes("VmRSS:"), files_before = status_bytes("RssFile:");
    work();
    const std::uint64_t files = std::max(status_bytes("RssFile:"), files_before) - files_before;
    return std::max(status_bytes("VmHWM:"), before + files) - before - files;
}

}  // namespace

std::uint64_t peak_growth_bytes(const std::function<void()>& work, const std::function<void()>& prepare) {
    std::uint64_t bytes = 0;
    const auto measure = [&](std::FILE* out) {
        if (prepare) prepare();
        const std::uint64_t growth = growth_here(work);
        send_bytes(&growth, sizeof growth, out);
    };
    run_in_copy(measure, [&](std::FILE* in) { receive_bytes(&bytes, sizeof bytes, in); });
    return bytes;
}

}  // namespace lodestream::bench
