// A queue of edges, the cheapest first, to within a sixteenth: one stack for each run of costs (a bucket queue), so
// that neither putting in nor taking out compares anything, and what was put in side by side comes out side by side.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "common/simplify/sheet_mesh.h"

namespace lodestream::simplify {

class EdgeQueue {
  public:
    EdgeQueue() : top_(stacks, none) {}

    void reserve(std::size_t edges) { entries_.reserve(edges); }

    // `cost`: at least 0 and finite. An edge may not be in the queue twice.
    void push(EdgeHandle edge, float cost) {
        const std::uint32_t stack = stack_of(cost);
        cheapest_ = std::min(cheapest_, stack);
        std::uint32_t entry = free_;
        if (entry == none) {
            entry = static_cast<std::uint32_t>(entries_.size());
            entries_.emplace_back();
        } else {
            free_ = entries_[entry].below;
        }
        entries_[entry] = {edge, top_[stack]};
        top_[stack] = entry;
    }

    // Returns whether there is an edge; front() and what follows want one.
    bool find_front() {
        while (cheapest_ < stacks && top_[cheapest_] == none) ++cheapest_;
        return cheapest_ < stacks;
    }
    EdgeHandle front() const { return entries_[top_[cheapest_]].edge; }
    float front_cost() const { return cost_of(cheapest_ + 1); }  // at most
    void pop() {
        const std::uint32_t entry = top_[cheapest_];
        top_[cheapest_] = entries_[entry].below;
        entries_[entry].below = free_;
        free_ = entry;
    }

  private:
    // Floats that are not negative are ordered as their bits are: a power of two is parted in 16.
    static constexpr unsigned dropped_bits = 19;
    static constexpr std::uint32_t stacks = (0x7f800000u >> dropped_bits) + 1;
    static std::uint32_t stack_of(float cost) { return std::bit_cast<std::uint32_t>(cost) >> dropped_bits; }
    static float cost_of(std::uint32_t stack) { return std::bit_cast<float>(stack << dropped_bits); }

    struct Entry {
        EdgeHandle edge;
        std::uint32_t below = none;
    };
    std::vector<Entry> entries_;
    std::vector<std::uint32_t> top_;  // of each stack
    std::uint32_t free_ = none;       // the first of the entries that are not in use
    std::uint32_t cheapest_ = stacks;
};

}  // namespace lodestream::simplify
