#include "common/simplify/worker.h"

namespace lodestream::simplify {

void Worker::start(std::span<const std::uint32_t> positions, const std::vector<std::uint8_t>& in_region,
                   std::uint8_t rules_limit) {
    rules_limit_ = rules_limit;
    surface_.keep(positions, scratch_);
    const SheetMesh& sheets = surface_.sheets();
    queue_.reserve(3 * positions.size());  // of a closed surface
    for (const std::uint32_t position : positions) {
        if (!in_region[position]) continue;
        sheets.for_each_outgoing(position, [&](HalfedgeHandle h) {
            const std::uint32_t end = sheets.to(h);
            if (end < position || !in_region[end]) return;
            const EdgeHandle edge = SheetMesh::edge(h);
            queue_.push(edge, key_of_cost(surface_.offer(edge, scratch_).cost));
        });
    }
}

Merge Worker::next() {
    while (queue_.find_front()) {
        const EdgeHandle edge = queue_.front();
        if (!surface_.sheets().is_live(edge)) {
            queue_.pop();
            continue;
        }
        if (surface_.rules_of(edge) >= rules_limit_) {
            exhausted_edges_.push_back(edge);
            queue_.pop();
            continue;
        }
        const Merge merge = surface_.offer(edge, scratch_);
        const float cost = key_of_cost(merge.cost);
        if (cost <= slack_ * queue_.front_cost()) return merge;
        queue_.pop();
        queue_.push(edge, cost);
        queue_.find_front();
        if (queue_.front() == edge) return merge;
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
    queue_.pop();
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
        if (surface_.sheets().is_live(edge)) queue_.push(edge, key_of_cost(surface_.offer(edge, scratch_).cost));
    return any;
}

}  // namespace lodestream::simplify
