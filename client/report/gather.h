// Measuring: everything that a report says, from a running server and the renderer. The only part with effects.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "client/render/renderer.h"
#include "client/report/data.h"
#include "client/report/device_classes.h"
#include "client/sdk/client.h"

namespace lodestream::report {

inline constexpr double max_bake_wait_s = 3600.0;
inline constexpr double max_quick_bake_wait_s = 12.0;            // once something is ready; then that is measured
inline constexpr std::uint64_t max_quick_triangles = 1'000'000;  // larger assets are left out of a quick report
inline constexpr std::size_t max_quick_assets = 4;
inline constexpr std::size_t max_assets = 256;
inline constexpr std::size_t max_thorough_assets = 16;  // with more, each is measured as in a quick report
inline constexpr std::size_t max_levels = 32;           // of one ladder
inline constexpr std::uint32_t thumbnail_width = 300;   // px, of the pictures in the page
inline constexpr std::uint32_t composite_width = 480;   // px, of one panel of an asset's composite

struct GatherOptions {
    std::filesystem::path out;  // pictures go to out/pictures
    std::string server_url;     // the client's, for further connections
    bool quick = false;
    std::function<bool(const std::string&)> progress;  // what is being done now; false: stop. Never empty
};

// Waits for the bakes, then plans, fetches, decodes, draws and compares for every ready asset and device class. What
// fails is a line in `problems`. Errors: the server cannot be asked, has nothing that could be measured, or `progress`
// said to stop.
Result<ReportData> gather(sdk::Client& client, render::Renderer& renderer, const GatherOptions& options);

}  // namespace lodestream::report
