// Division of a surface's positions into regions that are simplified side by side.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/math.h"
#include "common/simplify/executor.h"

namespace lodestream::simplify {

struct Regions {
    std::vector<std::uint32_t> positions;  // region after region, by rising number in each
    std::vector<std::size_t> first;        // of each region, into positions; one more than regions
    std::vector<std::uint16_t> of;         // of each point: its region; without meaning where it is not of `positions`

    std::size_t size() const { return first.size() - 1; }
    std::span<const std::uint32_t> in(std::size_t region) const {
        return std::span(positions).subspan(first[region], first[region + 1] - first[region]);
    }
};

inline constexpr std::size_t max_regions = 4096;

// `positions`: by rising number, into `points`. Planes part them into `count` regions (1 to max_regions) of nearly as
// many each. The planes of every `round` lie askew to those of the rounds before: what was at a border comes inside,
// but where two planes cross. The same for every executor.
Regions divide(const std::vector<std::uint32_t>& positions, const std::vector<Vec3f>& points, std::size_t count,
               std::size_t round, const Executor& executor);

}  // namespace lodestream::simplify
