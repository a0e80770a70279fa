// The report's measurements of a scene's tiles: what target-frame-rate mode draws of them within ever more triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "client/render/renderer.h"
#include "client/report/data.h"
#include "client/sdk/client.h"
#include "common/shading/view.h"

namespace lodestream::report {

inline constexpr std::uint64_t hlod_budgets[] = {480, 1'920, 7'680, 30'720, 122'880, 491'520};  // triangles

// pre: `full` is the full model's picture in this view, drawn with one sample a pixel
// Errors: of the server, the decoder or the renderer.
Result<std::vector<HlodSample>> study_hlod(sdk::Client& client, render::Renderer& renderer, const proto::Asset& asset,
                                           const shading::View& view, const render::Image& full, std::uint32_t frames);

}  // namespace lodestream::report
