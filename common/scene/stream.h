// What is drawn, fetched and dropped while the levels that a view selects are still on their way.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/scene/lod_tree.h"
#include "common/scene/view.h"

namespace lodestream::scene {

// What a client holds of a tree. A node is never held without its parent, so what is missing is covered by the nearest
// node above that is there.
struct Residency {
    std::vector<std::uint64_t> bytes;      // of each node; may be set anew while it is not here
    std::vector<std::uint64_t> last_used;  // of each node: the frame in which it was last wanted; 0: it is not here
    std::vector<bool> is_end;              // of each node: it is not refined, for a child of it cannot be had
    std::uint64_t frame = 0;
    std::uint64_t held_bytes = 0;

    explicit Residency(std::vector<std::uint64_t> bytes_of_nodes)
        : bytes(std::move(bytes_of_nodes)), last_used(bytes.size(), 0), is_end(bytes.size(), false) {}
    bool has(std::uint32_t node) const { return last_used[node] > 0; }
};

struct StreamOptions {
    double tolerance_px = 1.0;             // nodes with no larger error on the screen are not refined
    std::uint64_t max_triangles = ~0ull;   // of the cut that is wanted, in view; the root is wanted in any case
    std::uint64_t max_bytes = 512u << 20;  // held at once, what is being fetched included
    std::size_t max_requests = 8;          // in flight at once
};

struct StreamStep {
    std::vector<std::uint32_t> drawn;     // a cut of nodes that are here; empty only while the root is not
    std::vector<std::uint32_t> requests;  // to be in flight from now on, in this order; cancel all others
    std::size_t ahead = 0;                // how many of the requests, the last ones, only a coming view asks for
    std::size_t missing = 0;              // nodes that the view itself wants and that are not here
    std::vector<std::uint32_t> dropped;   // no longer held from now on
    bool bounded = false;                 // memory or triangles held back what the tolerance asks for
};

// One frame. Wanted is what the view refines, largest error on the screen first, as far as it fits into the memory with
// all nodes above it; the rest makes room, least recently wanted first, where a request needs it. Requests are the most
// urgent first and parents before their children, which are not held before them but may be on their way together: a
// deep tree's finest level takes one round trip, not one for each level. All that is drawn is wanted, so there is
// always room for what is wanted: it never stalls. A root larger than the memory is held alone. `shown`: nodes that
// stay on the screen while others fade in (common/scene/fade.h). They are not dropped; what does not fit beside them is
// requested once they are gone. `coming`: where the motion leads, the soonest first (ahead_of() gives one). What these
// views refine is fetched and held too, in the room and with the requests that the view itself leaves; it is not drawn
// before it is wanted. pre: validate(tree), validate() of all views, a byte count for each node
StreamStep step(std::span<const LodNode> tree, Residency& residency, const View& view, const StreamOptions& options,
                std::span<const View> coming = {}, std::span<const std::uint32_t> shown = {});

// Notes that a requested node is here. A node that is not asked for any more may come too, unless its parent is gone or
// there is no room: then false, and it is not kept.
bool arrive(std::span<const LodNode> tree, Residency& residency, std::uint32_t node, const StreamOptions& options);

// Notes that a node cannot be had: its parent stays in place of it, and is asked for no other of its children.
void give_up(std::span<const LodNode> tree, Residency& residency, std::uint32_t node);

}  // namespace lodestream::scene
