// An order of a cloud in which every prefix is a level.
#pragma once

#include <vector>

#include "common/points/point_cloud.h"
#include "common/simplify/executor.h"

namespace lodestream::points {

struct OrderedCloud {
    PointCloud cloud;
    // Of the first i + 1 points: no point of the given cloud that looks the same way is farther from all of them, give
    // or take the distance between the points that were looked at. Model units, never rises.
    std::vector<float> spacings;
};

// The first `count` points of the order, or as many as there are apart: the next one is always (within 9 %) as far from
// those before as any. So each prefix is as even as blue noise: its points keep their distance, and none leaves a hole.
// After Gonzalez' farthest-point order, in passes of falling distance over cells of that size; coarse passes look at 32
// points a cell. Points whose normals face apart do not count as near, so both sides of a thin sheet are kept. Points
// nearer to another than 2^-21 of the extent are left out. O(n log n). The same for every executor. pre: at most
// max_points, positions finite
OrderedCloud order(const PointCloud& cloud, std::uint64_t count, const simplify::Executor& executor = {});

}  // namespace lodestream::points
