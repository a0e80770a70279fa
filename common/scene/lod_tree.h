// What a renderer chooses from: a tree of levels of detail, each node one level of everything below it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/math.h"
#include "common/base/result.h"
#include "common/scene/hierarchy.h"

namespace lodestream::scene {

// Drawing a node replaces drawing its children. A leaf is the finest that there is.
struct LodNode {
    Box box;             // of its own geometry and all below
    double error = 0.0;  // geometric: model units by which its level is off from the finest; not below its children's
    std::uint64_t triangles = 0;
    std::uint32_t parent = none;
    std::uint32_t first_child = 0;
    std::uint32_t child_count = 0;
};

inline constexpr std::uint64_t max_tree_triangles = std::uint64_t{1} << 60;  // of all nodes together

// The root first, children side by side and after their parent.
using LodTree = std::vector<LodNode>;

// Nodes from the root to the farthest leaf, both counted. pre: validate(tree)
std::size_t depth(std::span<const LodNode> tree);

// Whether above every leaf, or at it, lies exactly one of these nodes. pre: validate(tree), nodes < tree.size()
bool is_cut(std::span<const LodNode> tree, std::span<const std::uint32_t> nodes);

// Makes boxes hold those of the children, and errors not below theirs. pre: validate(tree) but for these
void keep_the_laws(LodTree& tree);

// Whether a tree from outside keeps the laws above: places, order, finite numbers, errors and boxes that hold those of
// the children. Never trusts.
Status validate(std::span<const LodNode> tree);

}  // namespace lodestream::scene
