// Which levels of a tree are drawn in a view: descend until the error on the screen is small enough (image-quality
// mode), the largest first until the triangles are spent (target-frame-rate mode), or both at once.
// Source: HLOD paper (seeds-digest §4).
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/scene/lod_tree.h"
#include "common/scene/view.h"

namespace lodestream::scene {

inline constexpr double unlimited_px = std::numeric_limits<double>::infinity();

struct SelectOptions {
    double tolerance_px = 0.0;  // nodes with no larger error are not refined
    std::uint64_t budget = std::numeric_limits<std::uint64_t>::max();
    std::uint64_t max_refinements = std::numeric_limits<std::uint64_t>::max();  // stop after so many: any cut is valid
    double start_px = unlimited_px;  // the threshold of the last frame's Selection; the result is the same for any
};

struct Selection {
    std::vector<std::uint32_t> nodes;    // a cut: above every leaf, or at it, lies exactly one of them
    std::uint64_t spent = 0;             // triangles of those that the view sees
    double largest_error_px = 0.0;       // of the cut; 0 where all that is seen is drawn at its finest
    double threshold_px = unlimited_px;  // to start the next frame from
    bool feasible = true;                // false: not even the root is within the budget; it is drawn nevertheless
};

// Nodes are refined in the order of their error on the screen. Where the next one no longer fits, the few around that
// place are chosen so that the sum of the errors is least, and smaller ones that still fit follow. O(nodes of the cut)
// where `start_px` is that of a view nearby; from the root, O(n log n) in them. pre: validate(tree), validate(view)
Selection select(std::span<const LodNode> tree, const View& view, const SelectOptions& options);

}  // namespace lodestream::scene
