// Merges the cheapest edges of a region first, nearly: an edge is looked at again when it comes up, not when something
// near it changes. Costs mostly grow, so what an edge was queued with is a lower bound.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/simplify/edge_queue.h"
#include "common/simplify/surface.h"

namespace lodestream::simplify {

class Worker {
  public:
    // An edge is merged although its cost has grown since it was queued, by up to `slack` (at least 1): far fewer edges
    // are queued twice.
    Worker(Surface& surface, Log& log, float slack) : surface_(surface), log_(log), slack_(slack) {}

    // Queues the edges between `positions` where `in_region` (of every position of the surface) says so of both ends.
    // Edges are tried by the rules below `rules_limit`.
    void start(std::span<const std::uint32_t> positions, const std::vector<std::uint8_t>& in_region,
               std::uint8_t rules_limit);

    // The cheapest merge that may be made now, or one that costs little more.
    Merge next();
    // pre: next() gave `merge`. Makes it, or has its edge tried by the next rules. Returns the number of triangles that
    // vanished.
    std::size_t take(const Merge& merge, std::size_t max_vanishing);
    // pre: next() gave a merge. Its edge is not looked at again.
    void skip() { queue_.pop(); }
    // Edges that were refused may be tried by all rules again. Returns whether there are any.
    bool retry_refused();

  private:
    Surface& surface_;
    Log& log_;
    const float slack_;
    std::uint8_t rules_limit_ = refused;
    EdgeQueue queue_;                          // each edge at most once
    std::vector<EdgeHandle> refused_edges_;    // by some rules at least
    std::vector<EdgeHandle> exhausted_edges_;  // by all rules: not in the heap
    Surface::Scratch scratch_;
};

}  // namespace lodestream::simplify
