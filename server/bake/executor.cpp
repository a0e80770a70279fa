#include "server/bake/executor.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace lodestream::bake {

namespace {

void run(std::size_t count, const std::function<void(std::size_t)>& task) {
    std::atomic<std::size_t> next{0};
    std::atomic<bool> failed{false};
    std::exception_ptr why;
    const auto work = [&] {
        for (std::size_t k = next++; k < count && !failed; k = next++) {
            try {
                task(k);
            } catch (...) {
                if (!failed.exchange(true)) why = std::current_exception();
            }
        }
    };
    const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::jthread> threads;
    for (std::size_t k = 1; k < std::min(cores, count); ++k) threads.emplace_back(work);
    work();
    threads.clear();
    if (why) std::rethrow_exception(why);
}

}  // namespace

simplify::Executor all_cores() {
    return run;
}

}  // namespace lodestream::bake
