// Places along the Z-order (Morton) curve: near in space is mostly near on the curve.
#pragma once

#include <cstdint>

namespace lodestream {

// Bits 0, 3, 6, … of the result are the lowest 21 bits of `v`.
inline std::uint64_t spread_bits(std::uint64_t v) {
    v = (v | v << 32) & 0x1f00000000ffffull;
    v = (v | v << 16) & 0x1f0000ff0000ffull;
    v = (v | v << 8) & 0x100f00f00f00f00full;
    v = (v | v << 4) & 0x10c30c30c30c30c3ull;
    return (v | v << 2) & 0x1249249249249249ull;
}

// Of a cell; each coordinate < 2^21.
inline std::uint64_t z_order(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
    return spread_bits(x) | spread_bits(y) << 1 | spread_bits(z) << 2;
}

}  // namespace lodestream
