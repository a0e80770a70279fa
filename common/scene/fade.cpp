#include "common/scene/fade.h"

#include <algorithm>
#include <cassert>
#include <map>

namespace lodestream::scene {

namespace {

using Nodes = std::vector<std::uint32_t>;

std::vector<bool> marked(std::span<const LodNode> tree, std::span<const std::uint32_t> nodes) {
    std::vector<bool> is_marked(tree.size(), false);
    for (const std::uint32_t node : nodes) is_marked[node] = true;
    return is_marked;
}

// The marked node at or above `node`, or none.
std::uint32_t above(std::span<const LodNode> tree, const std::vector<bool>& is_marked, std::uint32_t node) {
    while (node != none && !is_marked[node]) node = tree[node].parent;
    return node;
}

// What the screen and the cut have differently, each under its highest node.
std::vector<Transition> differences(std::span<const LodNode> tree, const Nodes& screen,
                                    std::span<const std::uint32_t> cut) {
    const std::vector<bool> on_screen = marked(tree, screen), in_cut = marked(tree, cut);
    std::map<std::uint32_t, Transition> by_top;
    for (const std::uint32_t node : screen) {
        if (in_cut[node]) continue;
        const std::uint32_t coarser = above(tree, in_cut, node), top = coarser == none ? node : coarser;
        by_top[top].going.push_back(node);
        if (coarser != none) by_top[top].coming = {coarser};
    }
    for (const std::uint32_t node : cut) {
        const std::uint32_t coarser = on_screen[node] ? none : above(tree, on_screen, node);
        if (coarser != none) by_top[coarser].coming.push_back(node);
    }
    std::vector<Transition> found;
    for (auto& [top, transition] : by_top) {
        transition.top = top;
        found.push_back(std::move(transition));
    }
    return found;
}

void settle(Fading& fading) {
    for (const Transition& t : fading.transitions)
        if (t.progress >= 1.0) fading.settled.insert(fading.settled.end(), t.coming.begin(), t.coming.end());
    std::erase_if(fading.transitions, [](const Transition& t) { return t.progress >= 1.0; });
}

// Nodes that are not settled wait for their own transition.
void begin(std::span<const LodNode> tree, Fading& fading, std::span<const std::uint32_t> cut, const View& view,
           double step) {
    const Projection now(view), before(fading.view.value_or(view));
    const Nodes screen = coming_nodes(fading);
    std::vector<bool> is_settled = marked(tree, fading.settled);
    for (Transition& found : differences(tree, screen, cut)) {
        if (!std::all_of(found.going.begin(), found.going.end(), [&](std::uint32_t n) { return is_settled[n]; }))
            continue;
        for (const std::uint32_t node : found.going) is_settled[node] = false;
        const Box& box = tree[found.top].box;
        const bool is_seen = before.sees(box) && now.sees(box);
        found.progress = is_seen ? step : 1.0;
        if (!is_seen) fading.unseen.push_back(found);
        fading.transitions.push_back(std::move(found));
    }
    std::erase_if(fading.settled, [&](std::uint32_t node) { return !is_settled[node]; });
}

}  // namespace

std::vector<FadingNode> fade(std::span<const LodNode> tree, Fading& fading, std::span<const std::uint32_t> cut,
                             const View& view, double step) {
    assert(step > 0.0);
    for (Transition& t : fading.transitions) t.progress += step;
    settle(fading);
    fading.unseen.clear();
    if (fading.settled.empty() && fading.transitions.empty())
        fading.settled.assign(cut.begin(), cut.end());
    else if (!cut.empty())
        begin(tree, fading, cut, view, step);
    settle(fading);
    fading.view = view;
    std::vector<FadingNode> drawn;
    for (const std::uint32_t node : fading.settled) drawn.push_back({node});
    for (const Transition& t : fading.transitions) {
        for (const std::uint32_t node : t.coming) drawn.push_back({node, 0.0, t.progress});
        for (const std::uint32_t node : t.going) drawn.push_back({node, t.progress, 1.0});
    }
    return drawn;
}

std::vector<std::uint32_t> coming_nodes(const Fading& fading) {
    Nodes nodes = fading.settled;
    for (const Transition& t : fading.transitions) nodes.insert(nodes.end(), t.coming.begin(), t.coming.end());
    return nodes;
}

std::vector<std::uint32_t> shown_nodes(const Fading& fading) {
    Nodes nodes = fading.settled;
    for (const Transition& t : fading.transitions) {
        nodes.insert(nodes.end(), t.going.begin(), t.going.end());
        nodes.insert(nodes.end(), t.coming.begin(), t.coming.end());
    }
    return nodes;
}

}  // namespace lodestream::scene
