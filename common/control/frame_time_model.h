// What a frame costs on a device, first guessed and then learned while it runs: a fixed cost, the picture's pixels, for
// each exposure the triangles, those of them in view and the pixels coloured, a level change, decoding beside it.
//
// The seven parts are tracked by a Kalman filter in units of their first guess. Its process noise moves mostly all
// costs together, as throttling and other load do, so that a slower device is noticed within a few frames at any level;
// a single cost drifts slowly. A slow correction per level takes what is not linear. Outliers are clipped; several of
// them in a row, all longer or all shorter than predicted, are a change, which is followed the faster the longer it
// lasts.
#pragma once

#include <array>
#include <cstdint>

namespace lodestream::control {

inline constexpr std::size_t max_levels = 32;  // of one ladder
inline constexpr double max_frame_ms = 1e5;    // a longer one counts as that long

// Milliseconds. A guess from the probe, or these: a slow phone, so that a device is not overrun before it is known.
struct FrameCosts {
    double fixed_ms = 2.0;
    double per_million_triangles_ms = 40.0;  // wherever they are
    double per_million_pixels_ms = 1.0;      // of the picture: cleared, resolved, once however many exposures it has
    double per_million_uploaded_ms = 100.0;  // triangles of a level that was switched to
    double background_ms = 5.0;              // decoding that keeps one core busy all the frame long
    double per_million_shaded_ms = 4.0;      // px that triangles colour
    double per_million_seen_ms = 60.0;       // triangles within the picture, on top
    // What else a probe tells apart; 0: nothing, the costs above have it.
    double per_million_vertices_ms = 0.0;
    double per_million_textured_ms = 0.0;  // px of those that read an image: on top
    double per_million_extent_ms = 0.0;    // px of their sides: what a triangle costs beside its pixels grows so
};

// What a frame has to do.
struct Work {
    std::uint32_t level = 0;          // < max_levels
    double triangles = 0.0;           // of the level
    double exposures = 1.0;           // times that the scene is drawn
    double pixels = 0.0;              // of the picture
    double uploaded_triangles = 0.0;  // 0 where the level is that of the frame before
    double background_load = 0.0;     // decoding beside it, share of a core, [0, 1]
    // Of one exposure.
    double shaded_px = 0.0;       // as shading::ScreenExtent, or all pixels where that is not known
    double seen_triangles = 0.0;  // within the picture, or all where that is not known
    // Likewise; 0 where they are not known.
    double vertices = 0.0;     // that are lit
    double textured_px = 0.0;  // of shaded_px
    double extent_px = 0.0;    // likewise
};

// What the parts of that work take.
double frame_ms(const FrameCosts& costs, const Work& work);

struct FrameTimeModel {
    static constexpr std::size_t size = 7;
    using Vector = std::array<double, size>;

    FrameCosts first_guess;
    Vector share{};  // of first_guess that each part costs, starts as 1: fixed, picture, triangles, seen, shaded,
                     // uploaded, background
    std::array<Vector, size> covariance{};
    std::array<double, max_levels> level_factor{};  // on top, for that level; starts as 1
    int outliers = 0;                               // in a row; below 0: shorter than predicted
    double spread = 0.0;                            // mean deviation of measured from predicted, as a share
};

// Values that are not finite and above 0 are replaced by the defaults.
FrameTimeModel make_model(const FrameCosts& first_guess);

// Milliseconds, finite, > 0.
double predict_ms(const FrameTimeModel& model, const Work& work);

// What `spread` asks to add for about one frame in a hundred to take longer; a factor in [1.03, 1.6].
double safety_factor(const FrameTimeModel& model);

// A measurement that is not finite or not above 0 changes nothing.
FrameTimeModel learn(FrameTimeModel model, const Work& work, double measured_ms);

}  // namespace lodestream::control
