// The report's measurements of a model's points: silhouettes of a crowd of them (crowd.h), and one model as points and
// as triangles of the same device's budgets, from near to far.
#pragma once

#include <functional>
#include <vector>

#include "client/render/renderer.h"
#include "client/report/data.h"
#include "client/report/device_classes.h"
#include "client/sdk/client.h"

namespace lodestream::report {

inline constexpr double choice_distances[] = {1.5, 3.0, 6.0, 12.0, 24.0, 48.0, 96.0};  // of the eye, radii
inline constexpr std::uint64_t max_crowd_points = 16'000'000;  // were all at their finest level: else fewer instances
inline constexpr std::uint32_t max_crowd_side = 11;            // the paper's 1,331 instances
inline constexpr double level_ratio = 0.5;                     // of a level's points to the next finer one's

struct PointsStudyOptions {
    std::vector<DeviceClass> devices;  // whose plans are compared
    std::uint32_t directions = 2;      // views on each orbit
    std::uint32_t frames = 5;          // of a picture whose time counts
    std::function<bool()> going_on;    // false: stop; may be empty
};

// Gives `asset` its points and choices. Errors: of the server, the decoder or the renderer; not_found (no points).
Status study_points(sdk::Client& client, render::Renderer& renderer, const PointsStudyOptions& options,
                    AssetResult& asset);

}  // namespace lodestream::report
