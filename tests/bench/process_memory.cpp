#include "tests/bench/process_memory.h"

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <exception>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

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

// The child's whole life: leaves without the parent's destructors.
[[noreturn]] void report_growth(const std::function<void()>& work, const std::function<void()>& prepare, int pipe_end) {
    int code = 1;
    try {
        if (prepare) prepare();
        const std::uint64_t bytes = growth_here(work);
        code = write(pipe_end, &bytes, sizeof bytes) == static_cast<ssize_t>(sizeof bytes) ? 0 : 1;
    } catch (const std::exception& error) {
        std::cerr << error.what() << std::endl;
    }
    _exit(code);
}

}  // namespace

std::uint64_t peak_growth_bytes(const std::function<void()>& work, const std::function<void()>& prepare) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("no second process");
    if (child == 0) report_growth(work, prepare, ends[1]);
    close(ends[1]);
    std::uint64_t bytes = 0;
    const ssize_t got = read(ends[0], &bytes, sizeof bytes);
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (got != static_cast<ssize_t>(sizeof bytes) || status != 0)
        throw std::runtime_error("the work whose memory is measured failed");
    return bytes;
}

}  // namespace lodestream::bench
