#include "common/scene/lod_tree.h"

#include <algorithm>
#include <cmath>

namespace lodestream::scene {

namespace {

Error wrong(std::size_t node, const std::string& what) {
    return invalid_input("node " + std::to_string(node) + " " + what);
}

bool holds(const Box& outer, const Box& inner) {
    return inner.empty() ||
           (glm::all(glm::lessThanEqual(outer.min, inner.min)) && glm::all(glm::lessThanEqual(inner.max, outer.max)));
}

// Whether it lies among the children of the parent that it names.
bool is_child(std::span<const LodNode> tree, std::size_t node) {
    const std::uint32_t parent = tree[node].parent;
    return parent < tree.size() && node >= tree[parent].first_child &&
           node - tree[parent].first_child < tree[parent].child_count;
}

}  // namespace

std::size_t depth(std::span<const LodNode> tree) {
    std::vector<std::size_t> depths(tree.size(), 1);
    for (std::size_t i = 1; i < tree.size(); ++i) depths[i] = depths[tree[i].parent] + 1;
    return *std::max_element(depths.begin(), depths.end());
}

bool is_cut(std::span<const LodNode> tree, std::span<const std::uint32_t> nodes) {
    std::vector<std::uint32_t> above(tree.size(), 0);  // how many of the nodes are at or above each
    for (const std::uint32_t node : nodes) ++above[node];
    for (std::size_t i = 0; i < tree.size(); ++i) {
        if (i > 0) above[i] += above[tree[i].parent];
        if (above[i] > 1 || (tree[i].child_count == 0 && above[i] != 1)) return false;
    }
    return true;
}

void keep_the_laws(LodTree& tree) {
    for (std::size_t i = tree.size(); i-- > 1;) {
        LodNode& parent = tree[tree[i].parent];
        if (!tree[i].box.empty()) {
            parent.box.add(tree[i].box.min);
            parent.box.add(tree[i].box.max);
        }
        parent.error = std::max(parent.error, tree[i].error);
    }
}

Status validate(std::span<const LodNode> tree) {
    if (tree.empty()) return invalid_input("a tree of levels has no node");
    if (tree.front().parent != none) return wrong(0, "is the root and has a parent");
    std::uint64_t triangles = 0;
    std::size_t children = 0;
    for (std::size_t i = 0; i < tree.size(); ++i) {
        const LodNode& node = tree[i];
        if (!node.box.empty() && !(all_finite(node.box.min) && all_finite(node.box.max)))
            return wrong(i, "has a box that is not finite");
        if (!std::isfinite(node.error) || node.error < 0) return wrong(i, "has an error that is no distance");
        if (node.triangles > max_tree_triangles - triangles) return wrong(i, "has more triangles than can be counted");
        triangles += node.triangles;
        if (node.child_count == 0) continue;
        if (node.first_child <= i || node.first_child >= tree.size() ||
            node.child_count > tree.size() - node.first_child)
            return wrong(i, "has children out of place");
        for (std::size_t child = node.first_child; child < std::size_t{node.first_child} + node.child_count; ++child) {
            if (tree[child].parent != i) return wrong(child, "does not name its parent");
            if (tree[child].error > node.error) return wrong(child, "has a larger error than its parent");
            if (!holds(node.box, tree[child].box)) return wrong(child, "lies outside of its parent's box");
        }
        children += node.child_count;
    }
    // Each node names one parent, so no two have a child in common.
    for (std::size_t i = 1; children + 1 < tree.size() && i < tree.size(); ++i)
        if (!is_child(tree, i)) return wrong(i, "is no one's child");
    return Nothing{};
}

}  // namespace lodestream::scene
