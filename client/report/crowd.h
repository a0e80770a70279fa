// The point-cloud paper's test of its levels: many instances of one model on a grid, each as the points that its
// distance asks for, against the same picture of full models; a camera moves around them on spheres (§4.6, Table 12:
// 1,331 instances, recall, precision and F of the silhouettes, pixel by pixel).
//
// The paper gives neither spacings, canvas nor steps. Here lengths are radii of the model's bounding sphere, which the
// paper's distances of 30 to 360 fit well: 11 instances a side, 2.5 apart, reach 22 from the middle.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "client/render/renderer.h"
#include "client/report/silhouette.h"
#include "common/budget/budget.h"

namespace lodestream::report {

inline constexpr std::size_t crowd_levels = 5;
// Distances of the eye, radii, from which on the next level is drawn.
inline constexpr std::array<double, crowd_levels> level_distances{0.0, 25.0, 50.0, 100.0, 200.0};
inline constexpr std::array<double, 5> orbit_distances{30.0, 60.0, 120.0, 240.0, 360.0};  // radii
inline constexpr double crowd_spacing = 2.5;                                              // radii

struct CrowdOptions {
    std::uint32_t side = 11;             // instances along each axis
    std::uint32_t directions = 26;       // of each orbit, spread evenly
    budget::Display canvas{1024, 1024};  // px
};

// Everything drawn is black, on white: what a material emits aside, only the silhouette is left.
render::DrawOptions silhouette_options(const budget::Display& canvas);

// The full model and the points that stand for it, uploaded to their renderer.
struct CrowdModel {
    const SilhouetteTree& full;
    render::Renderer& points;
    Box bounds;                                        // world
    std::array<std::uint64_t, crowd_levels> levels{};  // points, finest first
};

// Pixels, summed over pictures.
struct SilhouetteScore {
    std::uint64_t both = 0, points_alone = 0, full_alone = 0;

    double recall() const;     // 1 where nothing is to be seen
    double precision() const;  // likewise
    double f_measure() const;
    void add(const SilhouetteScore& other);
};

// pre: of the same size
SilhouetteScore match(const Mask& points, const Mask& full);

struct CrowdScore {
    SilhouetteScore all;                                  // the whole crowd in one picture
    std::array<SilhouetteScore, crowd_levels> by_level;   // the instances of that level alone, against full models
    std::array<std::uint64_t, crowd_levels> instances{};  // drawn, over all pictures
};

// `going_on` is asked before each picture. Errors: of drawing; invalid_input (a crowd so large that it reaches the
// nearest orbit); unavailable (told to stop).
Result<CrowdScore> score_crowd(CrowdModel& model, const CrowdOptions& options,
                               const std::function<bool()>& going_on = {});

// A level goes over into the next coarser one along this last share of its distances.
inline constexpr double level_fade = 0.1;

enum class LevelChange { at_once, fading };

// The instances of a grid around the model's own place, each at the level of its distance from `eye`, or twice, at two
// levels that share the samples out, while it fades.
std::vector<render::Instance> crowd_of(const CrowdModel& model, const std::array<std::uint32_t, 3>& sides,
                                       const Vec3d& eye, LevelChange change = LevelChange::at_once);
}  // namespace lodestream::report
