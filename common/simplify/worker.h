// Merges the cheapest edges of a region first, nearly: an edge is looked at again when it comes up, not when something
// near it changes. Costs mostly grow, so what an edge was queued with is a lower bound.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

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
    void skip() { pop(); }
    // Edges that were refused may be tried by all rules again. Returns whether there are any.
    bool retry_refused();

  private:
    // By cost, then by edge: floats that are not negative are ordered as their bits are.
    struct Entry {
        std::uint64_t bits;
        Entry(float cost, EdgeHandle edge)
            : bits(std::uint64_t{std::bit_cast<std::uint32_t>(cost)} << 32 | index_of(edge)) {}
        float cost() const { return std::bit_cast<float>(static_cast<std::uint32_t>(bits >> 32)); }
        EdgeHandle edge() const { return EdgeHandle(static_cast<int>(bits & 0xffffffffu)); }
        bool operator<(const Entry& o) const { return bits < o.bits; }
    };
    void push(EdgeHandle edge);
    void pop();
    void sink(std::size_t place, const Entry& entry);

    Surface& surface_;
    Log& log_;
    const float slack_;
    std::uint8_t rules_limit_ = refused;
    std::vector<Entry> heap_;                  // each edge at most once, the cheapest first
    std::vector<EdgeHandle> refused_edges_;    // by some rules at least
    std::vector<EdgeHandle> exhausted_edges_;  // by all rules: not in the heap
    Surface::Scratch scratch_;
};

}  // namespace lodestream::simplify
