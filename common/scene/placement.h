// Where an object of a scene is, against where its source puts it, and what a picture that shows it at one place is off
// while it is at another.
#pragma once

#include "common/base/math.h"
#include "common/base/result.h"

namespace lodestream::scene {

inline constexpr double max_coordinate = 1e12;  // model units; farther a placement moves nothing
inline constexpr double max_scale = 1e6;        // of a placement; the least is its inverse

struct Placement {
    Mat4d matrix{1.0};  // from the world as the source has it to where it is now; affine
    bool visible = true;

    bool operator==(const Placement&) const = default;
};

// Refuses numbers that are not finite, matrices that are not affine, lengthen a vector by more than max_scale or
// flatten space to less than its inverse, or move the origin farther than max_coordinate.
Status validate(const Placement& placement);

// First `inner`, then `outer`: an object's place is that of its node within those of the nodes above.
Placement combined(const Placement& outer, const Placement& inner);

// The smallest box around a placed one. An empty one stays empty.
Box placed(const Box& box, const Mat4d& matrix);

// What the matrix lengthens a vector by at most. pre: affine, finite
double largest_scale(const Mat4d& matrix);

// What showing an object at `shown` is off while it is at `is`, model units at most. `box` holds the object at its
// source's place. A place of it moves by so much; where it moves by more than its own extent, or is shown at one of
// both alone, that is what a picture has too much or lacks: its extent, as 3D Tiles reckons for what is not drawn.
double displacement(const Box& box, const Placement& shown, const Placement& is);

}  // namespace lodestream::scene
