// A client's camera and canvas, and how large an error shows on it.
#pragma once

#include <cstdint>

#include "common/base/math.h"
#include "common/base/result.h"

namespace lodestream::scene {

struct View {
    Vec3d eye{0.0};
    Vec3d target{0.0, 0.0, -1.0};
    Vec3d up{0.0, 1.0, 0.0};
    double fov_y_deg = 45.0;
    std::uint32_t width = 800, height = 600;  // of the canvas, pixels
    double near = 0.1;                        // model units; nothing nearer is drawn
};

// Refuses non-finite numbers, an eye at its target, an up along the view, an angle outside [1, 170], an empty canvas,
// a near plane that is not in front of the eye.
Status validate(const View& view);

// With +y upwards, or +x where it looks along y. pre: eye is not target
View view_towards(const Vec3d& eye, const Vec3d& target);

// Where the motion that led from `before` to `now` leads in `steps` times the time between them, with eye and direction
// going on evenly. `now` itself where that is no valid view. pre: validate() of both, steps >= 0
View ahead_of(const View& before, const View& now, double steps);

// A view made ready for many boxes. pre: validate(view)
class Projection {
  public:
    explicit Projection(const View& view);

    // Whether any of the box can be on the canvas; now and then true for one that is just outside.
    bool sees(const Box& box) const;

    // Pixels that a displacement of `error` anywhere in the part of the box that is on the canvas can measure on it, as
    // far as it is parallel to it: error * focal length / the least depth. 0 for a box that is not seen; finite, for
    // the near plane bounds the depth. A box within another never shows a larger error.
    double error_px(const Box& box, double error) const;

    // error_px() times the pixels that the box covers: what the picture is off by there. A box counts as a square as
    // wide as its diagonal shows, and as the canvas at most.
    double picture_error(const Box& box, double error) const;

  private:
    struct Plane {
        Vec3d normal;  // inwards; of unit length
        double offset;
    };
    double least_depth(const Box& box) const;

    Vec3d eye_, forward_;
    Plane planes_[5];  // near, left, right, bottom, top
    double near_, focal_px_, corner_cosine_, canvas_px_;
};

}  // namespace lodestream::scene
