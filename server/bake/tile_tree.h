// An asset's tree of tiles in the store: each one level of everything below it, in a file of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/lod_tree.h"
#include "proto/messages.h"
#include "server/store/store.h"

namespace lodestream::bake {

struct TileTree {
    scene::LodTree nodes;              // boxes in world axes; errors are maximum errors against the finest tiles
    std::vector<std::string> hashes;   // of each node: its content among the store's files, as .glb
    std::vector<std::uint64_t> bytes;  // of each node's content
    bool is_additive = false;          // of a cloud: tiles are drawn beside those above them
    // Of each node's content: from its own coordinates to the world's; empty: all are in the world's.
    std::vector<Mat4d> matrices{};
};

inline constexpr std::string_view tiles_key = "tiles";  // of the tree among an asset's content
inline constexpr std::uint64_t max_tiles_bytes = 1ull << 30;
// Of the tiles that a node of the hierarchy has become, from the finest.
inline std::string tile_key(std::uint64_t node, std::uint64_t level) {
    return "tile/" + std::to_string(node) + '/' + std::to_string(level);
}

std::vector<std::byte> serialize(const TileTree& tree);
// Hostile bytes: tree and matrices are validated (scene::validate), hashes are hexadecimal.
Result<TileTree> open_tile_tree(std::span<const std::byte> bytes);

// The tree that a bake has stored, or, of an asset of one object, the chain of its levels.
// Errors: unavailable (it is still baking), conflict (it has failed, or has no levels or bounds), those of reading.
Result<TileTree> load_tiles(const store::Store& store, const proto::Asset& asset);

}  // namespace lodestream::bake
