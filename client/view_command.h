// `lodestream-client view`: one asset as one device gets it, as a picture.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common/base/result.h"

namespace lodestream::client {

struct ViewArguments {
    std::string server;
    std::string asset;
    std::filesystem::path device;
    std::filesystem::path out;
    std::optional<std::uint32_t> width;  // px; else the device's display, else 800×600
    std::optional<std::uint32_t> height;
    std::string shading = "hybrid";
    std::optional<std::string> profile;     // else the device file's, else plain
    std::optional<std::string> primitives;  // else the device file's, else triangles
    bool json = false;
};

// Plans, fetches, decodes, draws and writes the picture; prints one line or a JSON object.
Status view(const ViewArguments& arguments);

}  // namespace lodestream::client
