// Checks on orders of triangles, shared by the tests of this folder.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace lodestream::testing {

inline bool is_permutation_of_all(std::vector<std::uint32_t> order, std::size_t count) {
    std::sort(order.begin(), order.end());
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    return order == all;
}

}  // namespace lodestream::testing
