// `lodestream-client fly`: a motion over an asset under a controller, a row of numbers a frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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
    std::optional<std::filesystem::path>
        device;  // a device file: a plan bounds the levels and follows what frames take
};

// t_s,frame_ms,level,triangles,speed_deg_s,error_px,switched
std::string to_csv(const std::vector<control::FlownFrame>& frames);

// Fetches the ladder, flies, writes and prints one line. Motion blur is left out with a warning where the driver has
// none.
Status fly(const FlyArguments& arguments);

}  // namespace lodestream::client
