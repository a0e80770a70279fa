// Hierarchical levels of detail of a scene: a tree of tiles over its objects (scene/hierarchy.h), the objects' own
// geometry in its leaves, and above them tiles that simplify what the tiles below show *together*.
// Source: HLOD paper (seeds-digest §4).
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/texture/choice.h"
#include "server/bake/shapes.h"
#include "server/bake/tile_levels.h"
#include "server/bake/tile_tree.h"
#include "server/store/store.h"

namespace lodestream::bake {

inline constexpr std::uint32_t max_tile_children = 4;  // of tiles above others; instances beside each other may be more

// A scene as its tiles are made of it.
struct SceneParts {
    const mesh::Model& model;
    const std::vector<ShapeLevels>& shapes;  // of each of the model's shapes
    const mesh::Mesh& whole;  // all that the model shows, roughly: what gives painted tiles their colours
};

// Makes, measures, encodes and stores the tiles of a model of several objects, from the leaves up and side by side, and
// stores their tree and the objects that they show (scene_source.h). Above the leaves a tile shows what can be seen
// from outside of it: a cut of the visible triangles of the tiles below or, where that is closer to them, of a closed
// surface wrapped around them (scene/surroundings.h), painted with the scene's colours (scene_colors.h). Where a
// material is not opaque or glows, nothing is wrapped. A tile's error bounds what it is off from the visible surface of
// the objects: its measured maximum error against what it is cut from, half a step of its grid, and the largest error
// of the tiles below. Instances that show one shape have tiles whose contents are that shape's, in coordinates of its
// own (TileTree::matrices), each encoded and stored once; the tiles above them are made of a coarse level of it
// (bake::stand_in), whose error counts too. All tiles lie on lattices of the scene's axes (codec::choose_window).
// `progress`: share done; returning false cancels. Errors: unavailable (cancelled), those of the codec and the store.
Result<TileTree> make_tiles(store::Store& store, const std::string& asset_id, const SceneParts& scene,
                            const texture::Textures& textures, const std::function<bool(double)>& progress);

}  // namespace lodestream::bake
