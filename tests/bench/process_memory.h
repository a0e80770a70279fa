// Resident memory, as the kernel counts it.
#pragma once

#include <cstdint>
#include <functional>

namespace lodestream::bench {

// Linux keeps what it counts of resident pages on each processor for a while: a figure may be off by this much.
inline constexpr std::uint64_t resident_count_error_bytes = 1 << 20;

// By how much the resident set grows at its peak while `work` runs in a forked copy of this process, which has run
// `prepare` before. What the heap holds free is handed back first and the kernel's high-water mark is reset, so all
// that the work touches is counted, however it was allocated, and nothing that was there before. Pages of files, as of
// code that runs for the first time, are not. What the work takes from this process or changes in it is so in the copy
// alone. Throws std::runtime_error where the kernel has no such mark or the work failed.
std::uint64_t peak_growth_bytes(const std::function<void()>& work, const std::function<void()>& prepare = {});

}  // namespace lodestream::bench
