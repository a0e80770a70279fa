// The renderer's speed: triangles Gouraud and flat, points, pixels, and what a frame costs that draws nothing much.
#pragma once

#include "client/probe/statistics.h"
#include "client/render/renderer.h"
#include "common/base/result.h"

namespace lodestream::probe {

struct Graphics {
    Rate gouraud_triangles;
    Rate flat_triangles;
    Rate points;  // of a cloud, as discs
    Rate pixels;  // filled, each lit and written
    double fixed_frame_ms = 0.0;
};

// `seconds` for each of the four rates. Replaces what the renderer holds. Errors: those of the renderer.
Result<Graphics> measure_graphics(render::Renderer& renderer, double seconds);

}  // namespace lodestream::probe
