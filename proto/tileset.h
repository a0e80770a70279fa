// A tree of levels as a 3D Tiles 1.1 tileset, each tile replacing those below it or, of points, adding to those above.
// Source: OGC 3D Tiles 1.1 (22-025r4), 7.2 "Geometric error" and 7.4 "Refinement".
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/lod_tree.h"

namespace lodestream::proto {

struct Tileset {
    scene::LodTree nodes;              // boxes in world axes, y up
    std::vector<std::string> uris;     // of each node's content
    std::vector<std::uint64_t> bytes;  // of each node's content; 0: not known
    bool is_additive = false;          // tiles are drawn beside those above them, as points are, not in their place
    // Of each node's content: from its own coordinates to the world's, y up; empty: all are in the world's.
    std::vector<Mat4d> matrices{};
    // Of each node that shows one node of the scene alone: which; empty: none does.
    std::vector<std::uint32_t> scene_nodes{};
    // Of each node: which tile it is over all revisions, each once; empty: not told, there is one revision.
    std::vector<std::uint64_t> ids{};
    std::uint64_t revision = 0;  // of a scene whose objects move: rises with each change; 0: none has moved
    // Of each node: the address of the document that tells what is below it; empty: nothing more is. All empty: none.
    std::vector<std::string> documents{};

    Mat4d matrix(std::size_t node) const { return matrices.empty() ? Mat4d(1.0) : matrices[node]; }
};
inline constexpr std::uint32_t no_scene_node = scene::none;

// A tile's geometricError is its level's maximum error; its `extras` tell `triangles` and `bytes`, so that a client can
// keep to a budget before it has fetched anything, `node` where it shows one node of a scene alone, and `id`. What has
// moved is a tile with a `transform`; `asset.tilesetVersion` is the revision, where there is one. glTF is y up and
// tiles are z up: (x, y, z) becomes (x, -z, y). pre: validate(tileset.nodes), as many uris and bytes; matrices that
// scene::validate() takes
// A tileset of more than max_document_tiles is told in several documents, each of the tiles below one of it, so that a
// client reads only those of what it refines (3D Tiles 1.1, 7.6 "External tilesets"): `document` is that tile, or the
// root. Of a tile at which another begins, `extras.content` tells the content too, so that clients of ours need not
// read that document to show it.
std::string to_json(const Tileset& tileset, std::uint32_t document = 0);

inline constexpr std::size_t max_tileset_depth = 200;  // of its JSON: about half as many tiles
inline constexpr std::size_t max_tiles = 1'000'000;

inline constexpr std::size_t max_document_tiles = 500;

// Splits a tileset of more tiles: below the root's document each begins at a tile that has at most so many with those
// below it, and no tile above it has. Tiles get ids, if they have none. `address`: of the document at the tile of an
// id, whose version is another as soon as anything in it is. pre: validate(tileset.nodes)
void split_into_documents(Tileset& tileset,
                          const std::function<std::string(std::uint64_t id, std::uint64_t version)>& address);

// Reads what to_json() wrote and other tilesets of its kind: boxes, one content a tile, one refinement for all. Boxes
// are made to hold those of their children, and errors not to be below theirs. Hostile text. Errors: invalid_input
// (names the tile), unsupported (other volumes, both refinements in one, tiles without content), limit_exceeded.
Result<Tileset> parse_tileset(std::string_view json);
// Likewise of a document below a tile that has this matrix.
Result<Tileset> parse_document(std::string_view json, const Mat4d& place);

// Puts what a document tells, which was read at the place of `node`, below that node. The nodes that are there keep
// their numbers. Errors: limit_exceeded (max_tiles).
Status add_document(Tileset& tileset, std::uint32_t node, const Tileset& document);

// Whether anything is told elsewhere below this node.
inline bool begins_document(const Tileset& tileset, std::size_t node) {
    return !tileset.documents.empty() && !tileset.documents[node].empty();
}

}  // namespace lodestream::proto
