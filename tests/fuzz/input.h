// What the fuzz targets share: taking an input apart, and laws that must hold.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <span>

#include "common/codec/points_codec.h"

namespace lodestream::fuzz {

using Bytes = std::span<const std::uint8_t>;

inline void require(bool holds) {
    if (!holds) std::abort();
}

// The first byte, which is then gone; 0 where there is none.
inline std::uint8_t take(Bytes& bytes) {
    if (bytes.empty()) return 0;
    const std::uint8_t first = bytes.front();
    bytes = bytes.subspan(1);
    return first;
}

// What holds of any points that were read.
inline void check(const codec::DecodedPoints& decoded) {
    const points::PointCloud& cloud = decoded.content.cloud;
    require(cloud.positions.size() <= decoded.points);
    require(cloud.normals.empty() || cloud.normals.size() == cloud.positions.size());
    require(cloud.colors.empty() || cloud.colors.size() == cloud.positions.size());
    for (const Vec3f& position : cloud.positions) require(all_finite(position));
    for (const Vec3f& normal : cloud.normals) require(all_finite(normal));
}

}  // namespace lodestream::fuzz
