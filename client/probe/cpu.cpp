#include "client/probe/cpu.h"

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace lodestream::probe {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t chunk = 100'000;  // operations between two looks at the clock; well below a millisecond
constexpr double round_s = 0.02;

// Returns what depends on every step, so that none can be left out.
double work(std::uint64_t& hash, double value) {
    for (std::uint32_t i = 0; i < chunk; ++i) {
        hash ^= hash << 13;
        hash ^= hash >> 7;
        hash ^= hash << 17;
        value = value * 0.5 + static_cast<double>(hash & 1023u);
    }
    return value;
}

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// Counts its chunks until told to stop.
void count_chunks(std::uint64_t seed, const std::atomic<bool>& stop, std::atomic<std::uint64_t>& chunks) {
    std::uint64_t hash = seed * 2 + 1;
    double value = 0.0;
    while (!stop.load(std::memory_order_relaxed)) {
        value = work(hash, value);
        chunks.fetch_add(value >= 0.0 ? 1 : 0, std::memory_order_relaxed);
    }
}

}  // namespace

Rate measure_cpu(std::uint32_t threads, double seconds) {
    std::atomic<bool> stop = false;
    std::atomic<std::uint64_t> chunks = 0;
    std::vector<std::jthread> running;
    for (std::uint32_t i = 0; i < threads; ++i)
        running.emplace_back([&stop, &chunks, i] { count_chunks(i + 1, stop, chunks); });
    std::vector<double> rates;
    for (const auto begin = Clock::now(); seconds_since(begin) < seconds;) {
        const auto start = Clock::now();
        const std::uint64_t before = chunks.load(std::memory_order_relaxed);
        std::this_thread::sleep_for(std::chrono::duration<double>(round_s));
        const std::uint64_t done = chunks.load(std::memory_order_relaxed) - before;
        rates.push_back(static_cast<double>(done) * chunk / seconds_since(start));
    }
    stop = true;
    running.clear();
    return rate_of(std::move(rates));
}

}  // namespace lodestream::probe
