// A criterion that does not depend on where the light is: how much a picture could change, under any light and for any
// viewer, if a triangle were flat instead of Gouraud shaded.
//
// Flat shading lights a triangle by its own normal f, Gouraud shading by the normals n at its corners. At a corner
// whose normal stands at an angle θ to f, Lambert's term differs by at most sin θ (1 from 90° on; reached where the
// light grazes f), and the mirrored ray turns by 2θ, over which cos^s falls by at most 2θ times its steepest slope.
// Displayed (sRGB), the step is largest where the corner is darkest, lit by the ambient part alone, for the curve is
// concave. So every corner has a greatest difference δ in display units; between corners it is at most their blend,
// whose square integrates over the area A to A/12 * (δ1² + δ2² + δ3² + (δ1 + δ2 + δ3)²). Not in the bound: the
// highlight that goes out at once where the light passes below the horizon, and textures (the base colour stands for
// them).
//
// That is how much the picture changes, not how much nearer it comes: beside a crease, normals blended over a coarse
// triangle are farther from the surface than its own. Both ends of an edge lie on the surface, so along the edge its
// slope is 0 in the mean; blended normals have the mean q = e · (n_i + n_j) / 2 along the unit edge e, exactly 0 on any
// quadratic surface. So they are off by b, b² = 2/3 Σq² over the three edges (a vector's mean square along a direction
// of the plane is half its square). What they gain is the mean square of r = n - f, (Σ|r|² + |Σr|²) / 12, less b² for
// what they are off and b² for what was no true difference: the difference counts 1 - 16 Σq² / (Σ|r|² + |Σr|²), which
// may be less than nothing.
//
// Where a finer surface is at hand, what is gained is measured instead (normal_errors.h): the squared error of flat
// shading less that of Gouraud shading, times the square of what the display makes of a small turn of a normal. On 25
// models the triangles so chosen bring a picture two to three times as much nearer as those that the level's own
// normals tell.
//
// A Gouraud triangle costs the same wherever it lies (Table 3: 4 against 1), so with a price on the number of Gouraud
// triangles the first k of the falling order are the choice of k that gains most: one order serves every split as a
// prefix, and moving the split sorts nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/mesh/mesh.h"
#include "common/shading/normal_errors.h"
#include "common/shading/operation_counts.h"
#include "common/shading/phong.h"
#include "common/shading/view.h"

namespace lodestream::shading {

// Of a triangle that shows its back, on a material that is not double-sided: most of them are hidden by the front.
inline constexpr double turned_away_share = 1.0 / 16.0;

struct ImportanceOptions {
    Phong phong{};
    std::optional<View> view{};            // absent: triangles weigh by their area, for a viewer who may be anywhere
    Vec3d origin{0.0};                     // where the mesh's (0,0,0) lies in the view's world
    const NormalErrors* errors = nullptr;  // of the mesh's triangles; absent: estimated from their own normals
};

struct Importance {
    // One a triangle: the greatest integral of the squared difference, mean over R, G and B in display units [0, 1].
    // Over its area in square model units; with a view over the share of the unit sphere around the eye that it covers,
    // in steradians. Finite and >= 0 for any input.
    std::vector<double> difference;
    // What Gouraud shading brings the picture nearer, likewise: an integral of squares; less than nothing where flat is
    // nearer. Estimated it lies between -difference and difference.
    std::vector<double> gain;
    double facet_error = 0.0;    // what the picture is off where all is flat, in the unit of the gains
    OperationCounts operations;  // nine a triangle, as many as the paper's criterion takes
};

Importance importance(const mesh::Mesh& mesh, const std::vector<mesh::Material>& materials,
                      const ImportanceOptions& options = {});

// Triangles by falling gain. Ties: lower index.
std::vector<std::uint32_t> order_by_gain(std::span<const double> gain);

// [k]: the sum of the differences of all but the first k of `order`, falling to 0; size n + 1: what a picture may still
// change by. pre: `order` is a permutation of the triangles
std::vector<double> difference_left(std::span<const double> difference, std::span<const std::uint32_t> order);

// How many triangles are worth their Gouraud shading where each costs further triangles, three by Table 3, that would
// refine the whole level instead. Near a model's own number of triangles a flat picture's squared error falls with up
// to the third power of theirs, where there are many less with less than the first; facets are half to all of it. The
// dearest is taken, three times three of n: what is bought then seldom loses.
inline constexpr double least_gain_in_mean_errors = 9.0;
std::uint64_t worth_gouraud(const Importance& importance);

// The greatest difference of a corner in display units, a channel of base colour `color` in [0, 1]: its normal stands
// `degrees_apart` from the face's. In [0, 1], never falling with the angle.
double greatest_difference(double degrees_apart, double color, const Phong& phong);

}  // namespace lodestream::shading
