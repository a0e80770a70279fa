// Moving the border between Gouraud and flat while the camera moves, without flicker: a distance step holds until it is
// left by a margin, and one frame moves the border no farther than a bound on the picture's change allows.
#pragma once

#include <cstdint>
#include <span>

#include "common/shading/view.h"

namespace lodestream::shading {

struct SplitControlOptions {
    // Of a distance step: how far past an edge the distance must go before the step changes. [0, 1)
    double hysteresis = 0.25;
    // The greatest root mean square change of the picture by one frame's move, in display units [0, 1], over a disc as
    // large as the bounding sphere at its nearest point. > 0. Smaller is calmer, and slower to arrive.
    double max_change = 1.0 / 255.0;
};

// What the border may move over. Both are the level's own and do not change with the view.
struct SplitCurve {
    std::span<const double> difference_left;  // as importance.h has it without a view; size n + 1, falling
    double radius = 0.0;                      // of the bounding sphere, model units
};

struct SplitState {
    std::uint32_t step = 0;     // of the distance, in [0, steps]
    std::uint64_t gouraud = 0;  // triangles, a prefix of the importance order
};

struct SplitMove {
    SplitState state;
    // The bound on this frame's change: the sum over the moved triangles of the greatest squared difference times their
    // area, model units². At most max_change² * π * radius², or what the one most important triangle moved takes where
    // that alone is more, so that the border always arrives.
    double squared_change = 0.0;
};

// The state with the border where it belongs at once: for the first frame.
SplitState settled_split(double continuous_distance, std::uint32_t steps, std::uint64_t triangles);

// The state on another level: the same step, and the same share of its triangles.
SplitState on_level(const SplitState& state, std::uint64_t triangles_before, std::uint64_t triangles);

// One frame. `continuous_distance` is view.h's, `steps` the device's. Finite for any input; O(log n).
SplitMove move_split(const SplitState& state, double continuous_distance, std::uint32_t steps, const SplitCurve& curve,
                     const SplitControlOptions& options = {});

}  // namespace lodestream::shading
