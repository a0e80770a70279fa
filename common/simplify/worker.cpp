#include "common/simplify/worker.h"

#include <algorithm>

namespace lodestream::simplify {

namespace {

constexpr std::size_t branches = 4;  // of the heap: flatter than two, fewer cache lines a level

}  // namespace

// Puts the entry at `place` or, while one below is less, below it.
void Worker::sink(std::size_t place, const Entry& entry) {
    for (;;) {
        const std::size_t first = place * branches + 1, last = std::min(first + branches, heap_.size());
        if (first >= last) break;
        std::size_t least = first;
        for (std::size_t child = first + 1; child < last; ++child) least = heap_[child] < heap_[least] ? child : least;
        if (!(heap_[least] < entry)) break;
        heap_[place] = heap_[least];
        place = least;
    }
    heap_[place] = entry;
}

void Worker::push(EdgeHandle edge) {
    const Entry entry(key_of_cost(surface_.offer(edge).cost), edge);
    std::size_t place = heap_.size();
    heap_.push_back(entry);
    while (place > 0 && entry < heap_[(place - 1) / branches]) {
        heap_[place] = heap_[(place - 1) / branches];
        place = (place - 1) / branches;
    }
    heap_[place] = entry;
}

void Worker::pop() {
    const Entry last = heap_.back();
    heap_.pop_back();
    if (!heap_.empty()) sink(0, last);
}

void Worker::start(std::span<const std::uint32_t> positions, const std::vector<std::uint8_t>& in_region,
                   std::uint8_t rules_limit) {
    rules_limit_ = rules_limit;
    const SheetMesh& sheets = surface_.sheets();
    for (const std::uint32_t position : positions) {
        if (!in_region[position]) continue;
        sheets.for_each_outgoing(position, [&](HalfedgeHandle h) {
            const std::uint32_t end = sheets.to(h);
            if (end < position || !in_region[end]) return;
            const EdgeHandle edge = SheetMesh::edge(h);
            heap_.emplace_back(key_of_cost(surface_.offer(edge).cost), edge);
        });
    }
    for (std::size_t place = heap_.size() / branches + 1; place-- > 0;)
        if (place < heap_.size()) sink(place, Entry(heap_[place]));
}

Merge Worker::next() {
    while (!heap_.empty()) {
        const Entry top = heap_.front();
        const EdgeHandle edge = top.edge();
        if (!surface_.sheets().is_live(edge)) {
            pop();
            continue;
        }
        if (surface_.rules_of(edge) >= rules_limit_) {
            exhausted_edges_.push_back(edge);
            pop();
            continue;
        }
        const Merge merge = surface_.offer(edge);
        const float cost = key_of_cost(merge.cost);
        if (cost <= slack_ * top.cost()) return merge;
        sink(0, Entry(cost, edge));
        if (heap_.front().edge() == edge) return merge;
    }
    return Merge{};
}

std::size_t Worker::take(const Merge& merge, std::size_t max_vanishing) {
    const EdgeHandle edge = SheetMesh::edge(merge.edge);
    if (!surface_.merge(merge, max_vanishing, log_, scratch_)) {
        if (surface_.rules_of(edge) == 0) refused_edges_.push_back(edge);
        surface_.refuse(edge, static_cast<std::uint8_t>(merge.rules - rule_levels.data()));
        return 0;
    }
    pop();
    return scratch_.vanished;
}

bool Worker::retry_refused() {
    std::vector<EdgeHandle> again;
    again.swap(refused_edges_);
    bool any = false;
    for (const EdgeHandle edge : again) {
        if (!surface_.sheets().is_live(edge)) continue;
        surface_.allow(edge);
        any = true;
    }
    again.clear();
    again.swap(exhausted_edges_);
    for (const EdgeHandle edge : again)
        if (surface_.sheets().is_live(edge)) push(edge);
    return any;
}

}  // namespace lodestream::simplify
