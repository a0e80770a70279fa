// `lodestream-client roam`: a motion through a scene whose tiles come while it moves, a row of numbers a frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "client/roam/roam.h"
#include "client/roam/slow_link.h"
#include "common/base/result.h"

namespace lodestream::client {

struct RoamArguments {
    std::string server;
    std::string asset;
    std::optional<std::string> motion;            // a CSV file, or "builtin:NAME" of common/motion; else a tour
    std::filesystem::path out;                    // CSV
    std::optional<std::filesystem::path> frames;  // folder for a PNG a frame; made where missing
    std::uint32_t width = 800;                    // px
    std::uint32_t height = 600;                   // px
    double fov_y_deg = 45.0;
    double fps = 30.0;
    double tolerance_px = 1.0;
    std::optional<std::uint64_t> triangles;
    double memory_mb = 256.0;  // 2^20 bytes on the GPU
    double fade_ms = 250.0;
    bool looks_ahead = true;
    sdk::Link link;
    bool json = false;
};

// frame,t_s,frame_ms,tiles,triangles,error_px,missed_px,missing_tiles,fetched_bytes,gpu_bytes,fading_tiles,
// pop_largest,pop_p999,pop_rms,outdated_tiles
std::string to_csv(const std::vector<roam::RoamFrame>& frames);

// Fetches the tileset, moves, follows the scene where it changes meanwhile, writes and prints what it met, or a JSON
// object. Tiles that could not be had are warned of. Errors: those of the client, unsupported (a tileset that does not
// tell its tiles' bytes), of roam::roam(), io.
Status roam(const RoamArguments& arguments);

}  // namespace lodestream::client
