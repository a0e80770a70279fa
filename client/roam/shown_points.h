// Tiles of points add to those above them. To draw one as a level of its place, as a tile of triangles is, it is put
// together with what those above it have there, about a third more points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/codec/points_codec.h"
#include "common/scene/lod_tree.h"

namespace lodestream::roam {

// A step down a tree: a node's children and which of them it goes to.
struct Branch {
    std::vector<Box> children;
    std::size_t taken = 0;
};

// The root, ..., the node itself. pre: validate(tree)
std::vector<std::uint32_t> path_to(std::span<const scene::LodNode> tree, std::uint32_t node);
// From each node of a path to the next.
std::vector<Branch> branches_of(std::span<const scene::LodNode> tree, std::span<const std::uint32_t> path);

// `contents`: of the nodes of a path. Each point of a tile goes to that of its children whose box is nearest, the first
// of several; so the children of a tile together show all that it does, once. The result has the last content's discs.
// pre: one content more than branches
codec::Points shown_by(std::span<const Branch> branches, const std::vector<codec::Points>& contents);

}  // namespace lodestream::roam
