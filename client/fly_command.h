// `lodestream-client fly`: a motion over an asset under a controller, a row of numbers a frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "client/fly/pilot.h"
#include "common/base/result.h"
#include "common/control/flight.h"

namespace lodestream::client {

struct FlyArguments {
    std::string server;
    std::string asset;
    std::string motion;  // a CSV file, or "builtin:NAME" of common/motion
    std::string controller = "predictive";
    double target_fps = 60.0;
    std::filesystem::path out;                    // CSV
    std::optional<std::filesystem::path> frames;  // folder for a PNG a frame; made where missing
    std::uint32_t width = 800;                    // px
    std::uint32_t height = 600;                   // px
    double fov_y_deg = 45.0;
    bool blur = true;
    std::string shading = "gouraud";  // or "hybrid": the border of each level moves with the distance
    double split_bound_steps = 4.0;   // of 255: the most that a frame's move of it may change, root mean square
    std::optional<std::filesystem::path>
        device;  // a device file: a plan bounds the levels and follows what frames take
};

// t_s,frame_ms,level,triangles,speed_deg_s,error_px,switched and, where there is a split for each frame,
// gouraud_triangles,split_bound_steps,split_change_steps
std::string to_csv(const std::vector<control::FlownFrame>& frames, const std::vector<fly::SplitFrame>& splits = {});

// Fetches the ladder, flies, writes and prints one line. Motion blur is left out with a warning where the driver has
// none.
Status fly(const FlyArguments& arguments);

}  // namespace lodestream::client
