// The report's measurements of a scene within ever more triangles: what target-frame-rate mode draws of its tiles, and
// the level that a plan gives.
#pragma once

#include <cstdint>
#include <vector>

#include "client/render/renderer.h"
#include "client/report/data.h"
#include "client/sdk/client.h"
#include "common/shading/view.h"

namespace lodestream::report {

inline constexpr std::uint64_t hlod_budgets[] = {480, 1'920, 7'680, 30'720, 122'880, 491'520};  // triangles

// Fills the asset's `hlod` and `plans`. `request`: that of the full model, with a view.
// pre: `full` is the full model's picture in this view, drawn with one sample a pixel
// Errors: of the server, the decoder or the renderer.
Status study_hlod(sdk::Client& client, render::Renderer& renderer, const proto::PlanRequest& request,
                  const render::Image& full, std::uint32_t frames, AssetResult& result);

}  // namespace lodestream::report
