// Measuring the frame-rate part of a report.
#pragma once

#include <functional>
#include <string>

#include "client/render/renderer.h"
#include "client/report/frame_rate.h"
#include "client/sdk/client.h"
#include "common/base/result.h"

namespace lodestream::report {

struct FrameRateOptions {
    bool quick = false;
    std::function<bool(const std::string&)> progress;  // false: stop. Never empty
};

// Flies over the largest terrain that is ready, or over the largest asset where there is none: flights and blur,
// without simulated devices. Errors: those of client and renderer, unavailable (`progress` said to stop; no level is
// cheap enough to fly), not_found (no asset is ready).
Result<FrameRateResult> measure_flights(sdk::Client& client, render::Renderer& renderer,
                                        const FrameRateOptions& options);

// All of it. Errors likewise.
Result<FrameRateResult> measure_frame_rate(sdk::Client& client, render::Renderer& renderer,
                                           const FrameRateOptions& options);

}  // namespace lodestream::report
