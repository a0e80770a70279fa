// A baked scene whose objects are moved, hidden and shown while it is served.
//
// What the bake has stored stays. Only the placements of nodes are kept beside it (store::Store::put_nodes); everything
// else is made from both again, in memory and in files that a restart sweeps, so a crash leaves a change whole or not
// there.
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
inline constexpr std::size_t max_listed_nodes = 1'000;    // of one page of nodes()
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

    // All of the changes or none; they are in the store and in every tileset from then on. Errors: not_found (a node),
    // limit_exceeded (max_moved_objects), conflict (nothing would be left to see), invalid_input (what nodes above make
    // of a place), those of the store.
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
    using Placements = std::map<std::uint32_t, scene::Placement>;      // of nodes or objects
    using PlacementPointer = std::shared_ptr<const scene::Placement>;  // null: as the source has it
    using Shown = std::map<std::uint32_t, PlacementPointer>;           // of objects that are not as in the source

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

    // All that follows is called with the mutex held.
    Result<Placements> changed_nodes(std::span<const proto::NodeChange> changes) const;
    Result<Placements> objects_below(const Placements& changed) const;
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
    std::map<std::uint32_t, scene::Placement> nodes_;  // those that were changed
    std::map<std::uint32_t, Moved> moved_;             // objects that were placed elsewhere since it was opened
    std::size_t away_ = 0;                             // of these, not as in the source
    std::map<std::uint32_t, Split> splits_;            // of finest tiles
    std::set<std::uint32_t> unsplit_;                  // finest tiles with objects elsewhere and without tiles
    std::set<std::uint32_t> untrue_;                   // tiles above others to be made again: the finest of a chain
    std::uint32_t next_unsplit_ = 0;                   // in turn
    std::vector<std::uint32_t> round_;                 // of make_above(): to be made, the last one first
    std::uint64_t revision_ = 0;
};

}  // namespace lodestream::live
