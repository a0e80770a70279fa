// Flies a motion over a scenery with the real renderer: one level is on the GPU, another one is copied there when the
// controller asks for it, and that takes its time within the frame.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "client/fly/scenery.h"
#include "client/render/renderer.h"
#include "common/base/result.h"
#include "common/control/flight.h"
#include "common/motion/motion.h"
#include "common/shading/split_control.h"

namespace lodestream::fly {

inline constexpr std::uint32_t blur_samples = control::max_exposures;  // a pixel, shared by a frame's exposures

struct Screen {
    std::uint32_t width = 800;   // px
    std::uint32_t height = 600;  // px
    double fov_y_deg = 45.0;
};

budget::Display display_of(const Screen& screen);

// Of a frame over levels whose border between Gouraud and flat moves with the viewer's distance. Changes are in 8-bit
// steps, the root mean square over a disc as large as the level's bounding sphere at its nearest point.
struct SplitFrame {
    std::uint64_t gouraud_triangles = 0;
    double bound_steps = 0.0;   // on what moving the border may have changed in the picture
    double change_steps = 0.0;  // what it did change: drawn a second time, with the border where it was before
};

struct PilotOptions {
    control::Kind kind = control::Kind::predictive;
    control::Options control;
    Screen screen;
    // Called with every frame, outside its time; a failure ends the flight. Empty: none.
    std::function<Status(const render::Image&, const control::FrameRequest&)> on_frame;
    std::function<double(const std::optional<control::DrawnFrame>&)> budget{};  // of control::Flight
    // Where the levels are movable: called with every frame, outside its time. Empty: none, and nothing is measured.
    std::function<void(const SplitFrame&)> on_split{};
    // The bound holds under any light, so what shows is a small part of it: with four steps the border crosses a level
    // in one to four seconds of 60 frames.
    shading::SplitControlOptions split{.max_change = 4.0 / 255.0};
    std::function<std::uint32_t()> distance_steps{};  // of the coming frame's border; empty: max_distance_steps
};

// What the renderer needs for this scenery on this screen: a few frames and uploads each of the finest and coarsest
// level, the first of each left out, the coarsest also at a small size and with all exposures. The predictive
// controller's first guess. `blurs`: frames have several exposures. Errors: those of the renderer.
Result<control::FrameCosts> measure_costs(render::Renderer& renderer, const Scenery& scenery, const Screen& screen,
                                          bool blurs = true);

// Milliseconds of one exposure of a level and of putting it on the GPU, the least of a few.
struct LevelTimes {
    double draw_ms = 0.0;
    double upload_ms = 0.0;
};
Result<LevelTimes> time_level(render::Renderer& renderer, const Scenery& scenery, std::size_t level,
                              const Screen& screen);

// Milliseconds of a frame of these exposures of a level, the least of a few.
Result<double> time_frame(render::Renderer& renderer, const Scenery& scenery, std::size_t level,
                          const std::vector<motion::Pose>& poses, const Screen& screen);

Result<std::vector<control::FlownFrame>> fly(render::Renderer& renderer, const Scenery& scenery,
                                             const motion::Trace& trace, const PilotOptions& options);

// One frame as a flight draws it, of any level, which is uploaded first.
Result<render::Image> picture(render::Renderer& renderer, const Scenery& scenery, std::size_t level,
                              const std::vector<motion::Pose>& poses, const Screen& screen);

}  // namespace lodestream::fly
