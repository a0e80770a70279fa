#include "common/scene/select.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <limits>

namespace lodestream::scene {

namespace {

constexpr std::size_t max_waiting = 64;   // nodes that do not fit before the rest is taken not to fit either
constexpr std::size_t packed_nodes = 64;  // around the place in the order where the budget ends; bits of a set
constexpr std::size_t max_choices = 64;   // kept of what could be done with some of them

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

// What refining some of the packed nodes costs and takes off the error on the screen.
struct Choice {
    std::int64_t gain = 0;
    double drop_px = 0.0;
    std::uint64_t nodes = 0;  // a bit for each
};
using Choices = std::vector<Choice>;  // each dearer and better than the one before

// One of each list together. Of those within `limit` the ones that none is both cheaper and better than, thinned out
// evenly where they are too many.
Choices joined(const Choices& a, const Choices& b, std::int64_t limit) {
    Choices all;
    for (const Choice& x : a)
        for (const Choice& y : b)
            if (x.gain + y.gain <= limit) all.push_back({x.gain + y.gain, x.drop_px + y.drop_px, x.nodes | y.nodes});
    std::sort(all.begin(), all.end(), [](const Choice& x, const Choice& y) {
        return x.gain != y.gain ? x.gain < y.gain : x.drop_px > y.drop_px;
    });
    Choices best;
    for (const Choice& choice : all)
        if (best.empty() || choice.drop_px > best.back().drop_px) best.push_back(choice);
    if (best.size() <= max_choices) return best;
    Choices some;
    for (std::size_t k = 0; k < max_choices; ++k) some.push_back(best[k * (best.size() - 1) / (max_choices - 1)]);
    return some;
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
        pack();
        fill();
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
        close_orphans();
    }

    // Largest error first, until the next one does not fit: what is refined now depends on no threshold.
    void refine() {
        std::make_heap(open_.begin(), open_.end(), is_after);
        while (may_refine() && charged_ + open_.front().gain <= budget_) refine_front();
        threshold_px_ = open_.empty() ? 0.0 : open_.front().error_px;
    }

    // Around the place where the budget ended, the set of refinements that takes most off the error on the screen
    // within it: a knapsack, in which a node needs its parent. Neither this nor what fill() adds is part of what the
    // next frame starts from.
    void pack() {
        if (open_.empty() || refined_.size() + packed_nodes > options_.max_refinements) return;
        reopen(packed_nodes / 2);
        const std::vector<Candidate> items = next_in_order(packed_nodes);
        const std::uint64_t chosen = best_set(items);
        for (std::size_t i = 0; i < items.size(); ++i) {
            if (chosen >> i & 1)
                take(items[i]);
            else
                open_.push_back(items[i]);
        }
        close_orphans();
        std::make_heap(open_.begin(), open_.end(), is_after);
    }

    // What is below a node that is refined no longer is not open.
    void close_orphans() {
        std::erase_if(open_, [&](const Candidate& c) { return c.node != 0 && !is_refined_[tree_[c.node].parent]; });
    }

    // Takes back the last refinements in the order, so many at most.
    void reopen(std::size_t count) {
        const std::size_t kept = refined_.size() - std::min(count, refined_.size());
        std::nth_element(refined_.begin(), refined_.begin() + static_cast<std::ptrdiff_t>(kept), refined_.end(),
                         is_before);
        while (refined_.size() > kept) {
            open_.push_back(refined_.back());
            take_back(refined_.size() - 1);
        }
        close_orphans();
        std::make_heap(open_.begin(), open_.end(), is_after);
    }

    // As if each were refined; what is below them is open then.
    std::vector<Candidate> next_in_order(std::size_t count) {
        std::vector<Candidate> items;
        while (items.size() < count && !open_.empty()) {
            items.push_back(pop_front());
            open_children(items.back().node);
        }
        return items;
    }

    std::uint64_t best_set(const std::vector<Candidate>& items) const {
        const std::int64_t room = budget_ - spent_;
        std::int64_t limit = room;
        for (const Candidate& item : items) limit -= std::min<std::int64_t>(item.gain, 0);
        std::vector<Choices> with_below(items.size(), Choices{{}});  // of what is below a node, and at last with it
        Choices of_all{{}};
        for (std::size_t i = items.size(); i-- > 0;) {
            const Choice itself{items[i].gain, drop_px(items[i]), std::uint64_t{1} << i};
            Choices choices = joined(with_below[i], {itself}, limit);
            choices.insert(choices.begin(), Choice{});
            const auto parent = std::find_if(
                items.begin(), items.begin() + static_cast<std::ptrdiff_t>(i),
                [&](const Candidate& c) { return items[i].node != 0 && c.node == tree_[items[i].node].parent; });
            const bool has_parent = parent != items.begin() + static_cast<std::ptrdiff_t>(i);
            Choices& above = has_parent ? with_below[static_cast<std::size_t>(parent - items.begin())] : of_all;
            above = joined(above, choices, limit);
        }
        std::uint64_t best = 0;
        for (const Choice& choice : of_all)
            if (choice.gain <= room) best = choice.nodes;
        return best;
    }

    // What refining a node takes off the sum of the cut's errors; negative where its children's sum is larger.
    double drop_px(const Candidate& item) const {
        double drop = item.error_px;
        for_each_child(item.node, [&](std::uint32_t child) {
            drop -= projection_.error_px(tree_[child].box, tree_[child].error);
        });
        return drop;
    }

    // Smaller ones that fit.
    void fill() {
        for (std::size_t waiting = 0; may_refine() && waiting < max_waiting;) {
            if (spent_ + open_.front().gain <= budget_) {
                refine_front();
            } else {
                pop_front();
                ++waiting;
            }
        }
    }

    bool may_refine() const { return !open_.empty() && refined_.size() < options_.max_refinements; }

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
        open_children(next.node);
    }

    void open_children(std::uint32_t node) {
        for_each_child(node, [&](std::uint32_t child) {
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
    std::int64_t spent_ = 0, charged_ = 0;
    double threshold_px_ = 0.0;
};

}  // namespace

Selection select(std::span<const LodNode> tree, const View& view, const SelectOptions& options) {
    assert(!tree.empty());
    return Refiner(tree, view, options).run();
}

}  // namespace lodestream::scene
