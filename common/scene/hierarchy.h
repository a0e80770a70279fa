// A hierarchy over a scene's objects, for hierarchical levels of detail: the source's scene graph where that divides
// space about as well as a division of space would, such a division where there is no graph or it is a bad one.
// Source: HLOD paper (seeds-digest §4); the division halves the heaviest part at its weighted median.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/base/math.h"

namespace lodestream::scene {

inline constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

struct Object {
    Box box;                      // finite; empty only without triangles
    std::uint64_t triangles = 0;  // 0: left out
    std::uint32_t graph_node = 0;
};

struct HierarchyOptions {
    std::uint32_t max_children = 8;         // >= 2
    std::uint64_t leaf_triangles = 16'384;  // objects of so few together are one leaf
    double graph_tolerance = 1.25;          // a graph's division is taken up to so many times the cost of one of space
};

// The objects of a node are [first_object, first_object + object_count) of Hierarchy::objects.
struct HierarchyNode {
    Box box;  // of its objects
    std::uint64_t triangles = 0;
    std::uint32_t parent = none;
    std::uint32_t first_child = 0;
    std::uint32_t child_count = 0;  // 0: a leaf; never 1
    std::uint32_t first_object = 0;
    std::uint32_t object_count = 0;
};

struct Hierarchy {
    std::vector<HierarchyNode> nodes;    // the root first, children side by side and after their parent
    std::vector<std::uint32_t> objects;  // indices of those with triangles, each once
};

// `graph_parents`: of each node of the scene graph its parent, or `none`; empty: there is no graph. A leaf is one
// object, or several of at most leaf_triangles together. Every child has at most 7/8 of its parent's objects, so the
// depth is logarithmic and the time O(n log² n), whatever the graph looks like: a chain, a flat list, one box a hundred
// thousand times. Without objects there are no nodes.
// pre: graph_parents[i] < i or none; graph_node < graph_parents.size() where that is not empty.
Hierarchy build_hierarchy(std::span<const Object> objects, std::span<const std::uint32_t> graph_parents,
                          const HierarchyOptions& options = {});

}  // namespace lodestream::scene
