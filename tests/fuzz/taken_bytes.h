// For fuzz targets that make their data from the input's bytes, one after another.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <span>

namespace lodestream::fuzz {

using Bytes = std::span<const std::uint8_t>;

inline void require(bool holds) {
    if (!holds) std::abort();
}

// The first byte, which is taken off; 0 behind the end.
inline std::uint8_t take(Bytes& bytes) {
    if (bytes.empty()) return 0;
    const std::uint8_t first = bytes.front();
    bytes = bytes.subspan(1);
    return first;
}

}  // namespace lodestream::fuzz
