// What benchmarks write (tests/bench) and the report shows: what this project and its peers make of the same levels.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace lodestream::proto {

// A level that one method of simplification made of a model.
struct MethodLevel {
    std::string model, method;
    std::uint64_t model_triangles = 0;
    std::uint64_t asked = 0, triangles = 0;
    double wall_ms = 0.0, cpu_ms = 0.0;
    std::optional<double> rms_error_percent, max_error_percent;  // of the model's diagonal
    std::optional<double> image_rms;  // steps of 255; with the method's normals if it has any
};

// Where and of what it was measured.
struct RunOrigin {
    std::string command, commit, date, cpu;
    std::uint32_t cores = 0;
};

struct MethodRun {
    RunOrigin origin;
    std::vector<MethodLevel> levels;
};

// A level of a model by one codec in one setting.
struct CodecTrial {
    std::string model, codec, setting;
    bool is_default = false;  // what the codec is used with
    std::uint64_t triangles = 0, bytes = 0;
    double encode_ms = 0.0, decode_ms = 0.0;  // CPU time
    double image_rms = 0.0;                   // steps of 255, against the level before encoding
};

struct CodecRun {
    RunOrigin origin;
    std::vector<CodecTrial> trials;
};

// Pixels that points and the full model cover, points taken for the guess (the point-cloud paper's equations 1 and 2).
struct SilhouetteMatch {
    double recall = 0.0, precision = 0.0, f_measure = 0.0;
};

// A crowd of instances of a model, each as the points that its distance asks for.
struct PointsScore {
    std::string model, level;  // "L0", the finest, ...: the instances of that level alone; "all": the whole crowd
    bool is_scaled = false;    // fewer points than the paper's, as the scan at hand is smaller than the paper's
    std::uint64_t triangles = 0, points = 0, instances = 0, views = 0;
    SilhouetteMatch match;
    std::optional<double> paper_f;
};

// One cloud of a model, seen close by from all around.
struct PointsSetting {
    std::string model, varied, filter;     // "filter", "slices", "side" or "point size"
    std::uint64_t slices = 0, side = 0;    // T1 and T3
    double point_size = 0.0;               // T2: radius of a disc over what closes the surface
    std::uint64_t points = 0, holes = 0;   // holes: over all views, surrounded by points
    std::uint64_t hole_px = 0, views = 0;  // likewise
    SilhouetteMatch match;
};

// A square of instances of a model, drawn as full models and as points by distance.
struct PointsCrowd {
    std::string model;
    std::uint64_t instances = 0, full_triangles = 0, points = 0;
    double full_ms = 0.0, points_ms = 0.0;  // of a frame, CPU time
    std::optional<double> paper_gain;       // of the frame rate
    std::optional<double> scaled_gain;  // the paper's times the vertices at hand over its scan's, where they are fewer
};

// A model from one distance, as triangles and as points of the same frame time, and which of them a plan sends.
struct PointsChoice {
    std::string model, device;
    double points_per_triangle = 0.0;  // drawn in the same time
    double frame_share = 0.0;          // of the device's frame that the model gets
    double distance = 0.0;             // of the eye, radii
    std::uint64_t triangles = 0, points = 0;
    double triangles_percent = 0.0, points_percent = 0.0;  // of the pictures against the full model's: RMS
    bool chose_points = false;
    std::optional<double> crossing;  // radii: up to there the plan takes points; none: never, or at any distance
};

struct PointsPicture {
    std::string model, title;
    std::string png_base64;
    std::vector<std::string> panels{};  // what it shows side by side, equally wide; may be empty
};

struct PointsRun {
    RunOrigin origin;
    std::vector<PointsScore> scores;
    std::vector<PointsSetting> settings;
    std::vector<PointsCrowd> crowds;
    std::vector<PointsChoice> choices;
    std::vector<PointsPicture> pictures;
};

// The bake of a scene of so many objects.
struct SceneBake {
    std::string scene;
    std::uint64_t objects = 0, triangles = 0;  // instances counted
    std::uint64_t tiles = 0, bytes = 0;        // bytes: of all tiles
    double wall_ms = 0.0, cpu_ms = 0.0, tiles_ms = 0.0;
    std::uint64_t peak_memory_bytes = 0;
};

struct SceneRun {
    RunOrigin origin;
    std::vector<SceneBake> bakes;
};

// Errors: invalid_input, with the path of the field.
Result<MethodRun> parse_method_run(std::string_view json);
Result<CodecRun> parse_codec_run(std::string_view json);
Result<PointsRun> parse_points_run(std::string_view json);
Result<SceneRun> parse_scene_run(std::string_view json);

}  // namespace lodestream::proto
