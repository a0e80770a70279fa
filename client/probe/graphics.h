// The renderer's speed: triangles Gouraud and flat, points, pixels, and what a frame costs by what it shows.
#pragma once

#include <vector>

#include "client/probe/frame_costs.h"
#include "client/probe/statistics.h"
#include "client/render/renderer.h"
#include "common/base/result.h"

namespace lodestream::probe {

// Rates are marginal: how many more can be drawn in how much more time. What a picture of the same size takes with next
// to none of them is not in them.
struct Graphics {
    Rate gouraud_triangles;     // of a few pixels each
    Rate flat_triangles;        // likewise
    Rate points;                // of a cloud, as discs of a few pixels
    Rate pixels;                // filled, each lit and written
    control::FrameCosts costs;  // of levels: what models take over the balls that were drawn is in them
    std::size_t runs = 0;       // of all pictures
    std::size_t calm_runs = 0;  // of them, those that kept their cores
};

inline constexpr double usual_seconds = 1.3;  // that measuring graphics takes in a probe

// What is uploaded, drawn for `seconds` after a few frames that wake the driver, at least three times and at most a
// hundred: what timing_of() takes. Errors: those of the renderer.
Result<std::vector<TimedRun>> timed_runs(render::Renderer& renderer, const shading::View& view,
                                         const render::DrawOptions& options, double seconds);

// In about `seconds`, unless single frames take long. Replaces what the renderer holds. Errors: those of the renderer.
Result<Graphics> measure_graphics(render::Renderer& renderer, double seconds = usual_seconds);

}  // namespace lodestream::probe
