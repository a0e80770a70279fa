// Work side by side, by whatever the caller has for it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

namespace lodestream::simplify {

// Runs task(0) … task(count - 1), each once, in any order and on any threads; returns when all have ended.
using Executor = std::function<void(std::size_t count, const std::function<void(std::size_t)>& task)>;

// Without an executor: one task after the other.
inline void run(const Executor& executor, std::size_t count, const std::function<void(std::size_t)>& task) {
    if (executor && count > 1) return executor(count, task);
    for (std::size_t k = 0; k < count; ++k) task(k);
}

// Calls work(begin, end) for runs of [0, count) of up to `run_length` each; the runs are the same for every executor.
template <class Work>
void for_each_run(const Executor& executor, std::size_t count, std::size_t run_length, const Work& work) {
    run(executor, (count + run_length - 1) / run_length,
        [&](std::size_t k) { work(k * run_length, std::min(count, (k + 1) * run_length)); });
}

}  // namespace lodestream::simplify
