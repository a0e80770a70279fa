#include "common/scene/select.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <limits>

namespace lodestream::scene {

namespace {

constexpr std::size_t max_waiting = 64;  // nodes that do not fit before the rest is taken not to fit either

struct Candidate {
    double error_px;
    std::int64_t gain;  // triangles more in view; negative where much of the finer level is out of sight
    std::uint32_t node;
};

// Counts stay below half of what a signed number holds: see validate().
std::int64_t to_signed(std::uint64_t triangles) {
    return static_cast<std::int64_t>(std::min<std::uint64_t>(triangles, std::numeric_limits<std::int64_t>::max() / 2));
}

// The order of refinement; a parent, whose error is not smaller and whose index is, comes before its children.
bool is_before(const Candidate& a, const Candidate& b) {
    return a.error_px != b.error_px ? a.error_px > b.error_px : a.node < b.node;
}
bool is_after(const Candidate& a, const Candidate& b) {
    return is_before(b, a);
}

// A cut under way, as the nodes above it. A finer level may have fewer triangles in view, where parts of it are out of
// sight. So that the order alone decides what is refined, wherever one starts from, such a gain counts as none at first
// (`charged`); it is spent in the end.
class Refiner {
  public:
    Refiner(std::span<const LodNode> tree, const View& view, const SelectOptions& options)
        : tree_(tree),
          projection_(view),
          options_(options),
          budget_(to_signed(options.budget)),
          is_refined_(tree.size(), 0) {}

    Selection run() {
        descend();
        if (charged_ > budget_) coarsen();
        refine();
        fill();
        exchange();
        return result();
    }

  private:
    // Refines all that the threshold says, without a heap.
    void descend() {
        const double threshold = std::max(options_.start_px, options_.tolerance_px);
        std::vector<Candidate> stack{candidate(0)};
        spent_ = charged_ = cost(0);
        while (!stack.empty()) {
            const Candidate next = stack.back();
            stack.pop_back();
            if (tree_[next.node].child_count == 0) continue;
            if (next.error_px > threshold) {
                take(next);
                for_each_child(next.node, [&](std::uint32_t child) { stack.push_back(candidate(child)); });
            } else if (next.error_px > options_.tolerance_px) {
                open_.push_back(next);
            }
        }
        if (refined_.size() > options_.max_refinements) start_over();
    }

    void start_over() {
        refined_.clear();
        std::fill(is_refined_.begin(), is_refined_.end(), 0);
        spent_ = charged_ = cost(0);
        open_ = {candidate(0)};
    }

    // Takes back refinements, the last in the order first, until the budget is kept.
    void coarsen() {
        std::sort(refined_.begin(), refined_.end(), is_before);
        while (charged_ > budget_ && !refined_.empty()) {
            open_.push_back(refined_.back());
            take_back(refined_.size() - 1);
        }
        std::erase_if(open_, [&](const Candidate& c) { return c.node != 0 && !is_refined_[tree_[c.node].parent]; });
    }

    // Largest error first, until the next one does not fit: what is refined now depends on no threshold.
    void refine() {
        std::make_heap(open_.begin(), open_.end(), is_after);
        while (may_refine() && charged_ + open_.front().gain <= budget_) refine_front();
        threshold_px_ = open_.empty() ? 0.0 : open_.front().error_px;
    }

    // Smaller ones that fit. Neither they nor exchanges are part of what the next frame starts from.
    void fill() {
        while (may_refine() && waiting_.size() < max_waiting) {
            if (spent_ + open_.front().gain <= budget_)
                refine_front();
            else
                waiting_.push_back(pop_front());
        }
    }

    // Takes back refinements of smaller errors where that makes room for one of a larger error.
    void exchange() {
        std::sort(refined_.begin(), refined_.end(), is_before);
        for (const Candidate& next : waiting_) {
            if (next.node != 0 && !is_refined_[tree_[next.node].parent]) continue;
            const std::size_t least = refined_.size() > max_waiting ? refined_.size() - max_waiting : 0;
            for (std::size_t k = refined_.size(); k-- > least && refined_[k].error_px < next.error_px;) {
                const Candidate& last = refined_[k];
                if (spent_ - last.gain + next.gain > budget_ || has_refined_child(last.node)) continue;
                take_back(k);
                take(next);
                std::inplace_merge(refined_.begin(), refined_.end() - 1, refined_.end(), is_before);
                break;
            }
        }
    }

    bool may_refine() const { return !open_.empty() && refined_.size() < options_.max_refinements; }

    bool has_refined_child(std::uint32_t node) const {
        bool has = false;
        for_each_child(node, [&](std::uint32_t child) { has = has || is_refined_[child]; });
        return has;
    }

    void take(const Candidate& next) {
        refined_.push_back(next);
        is_refined_[next.node] = 1;
        spent_ += next.gain;
        charged_ += std::max<std::int64_t>(next.gain, 0);
    }

    void take_back(std::size_t which) {
        const Candidate last = refined_[which];
        refined_.erase(refined_.begin() + static_cast<std::ptrdiff_t>(which));
        is_refined_[last.node] = 0;
        spent_ -= last.gain;
        charged_ -= std::max<std::int64_t>(last.gain, 0);
    }

    Candidate pop_front() {
        std::pop_heap(open_.begin(), open_.end(), is_after);
        const Candidate front = open_.back();
        open_.pop_back();
        return front;
    }

    void refine_front() {
        const Candidate next = pop_front();
        take(next);
        for_each_child(next.node, [&](std::uint32_t child) {
            if (tree_[child].child_count == 0) return;
            const Candidate made = candidate(child);
            if (!(made.error_px > options_.tolerance_px)) return;
            open_.push_back(made);
            std::push_heap(open_.begin(), open_.end(), is_after);
        });
    }

    Selection result() const {
        Selection selection;
        const auto add = [&](std::uint32_t node) {
            if (is_refined_[node]) return;
            selection.nodes.push_back(node);
            selection.largest_error_px =
                std::max(selection.largest_error_px, projection_.error_px(tree_[node].box, tree_[node].error));
        };
        add(0);
        for (const Candidate& refined : refined_) for_each_child(refined.node, add);
        selection.spent = static_cast<std::uint64_t>(spent_);
        selection.threshold_px = threshold_px_;
        selection.feasible = spent_ <= budget_;
        return selection;
    }

    template <class Visit>
    void for_each_child(std::uint32_t node, Visit visit) const {
        const LodNode& parent = tree_[node];
        for (std::uint32_t child = parent.first_child; child < parent.first_child + parent.child_count; ++child)
            visit(child);
    }

    Candidate candidate(std::uint32_t node) const {
        const LodNode& lod = tree_[node];
        Candidate made{projection_.error_px(lod.box, lod.error), 0, node};
        if (made.error_px == 0.0 || lod.child_count == 0) return made;
        made.gain = -cost(node);
        for_each_child(node, [&](std::uint32_t child) { made.gain += cost(child); });
        return made;
    }
    std::int64_t cost(std::uint32_t node) const {
        return projection_.sees(tree_[node].box) ? to_signed(tree_[node].triangles) : 0;
    }

    std::span<const LodNode> tree_;
    Projection projection_;
    const SelectOptions& options_;
    std::int64_t budget_;
    std::vector<std::uint8_t> is_refined_;
    std::vector<Candidate> refined_, open_;  // all nodes above the cut; those of the cut that have children
    std::vector<Candidate> waiting_;         // those that do not fit, largest error first
    std::int64_t spent_ = 0, charged_ = 0;
    double threshold_px_ = 0.0;
};

}  // namespace

Selection select(std::span<const LodNode> tree, const View& view, const SelectOptions& options) {
    assert(!tree.empty());
    return Refiner(tree, view, options).run();
}

}  // namespace lodestream::scene
