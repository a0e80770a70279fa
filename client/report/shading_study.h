// The report's measurements of hybrid shading itself: lights, criteria, and what each shading mode makes of the same
// price. Everything is drawn on this machine from levels that the server sends.
#pragma once

#include <vector>

#include "client/render/renderer.h"
#include "client/report/data.h"
#include "client/sdk/client.h"
#include "common/codec/level_codec.h"
#include "common/shading/normal_errors.h"
#include "common/shading/view.h"

namespace lodestream::report {

// The equal-operations comparison: a triangle costs 1 flat and 4 Gouraud (Table 3). All flat shows as many triangles as
// the largest display deserves, or half of a smaller model, so that no mode shows all of it.
inline constexpr std::uint64_t max_study_operations = 24'000;
// Of the level that is drawn under lights and split by the criteria: Table 2's upper figure at 800x600.
inline constexpr std::uint64_t max_study_triangles = 8000;

// Of the level that the map of frame times shows beside it: triangles of a pixel and less.
inline constexpr std::uint64_t max_fine_triangles = 100'000;

// The triangles that a price buys: as many Gouraud as are left over for.
struct Purchase {
    std::uint64_t triangles = 0;
    std::uint64_t gouraud = 0;
};
// `share` in [0.25, 1] of `operations`: 1 is all flat, 0.25 all Gouraud.
Purchase purchase(std::uint64_t operations, double share);

// `count` lights whose intensities sum up to 1: the view's own first, the others spread over the sphere around.
std::vector<render::Light> light_rig(const shading::View& view, std::size_t count);

// One way of lighting and looking that the study draws the full model in.
struct Setting {
    std::uint32_t lights = 1;
    budget::Display display;
    render::Image full;  // the full model, all Gouraud
};
// pre: the full model is what the renderer holds
Result<std::vector<Setting>> study_settings(render::Renderer& renderer, const shading::View& view, bool quick);

// What levels' normals are measured against.
shading::ReferenceSurface reference_surface(const codec::Decoded& full);

struct StudyOptions {
    std::string asset_id;
    shading::View view;
    std::uint32_t frames = 5;  // of a picture whose time counts
    bool quick = false;        // of the price, the pure modes and the chosen share alone
};

// Gives `asset` its operations and its samples. Errors: of the server, the decoder or the renderer.
Status study_shading(sdk::Client& client, render::Renderer& renderer, const std::vector<Setting>& settings,
                     const shading::ReferenceSurface& full, const StudyOptions& options, AssetResult& asset);

// Table 3 counted on one mesh, all Gouraud primitives merged.
CountedOperations count_operations(const codec::Decoded& full, const shading::View& view);

}  // namespace lodestream::report
