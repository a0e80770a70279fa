// What a report knows: plain measurements, gathered once (gather.h) and shown by pure functions (sections.h,
// document.h).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "client/report/frame_rate.h"
#include "client/sdk/client.h"
#include "common/budget/budget.h"
#include "proto/benchmark_runs.h"
#include "proto/messages.h"

namespace lodestream::report {

// Where the numbers come from; printed with every table.
struct Provenance {
    std::string command;
    std::string commit;
    std::string date;  // UTC, ISO 8601
    std::string cpu;
    std::uint32_t cores = 0;
    std::string renderer;  // the OpenGL renderer's own name
    bool software_renderer = false;
    bool quick = false;
};

// How a drawn picture differs from the full model's, same view, same pixels, where either shows the object.
struct ImageError {
    double percent = 0.0;             // root mean square of R, G and B, of full scale
    double silhouette_percent = 0.0;  // pixels that only one of the two covers
};

// A level of one shading mode on its way: bytes and milliseconds measured on this machine.
struct ModeResult {
    proto::ShadingMode mode = proto::ShadingMode::hybrid;
    std::uint64_t gouraud = 0;
    std::uint64_t flat = 0;
    std::uint64_t bytes = 0;
    double fetch_ms = 0.0;
    double decode_ms = 0.0;
    double frame_ms = 0.0;
    double predicted_ms = 0.0;  // from the probe's figures alone; 0: not predicted
    std::uint64_t gpu_bytes = 0;
    ImageError image;
};

using sdk::Link;
inline constexpr std::array<Link, 4> links{{{0.5, 300.0}, {2.0, 80.0}, {10.0, 40.0}, {100.0, 10.0}}};

// Milliseconds over each of the links, throttled for real; what would have taken too long is not there.
using LinkTimes = std::array<std::optional<double>, links.size()>;

struct DeviceResult {
    std::string device;
    budget::Request request;
    proto::PlanRequest sent_request;  // of the hybrid level
    proto::PlanResponse plan;         // to it, made for the first time
    double replan_ms = 0.0;           // round trip of the same plan once more, its content in the store
    LinkTimes linked_plan_ms;         // the same over a link
    LinkTimes linked_fetch_ms;        // of the plan's content
    std::uint64_t left_out_bytes = 0;
    std::array<ModeResult, 3> modes;  // hybrid, gouraud, flat; lean, as our own clients ask for
    std::uint64_t plain_bytes = 0;    // of the hybrid plan as glTF that any viewer shades in full
};

struct DrawnLevel {
    std::string device;
    double frame_ms = 0.0;
    double error_px = 0.0;  // the level's maximum error at the object's nearest point
    ImageError image;
    double predicted_ms = 0.0;  // from the probe's figures alone; 0: not predicted
};

// A rung of the ladder as stored.
struct LadderLevel {
    std::uint64_t index = 0;  // 0: the finest
    proto::Level level;
    std::uint64_t gouraud = 0;  // of its triangles
    double fetch_ms = 0.0;
    double decode_ms = 0.0;
    LinkTimes linked_fetch_ms;
    std::vector<DrawnLevel> drawn;  // one a device
};

// One share of flat triangles, d, at one triangle count and one drawn view.
struct SplitStep {
    double distance = 0.0;
    std::uint64_t triangles = 0;
    ModeResult result;
};

// The paper's Table 3 on the full model, counted where the operations are done.
struct CountedOperations {
    std::uint64_t triangles = 0;
    std::uint64_t differing = 0;  // triangles whose corners' intensities differ
    std::uint64_t criterion = 0;
    std::uint64_t all_flat = 0, all_gouraud = 0;     // with the criterion, as in the table
    std::uint64_t hybrid = 0;                        // 2.8 % of the triangles Gouraud: the text's reading
    std::optional<std::uint64_t> hybrid_as_printed;  // 179 flat, 4,421 Gouraud; of 6,400 triangles alone
};

// One drawn split of one level against the full model, same view, lights and pixels.
struct ShadingSample {
    std::string series;     // "lights", "fine level", "criteria", "equal operations", "equal bytes"
    std::string criterion;  // "paper", "measured importance" (against the full model), "importance" (by the level's
                            // own normals), "importance from anywhere"; empty: nothing was chosen
    std::uint32_t lights = 1;
    budget::Display display;
    double distance = 0.0;        // share of flat triangles; of "lights" and "criteria"
    double share_of_price = 0.0;  // triangles over what all flat affords; of "equal operations"
    bool is_chosen = false;       // where worth_gouraud() divides the price; of "equal operations"
    std::uint64_t triangles = 0;
    double triangles_per_pixel = 0.0;  // that it or the full model covers
    std::uint64_t operations = 0;      // f + 4g
    ModeResult result;                 // times and bytes that the series does not measure are 0
};

// What a scene shows within a budget in the view of the first device class: the tiles that target-frame-rate mode
// draws, or the one level that a plan gives.
struct HlodSample {
    std::uint64_t budget = 0;  // triangles
    std::uint64_t triangles = 0;
    std::uint64_t tiles = 0;  // 0: a plan's level
    std::uint64_t bytes = 0;
    double error_px = 0.0;  // the largest of the tiles'
    double frame_ms = 0.0;
    ImageError image;
};

// A level of points in a crowd of instances against full models (crowd.h), the pictures of all distances together.
struct PointsLevel {
    std::string level;         // "L0", the finest, … "L4"; "all": the whole crowd in one picture
    std::uint64_t points = 0;  // of an instance; 0: each its own level's
    double recall = 0.0, precision = 0.0, f_measure = 0.0;
};

// What a device's budget shows of a model from some distance.
struct Shown {
    std::uint64_t primitives = 0;  // triangles or points
    std::uint64_t bytes = 0;
    double frame_ms = 0.0;
    ImageError image;
};
struct PointsChoice {
    std::string device;
    double distance = 0.0;  // of the eye from the bounding sphere's centre, radii
    Shown triangles, points;
    bool chose_points = false;  // where the plan may send either
};

// What a device shows beside the full model, and their difference; thumbnails as PNG.
struct Picture {
    std::string device;
    std::uint32_t width = 0, height = 0;  // px, of one panel as drawn
    std::string level_png, full_png, difference_png;
    std::filesystem::path file;  // all three at full size, relative to the report
};

struct AssetResult {
    proto::Asset asset;
    double diagonal = 0.0;  // of the full model's bounding box, model units
    std::uint64_t full_triangles = 0;
    std::uint64_t full_bytes = 0;  // the full model, all Gouraud
    double full_decode_ms = 0.0;
    std::vector<DeviceResult> devices;
    std::vector<LadderLevel> ladder;
    std::vector<SplitStep> split;
    std::string split_device;  // whose budget and display the split was measured with
    CountedOperations operations;
    std::vector<ShadingSample> shading;
    std::vector<HlodSample> hlod;   // tiles; of scenes alone
    std::vector<HlodSample> plans;  // levels; of scenes alone
    std::vector<PointsLevel> points;
    std::uint32_t crowd_instances = 0;
    std::vector<PointsChoice> choices;
    std::vector<Picture> pictures;
};

struct ReportData {
    Provenance provenance;
    std::vector<AssetResult> assets;
    std::optional<proto::MethodRun> methods;  // where the report was given one
    std::optional<proto::CodecRun> codecs;    // likewise
    std::optional<proto::PointsRun> points;   // likewise
    std::optional<proto::SceneRun> scenes;    // likewise
    std::optional<FrameRateResult> frame_rate;
    std::vector<std::string> problems;  // what is missing and why, one line each
};

}  // namespace lodestream::report
