// How the cut on the screen goes over into the one that is drawn next: each node that is replaced fades into what
// replaces it, by dither (client/render/renderer.h), so that at every threshold of the dither exactly one of both is
// drawn.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/scene/lod_tree.h"
#include "common/scene/view.h"

namespace lodestream::scene {

// Levels of one part of the tree: a node and nodes below it, either way round.
struct Transition {
    std::uint32_t top = none;
    std::vector<std::uint32_t> going, coming;  // each covers what is below `top` once
    double progress = 0.0;                     // 0: `going` alone, 1: `coming` alone
};

// What is on the screen.
struct Fading {
    std::vector<std::uint32_t> settled;   // nodes in no transition
    std::vector<Transition> transitions;  // of parts of the tree that are apart
    std::vector<Transition> unseen;  // in the last frame: gone over at once, for they were not on the screen before
    std::optional<View> view;        // of the last frame
};

// Drawn at thresholds from <= t < to of [0, 1).
struct FadingNode {
    std::uint32_t node = 0;
    double from = 0.0;
    double to = 1.0;
};

// One frame, `step` of a whole transition later (1 or more: at once). What differs between the screen and `cut` begins
// a transition; a part of the tree that is in one already ends that first, so that nothing turns back half-way. What
// this view or the one before does not see goes over at once. The nodes of `Fading` must stay until the next frame:
// Fading's shown_nodes(). Returns what is drawn: at each threshold a cut. pre: validate(tree), `cut` is a cut, the same
// tree each time
std::vector<FadingNode> fade(std::span<const LodNode> tree, Fading& fading, std::span<const std::uint32_t> cut,
                             const View& view, double step);

// Everything on the screen, going and coming.
std::vector<std::uint32_t> shown_nodes(const Fading& fading);

// What the screen goes over to: settled nodes and those that come. A cut.
std::vector<std::uint32_t> coming_nodes(const Fading& fading);

}  // namespace lodestream::scene
