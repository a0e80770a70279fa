// Tasks on threads of their own, started in an odd order: what must not depend on threads shows it.
#pragma once

#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

namespace lodestream::testing {

inline void on_threads(std::size_t count, const std::function<void(std::size_t)>& task) {
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < 3; ++k)
        threads.emplace_back([&, k] {
            for (std::size_t i = k; i < count; i += 3) task(count - 1 - i);
        });
}

}  // namespace lodestream::testing
