#include "client/probe/cpu.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <thread>
#include <vector>

namespace lodestream::probe {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t round = 1'000'000;  // operations; a few milliseconds
constexpr std::size_t least_rounds = 3;
constexpr double shortest_s = 1e-6;

double thread_cpu_s() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Returns what depends on every step, so that none can be left out.
double work(std::uint64_t& hash, double value) {
    for (std::uint32_t i = 0; i < round; ++i) {
        hash ^= hash << 13;
        hash ^= hash >> 7;
        hash ^= hash << 17;
        value = value * 0.5 + static_cast<double>(hash & 1023u);
    }
    return value;
}

// Operations per second of running, one number a round.
std::vector<double> rounds(std::uint64_t seed, double seconds) {
    std::vector<double> rates;
    std::uint64_t hash = 2 * seed + 1;
    double value = 0.0;
    const auto begin = Clock::now();
    while (rates.size() < least_rounds || std::chrono::duration<double>(Clock::now() - begin).count() < seconds) {
        const double start_s = thread_cpu_s();
        value = work(hash, value);
        const double passed_s = std::max(thread_cpu_s() - start_s, shortest_s);
        rates.push_back(value >= 0.0 ? round / passed_s : 0.0);
    }
    return rates;
}

}  // namespace

Rate measure_cpu(std::uint32_t threads, double seconds) {
    std::vector<std::vector<double>> rates(threads);
    {
        std::vector<std::jthread> running;
        for (std::uint32_t i = 0; i < threads; ++i)
            running.emplace_back([&rates, i, seconds] { rates[i] = rounds(i, seconds); });
    }
    // The rounds of all threads side by side, as far as every thread has one.
    std::size_t common = rates[0].size();
    for (const auto& thread : rates) common = std::min(common, thread.size());
    std::vector<double> together(common, 0.0);
    for (const auto& thread : rates)
        for (std::size_t i = 0; i < common; ++i) together[i] += thread[i];
    return rate_of(std::move(together));
}

}  // namespace lodestream::probe
