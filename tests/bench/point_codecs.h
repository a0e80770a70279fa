// A level of points by other codecs: what it takes, without container.
#pragma once

#include <cstdint>

#include "common/points/point_cloud.h"

namespace lodestream::bench {

// Steps of the cloud's longest side for positions; normals and colours in 8 bits a component.
struct PointSizes {
    std::uint64_t plain = 0;           // interleaved, as common/codec/points_codec.h writes them
    std::uint64_t draco = 0;           // its k-d tree, which keeps no order: no prefix can be drawn
    std::uint64_t draco_in_order = 0;  // its sequential coder
    std::uint64_t meshopt = 0;         // along the Z-order curve: no prefix can be drawn
    std::uint64_t meshopt_blocks = 0;  // likewise within blocks that double the points: each block's end can
    std::uint64_t meshopt_in_order = 0;
};

// Throws std::runtime_error. pre: the cloud has normals
PointSizes point_sizes(const points::PointCloud& cloud, int position_bits);

}  // namespace lodestream::bench
