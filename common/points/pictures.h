// What levels of triangles and of points are off in pictures, by one measure for both: small pictures from all around,
// in software, beside those of the full model. Distances cannot tell which of the two shows less of its error: a
// triangle shades its whole area smoothly, a disc in one colour.
//
// The pictures are orthographic, frame the model, and show the surface at the middles of pixels, each lit as the
// renderer lights it (shading::Phong). So what a level is off does not follow from their size; how large an object is
// on the screen matters only as far as fewer points are worth drawing there.
#pragma once

#include <cstdint>
#include <memory>

#include "common/base/math.h"
#include "common/mesh/mesh.h"
#include "common/points/point_cloud.h"
#include "common/points/resample.h"
#include "common/simplify/executor.h"

namespace lodestream::points {

inline constexpr std::uint32_t picture_side = 128;  // px
inline constexpr std::size_t picture_views = 8;     // directions, spread evenly

// What is drawn. Colours are linear; ones that are all the same may be left out on both sides.
struct Surface {
    const mesh::Mesh& mesh;
    ColorAt color{};       // empty: white
    bool is_flat = false;  // else Gouraud, where the mesh has normals
};
struct Discs {
    const PointCloud& cloud;
    std::uint64_t count = 0;  // its first
    double radius = 0.0;      // model units
};

class Pictures {
  public:
    // Draws the full model; nothing of it is kept.
    explicit Pictures(const Surface& full, const simplify::Executor& executor = {});
    ~Pictures();
    Pictures(Pictures&&) noexcept;
    Pictures& operator=(Pictures&&) noexcept;

    // RMS over the pixels that the full model covers, of steps from black to white; above 1 where a level covers much
    // that the model does not. 0 where the model covers no pixel. May run from any thread.
    double error(const Surface& level) const;
    double error(const Discs& level) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace lodestream::points
