// The nodes of a scene that move: what a client asks for, and what the server tells of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/math.h"
#include "common/base/result.h"
#include "common/scene/hierarchy.h"
#include "common/scene/placement.h"

namespace lodestream::proto {

inline constexpr std::size_t max_node_changes = 10'000;  // in one request
inline constexpr std::size_t max_asset_name = 256;       // bytes of an asset's id or name

inline constexpr std::uint32_t next_node = scene::none;  // whichever number comes behind those that there are

// Of one node and all below it; what is not given stays.
struct NodeChange {
    std::uint32_t node = next_node;  // next_node only with a parent
    std::optional<Mat4d> matrix;     // from world coordinates as the source has them, y up; scene::validate() holds
    std::optional<bool> visible;
    // By id or name, the asset whose finest level the node shows in place of objects of its own, in that asset's world
    // coordinates, from which the node's matrix leads; empty: its own objects again.
    std::optional<std::string> asset{};
    std::optional<std::uint32_t> parent{};  // a new node below this one
};

// {"nodes":[{"node":3,"matrix":[16 numbers, column by column]},{"node":4,"translation":[0,1,0],"rotation":[0,0,0,1],
// "scale":[1,1,1]},{"node":5,"visible":false},{"node":6,"asset":"crate"},{"parent":0,"asset":"crate"}]}: each node
// once, a matrix or any of its three parts; one with a parent is new, and its number, if given, the next one. Hostile
// text. Errors name the field: invalid_input, limit_exceeded (max_node_changes).
Result<std::vector<NodeChange>> parse_node_changes(std::string_view json);
std::string to_json(const std::vector<NodeChange>& changes);

// The answer: from this revision on, a tileset is of the scene with the changes in it.
struct NodesChanged {
    std::uint64_t revision = 0;
    std::uint64_t moved_objects = 0;     // of the scene: not where its source has them
    std::vector<std::uint32_t> added{};  // numbers of the new nodes, as they were asked for
};
Result<NodesChanged> parse_nodes_changed(std::string_view json);
std::string to_json(const NodesChanged& changed);

struct SceneNode {
    std::uint32_t node = 0;
    std::optional<std::uint32_t> parent;
    std::uint64_t objects = 0;   // of its own, without those of the nodes below
    Box bounds;                  // of these, world axes, where they are now; empty without triangles
    scene::Placement placement;  // its own; nodes above move it too
    std::string asset{};         // that it shows in place of objects of its own; empty: none
};
struct SceneNodes {
    std::uint64_t revision = 0;
    std::uint64_t count = 0;       // of all nodes
    std::vector<SceneNode> nodes;  // the part that was asked for
};
Result<SceneNodes> parse_scene_nodes(std::string_view json);
std::string to_json(const SceneNodes& nodes);

}  // namespace lodestream::proto
