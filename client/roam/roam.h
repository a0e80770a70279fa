// Moves through a scene whose tiles come while it moves: each frame draws the cut of what is here, asks for what its
// view lacks and lets levels fade into each other. What is not here is covered by the nearest level above it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/render/renderer.h"
#include "client/roam/popping.h"
#include "client/roam/tiles.h"
#include "common/base/result.h"
#include "common/motion/motion.h"
#include "common/scene/stream.h"
#include "common/shading/view.h"
#include "proto/tileset.h"

namespace lodestream::roam {

inline constexpr std::size_t max_frames = 1'000'000;
inline constexpr int max_attempts = 3;  // at a tile that the network fails to bring
inline constexpr double min_fps = 1.0, max_fps = 1000.0;

// How far ahead along the motion tiles are asked for.
inline constexpr double ahead_s[] = {0.25, 0.75};

// What a tile that has not come yet may take on the GPU, of its encoded bytes; when it comes, that is known.
inline constexpr std::uint64_t gpu_bytes_per_byte = 16;

struct RoamOptions {
    double fps = 30.0;                                // frames a second of the motion, whatever they take to draw
    double fade_s = 0.25;                             // how long levels fade into each other; 0: not at all
    bool looks_ahead = true;                          // fetches what the motion leads to
    scene::StreamOptions stream{.max_requests = 32};  // its memory is the GPU's
    std::uint32_t width = 800, height = 600;          // px
    std::uint32_t samples = 4;                        // a pixel
    // Called with each frame's time before it is drawn, so that a program can keep to the clock. Empty: none.
    std::function<void(double t_s)> wait_until{};
    // Called before each frame: a newer tileset of the scene, if there is one. Tiles that are in both stay; what a tile
    // shows stays until what it is to show has come. Empty: the scene stays as it is.
    std::function<std::optional<proto::Tileset>()> newer{};
    // Called in each frame with the addresses of the documents whose tiles the view would refine to, the largest error
    // first; what they tell comes with a newer tileset. Empty: what is told elsewhere is not shown.
    std::function<void(const std::vector<std::string>&)> open{};
    // Called with each frame. A failure ends the motion. Empty: none.
    std::function<Status(const render::Image&)> on_frame{};
};

struct RoamFrame {
    double t_s = 0.0;
    double frame_ms = 0.0;            // putting tiles on the GPU and drawing, until it is done
    std::uint64_t triangles = 0;      // drawn, of both levels where one fades into the other
    std::uint64_t points = 0;         // likewise, of clouds
    std::size_t tiles = 0;            // of the cut
    std::size_t fading_tiles = 0;     // going or coming
    std::size_t missing_tiles = 0;    // that the view asks for and that are not here
    std::size_t outdated_tiles = 0;   // of the cut, shown as they were before the scene changed
    double error_px = 0.0;            // the largest of what is drawn
    double missed_px = 0.0;           // what the cut is off beyond the tolerance, summed over its tiles
    std::uint64_t fetched_bytes = 0;  // so far, as they came
    std::uint64_t gpu_bytes = 0;      // of all tiles held
    bool has_changed = false;         // what is in view is other levels, or other shares of them, than before
    Popping popping;                  // of that: against what the frame before drew, in this frame's view
};

struct Roamed {
    std::vector<RoamFrame> frames;
    std::uint64_t fetched_tiles = 0;
    std::uint64_t revisions = 0;        // newer tilesets that came meanwhile, be it by a document
    std::vector<std::string> failures;  // of each tile that could not be had: why
    std::vector<std::string> warnings;  // of tiles that are drawn otherwise than they say
};

// `home` is the view where the motion gives no position. Frames are the background until the root is here. Popping is
// not counted against that. Errors: invalid_input (options), unsupported (tiles of points that are moved),
// limit_exceeded (more than max_frames; the GPU's memory), those of the renderer, and why the root could not be had.
// `tiles` has adopted nothing yet. pre: validate(tileset.nodes), as many bytes as nodes
Result<Roamed> roam(render::Renderer& renderer, proto::Tileset tileset, Tiles& tiles, const motion::Trace& motion,
                    const shading::View& home, const RoamOptions& options);

struct RoamSummary {
    std::size_t frames = 0;
    double first_picture_s = 0.0;  // from the start until the root was here; the duration where it never was
    double mean_frame_ms = 0.0, worst_frame_ms = 0.0;
    double mean_error_px = 0.0;
    double mean_missed_px = 0.0;
    double missing_frames = 0.0;  // share in which a tile was missing
    std::uint64_t peak_gpu_bytes = 0;
    std::size_t changes = 0;                           // frames whose levels are others than those before
    double popping_largest = 0.0, popping_p999 = 0.0;  // the largest of all frames
    double popping_rms = 0.0;                          // likewise
};
RoamSummary summarize(const Roamed& roamed);

}  // namespace lodestream::roam
