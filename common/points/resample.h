// A mesh becomes points, after "point-cloud LOD for low-level GPUs": six orthographic views along the axes, each cut
// into T1 slices that are drawn into images of T3 pixels a side; what a pixel hits becomes a point.
//
// As it is done here, the paper's slips mended (seeds-digest §3): exactly T1 slices cover the whole extent, and both
// directions of an axis see all of them. The two look at the same hits, so an axis is drawn once and each slice keeps,
// pixel by pixel, what is nearest to either end. A point lies at the pixel's centre and at the depth of the hit itself,
// not of its slice. The paper's point size T2 is one pixel: a triangle that falls between the pixel centres of all
// views is drawn as such a point, so needles and specks stay. Wider points would only thicken the model; how large a
// point is on the screen is for the renderer (Level::radius).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/points/point_cloud.h"
#include "common/simplify/executor.h"

namespace lodestream::points {

inline constexpr std::uint32_t max_side = 2048;    // px of an image
inline constexpr std::uint32_t max_slices = 2048;  // as many as pixels: cells are cubes

struct Parameters {
    std::uint32_t slices = 1;  // T1, along the longest side of the mesh's box, in [1, max_slices]
    std::uint32_t side = 1;    // T3, pixels along that side, in [1, max_side]
};

inline constexpr double oversampling = 2.0;       // points drawn for each one of the budget, so that order() can choose
inline constexpr double samples_per_pixel = 2.0;  // along a side: finer ones could not be told apart

// Parameters with which resample() gives about oversampling * `budget` points, and no more than a picture in which the
// mesh's longest side covers `pixels` can show; 0: not known.
Parameters choose_parameters(const mesh::Mesh& mesh, std::uint64_t budget, std::uint32_t pixels = 0);

// How a hole in a slice is told from the space around: by what its eight neighbours show within a slice of each other.
// Pixels here show what lies at their centres exactly, so few holes are left to close: on the paper's five models each
// filter thickens outlines more than it closes holes (lodestream_bench_points --parameters), the median most.
enum class HoleFilter {
    none,
    median,    // the paper's choice: five neighbours, at the median of their depths
    gaussian,  // weights 2 beside and 1 across a corner, half of the kernel's sum; at their mean depth
    opposites  // two on opposite sides, at their mean depth: closes cracks in any direction, however thin their sides
};

// The colour of a point on a triangle; `weights` of its corners, summing to 1.
using ColorAt = std::function<Rgba8(std::size_t triangle, const Vec3f& weights)>;

struct ResampleOptions {
    HoleFilter filter = HoleFilter::none;
    ColorAt color;  // called from any thread; empty: the mesh's own colours, where it has them
    simplify::Executor executor;
};

// Points of the mesh's surface with the mesh's normals, or its faces' where it has none. What cannot be seen from
// outside is left out: points that are no view's outermost and that no way from outside leads to through cells of a
// 128th of the extent. The same for every executor. Memory: at most about 100 bytes for each triangle and pixel hit.
// At most max_points; empty for a mesh without triangles.
PointCloud resample(const mesh::Mesh& mesh, const Parameters& parameters, const ResampleOptions& options = {});

struct ViewSize {
    std::uint32_t width = 1, height = 1;  // px
    double slice_px = 1.0;                // thickness of a slice
    std::uint32_t slices = 1;             // along the longest side
};

// One axis' view, for whoever draws it. Slice i has the depths from i * slice_px, and the last one the far end too.
struct SlicedView {
    ViewSize size;
    std::span<const std::array<Vec3f, 3>>
        triangles;  // corners: x and y in px from the picture's corner, depth likewise
};

struct Seen {
    std::uint32_t pixel = 0;  // y * width + x
    std::uint32_t triangle = 0;
};

// What each slice shows, pixel by pixel, nearest to either end of the axis; one that is both comes once.
using DrawSlices = std::function<Result<std::vector<Seen>>(const SlicedView& view)>;

// The same with views that a GPU draws (client/render/slices.h). Pixels whose centres lie within the GPU's own
// precision of an edge, 1/256 px as a rule, may show another triangle. Errors: those of `draw`; internal where it names
// a pixel or a triangle that is not there.
Result<PointCloud> resample(const mesh::Mesh& mesh, const Parameters& parameters, const DrawSlices& draw,
                            const ResampleOptions& options = {});

}  // namespace lodestream::points
