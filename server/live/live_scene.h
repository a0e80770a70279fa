// A baked scene whose objects are moved, hidden, shown, replaced and added to while it is served.
//
// What the bake has stored stays. Only what nodes are and where is kept beside it (store::Store::put_nodes), with the
// levels of the assets that they show; everything else is made from both again, in memory and in files that a restart
// sweeps, so a crash leaves a change whole or not there.
//
// A node may show another asset in place of its own objects, and there may be nodes that the source has not. Such an
// *added* object is one more of the finest tile that is nearest to it, hidden as the source has it.
//
// Each tile knows where it shows each object. Where one is elsewhere now, the tile's error is larger by what that is
// off (scene::displacement()), so that a client refines it where it shows, down to tiles that are true:
// - A finest tile of one object alone moves as it is, with its coarser levels.
// - One of several gets tiles below it: each object that has moved by itself, which is moved from then on by its tile's
//   transform alone, and the rest of them. Until these are made (make_rest()) it is the finest there is, and off.
// - The tiles above are made again from those below, the deepest first and each at most once a round (make_above());
//   so is a finest tile whose objects have been at rest for rest_time, as one again.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/scene/placement.h"
#include "proto/nodes.h"
#include "proto/tileset.h"
#include "server/bake/scene_source.h"
#include "server/bake/tile_tree.h"
#include "server/live/tile_contents.h"
#include "server/live/transient_files.h"

namespace lodestream::live {

inline constexpr std::size_t max_moved_objects = 20'000;  // of a scene
inline constexpr std::size_t max_added_nodes = 10'000;    // of a scene
inline constexpr std::size_t max_added_objects =
    10'000;  // of a scene since it was opened, those replaced again counted
inline constexpr std::uint64_t max_added_triangles = 1'000'000;  // of one added object
inline constexpr std::size_t max_listed_nodes = 1'000;           // of one page of nodes()
inline constexpr std::chrono::milliseconds rest_time{2'000};

// Which members each of some owners has.
class Lists {
  public:
    // `owners`: of each member, or `none`.
    Lists(std::size_t size, std::span<const std::uint32_t> owners);
    std::span<const std::uint32_t> of(std::uint32_t owner) const {
        return std::span(members_).subspan(first_[owner], first_[owner + 1] - first_[owner]);
    }

  private:
    std::vector<std::uint32_t> first_, members_;
};

class LiveScene {
  public:
    using Clock = std::chrono::steady_clock;

    // With the changes that the store keeps. `store` must outlive it. Errors: conflict (the asset is no baked scene of
    // several objects, or was baked before its objects were kept), those of the store.
    static Result<std::shared_ptr<LiveScene>> open(store::Store& store, const proto::Asset& asset,
                                                   std::shared_ptr<TransientFiles> files);

    // All of the changes or none; they are in the store and in every tileset from then on. Errors: not_found (a node,
    // an asset), limit_exceeded (max_moved_objects and the others above), conflict (nothing would be left to see, an
    // asset that is not ready or has no triangles, a new node's number is not the next one), invalid_input (what nodes
    // above make of a place), those of the store.
    Result<proto::NodesChanged> change(std::span<const proto::NodeChange> changes);

    // Whether the store still has the bake that it was opened with.
    bool is_current() const;

    std::uint64_t revision() const;
    std::size_t moved_objects() const;
    proto::Tileset tileset() const;
    // From node `first` on, at most max_listed_nodes.
    proto::SceneNodes nodes(std::uint32_t first, std::size_t count) const;

    // Whether some object is drawn nowhere at its own place yet: make_rest() has work.
    bool is_behind() const;

    // Make what a change has made untrue, one tile a call; false where there is nothing to do. make_rest() from any
    // thread, make_above() from one. What cannot be made stays as it is, off by what it says. `goes_on`: false ends
    // early.
    bool make_rest();
    bool make_above(const std::function<bool()>& goes_on);

  private:
    using Placements = std::map<std::uint32_t, scene::Placement>;      // of objects
    using PlacementPointer = std::shared_ptr<const scene::Placement>;  // null: as the source has it
    using Shown = std::map<std::uint32_t, PlacementPointer>;           // of objects that are not as in the source

    // A node that was changed, or is not the source's.
    struct Node {
        scene::Placement placement{};
        std::string asset{};  // that it shows, with the hash of that level; empty: objects of its own
        std::string hash{};
        std::optional<std::uint32_t> parent{};  // of one that is not the source's
    };
    using Nodes = std::map<std::uint32_t, Node>;
    // An object that is not the source's: of a node, beside those of a finest tile.
    struct Added {
        std::uint32_t node, tile;
        Box box;  // world axes
    };

    // A tile that the bake has made, with what it shows now.
    struct Tile {
        Content content;
        std::uint32_t parent, first_child, child_count;
        std::uint32_t entered, left;  // in a walk through the tree: all below lies between
        std::uint32_t visible_objects = 0;
        bool is_rigid = false;   // shows one object alone, and moves with it
        std::uint32_t made = 0;  // how often its content was made anew
        Shown shown;             // empty where it is rigid
        double stale = 0.0;      // what the objects' places make it off by, at most
    };
    // The tiles below a finest one.
    struct Split {
        std::set<std::uint32_t> out;  // objects with tiles of their own
        Content rest;                 // of no triangles where none is left
        bool is_exact = true;         // the objects may be one tile again
    };
    struct Moved {
        PlacementPointer pointer;
        Clock::time_point at;
        Content own;  // of no triangles until it is made
    };

    LiveScene(store::Store& store, std::string asset_id, std::string tiles_hash, bake::SceneSource source,
              const bake::TileTree& tiles, std::shared_ptr<TransientFiles> files);

    Status restore();

    // Of nodes and objects, which do not change.
    std::uint32_t finest(std::uint32_t tile) const;                       // down a chain of levels
    std::vector<std::uint32_t> levels_above(std::uint32_t finest) const;  // made from what is below, finest first
    bool is_below(std::uint32_t object, const Tile& tile) const;

    // Of all that its nodes may show.
    Result<Content> stored_content(const std::string& hash, double error) const;
    Result<Content> content_of_asset(const std::string& name);

    // All that follows is called with the mutex held.
    Result<Nodes> changed_nodes(std::span<const proto::NodeChange> changes) const;
    // `added`: the contents of nodes that come to show another asset; their objects will be the next ones.
    Result<Placements> objects_below(const Nodes& changed, const std::map<std::uint32_t, Content>& added) const;
    void install(const Nodes& changed, std::map<std::uint32_t, Content> added, const Placements& objects);
    void add_object(std::uint32_t node, Content content);
    std::uint32_t nearest_finest(const Box& box) const;
    void make_shared(std::uint32_t finest);  // a rigid tile, which is to show more than its object
    std::size_t node_count() const { return source_nodes() + new_parents_.size(); }
    std::size_t source_nodes() const { return source_.model().graph.parents.size(); }
    std::uint32_t parent_of(std::uint32_t node, const Nodes& changed) const;
    bool is_added(std::uint32_t object) const { return object >= source_.objects(); }
    const Added& added(std::uint32_t object) const { return added_[object - source_.objects()]; }
    const Box& box_of(std::uint32_t object) const { return is_added(object) ? added(object).box : source_.box(object); }
    std::uint32_t tile_of(std::uint32_t object) const {
        return is_added(object) ? added(object).tile : source_.tile(object);
    }
    std::uint32_t node_of(std::uint32_t object) const {
        return is_added(object) ? added(object).node : source_.model().graph.object_nodes[object];
    }
    scene::Placement as_source(std::uint32_t object) const { return {Mat4d(1.0), !is_added(object)}; }
    std::span<const std::uint32_t> added_beside(std::uint32_t tile) const;
    bool has_added(std::uint32_t finest) const;  // visible ones beside it: it cannot be whole
    Status check(const Placements& objects) const;
    void place(std::uint32_t object, const scene::Placement& now);
    scene::Placement placement(std::uint32_t object) const;
    PlacementPointer pointer(std::uint32_t object) const;
    // What showing the object as `shown` says is off.
    double off(const Shown& shown, std::uint32_t object) const;
    std::set<std::uint32_t> displaced(std::uint32_t finest) const;
    void installed(std::uint32_t tile, Content content, Shown shown);
    void gather_finest(std::uint32_t tile, std::vector<PlacedContent>& below, Shown& shown) const;
    void gather_below(std::uint32_t finest, std::vector<PlacedContent>& below, Shown& shown) const;
    std::vector<std::uint32_t> next_round() const;
    void changed_now();

    // These take it themselves.
    void make_whole(std::uint32_t tile);
    void make_levels(std::uint32_t finest, const std::function<bool()>& goes_on);

    store::Store& store_;
    const std::string asset_id_, tiles_hash_;
    const bake::SceneSource source_;
    const std::shared_ptr<TransientFiles> files_;
    const Lists tile_objects_;                // of each tile: those that it is the finest of
    const Lists node_objects_, child_nodes_;  // of each node

    std::mutex changing_;  // held by a change to its end
    mutable std::mutex mutex_;
    std::vector<Tile> tiles_;
    Nodes nodes_;
    std::vector<std::uint32_t> new_parents_;                            // of nodes behind the source's
    std::map<std::uint32_t, std::vector<std::uint32_t>> new_children_;  // of nodes
    std::vector<Added> added_;                                          // objects behind the source's
    std::map<std::uint32_t, std::uint32_t> added_of_node_;              // the one that the node shows
    std::map<std::uint32_t, std::vector<std::uint32_t>> added_of_tile_;
    std::map<std::uint32_t, Moved> moved_;   // objects that were placed elsewhere since it was opened
    std::size_t away_ = 0;                   // of these, not as in the source
    std::map<std::uint32_t, Split> splits_;  // of finest tiles
    std::set<std::uint32_t> unsplit_;        // finest tiles with objects elsewhere and without tiles
    std::set<std::uint32_t> untrue_;         // tiles above others to be made again: the finest of a chain
    std::uint32_t next_unsplit_ = 0;         // in turn
    std::vector<std::uint32_t> round_;       // of make_above(): to be made, the last one first
    std::uint64_t revision_ = 0;
};

}  // namespace lodestream::live
