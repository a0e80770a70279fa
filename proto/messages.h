// The wire's messages: plain structs of what docs and openapi.yaml describe, and their JSON.
// Parsing is strict about types and ranges and names the offending field; unknown fields are ignored, so that the wire
// can grow.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/budget/budget.h"
#include "common/shading/view.h"

namespace lodestream::proto {

enum class AssetStatus { baking, ready, failed };
enum class Profile { plain, lean };
// Which triangles get normals: the plan's split, or all or none of them (the two pure modes to compare with).
enum class ShadingMode { hybrid, gouraud, flat };
// What a level may be made of. `any`: of what the device draws in its time, what is nearer in pictures, as the bake
// measured them (server/bake/shown_errors.h).
enum class Primitives { triangles, points, any };

// One rung of an asset's ladder; 0 is the finest.
struct Level {
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    double rms_error = 0.0;             // model units, two-sided, measured
    double max_error = 0.0;             // model units
    double rms_error_percent = 0.0;     // of the bounding box's diagonal
    double normal_error_degrees = 0.0;  // of its shading normals, RMS over its area
    std::uint64_t bytes = 0;
    std::uint64_t texture_bytes = 0;  // of these, the images'
    double encode_ms = 0.0;
    std::string url;  // /v1/content/….glb
};

// The tiles of a scene of several objects, as its tileset lists them.
struct Hierarchy {
    std::uint64_t tiles = 0;
    std::uint64_t depth = 0;      // tiles from the root to the farthest leaf
    std::uint64_t triangles = 0;  // of all tiles together
    std::uint64_t bytes = 0;
    double max_error = 0.0;  // of the root: model units, at most
    double bake_ms = 0.0;    // of the asset's
};

struct Asset {
    std::string id;
    std::string name;
    std::string kind;  // "mesh", "scene", "terrain", "points"
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    AssetStatus status = AssetStatus::baking;
    std::string error;  // why, where status is failed
    double bake_ms = 0.0;
    double progress = 0.0;  // of the bake, [0,1]
    std::uint64_t peak_memory_bytes = 0;
    std::optional<std::array<double, 3>> bounds_min;  // of the full model: world axes, model units, y up
    std::optional<std::array<double, 3>> bounds_max;
    std::vector<Level> levels;
    std::optional<Hierarchy> hierarchy;  // none where the asset is one object
    std::vector<std::string> warnings;
};

struct PlanRequest {
    std::string asset;       // id or name
    budget::Request budget;  // device, display, preference, network, reference
    std::optional<shading::View> view;
    Profile profile = Profile::plain;
    ShadingMode shading = ShadingMode::hybrid;
    Primitives primitives = Primitives::triangles;
};

struct LeftOut {
    std::string what;
    std::uint64_t bytes = 0;
};

// The error of what is seen from outside alone, where a level shows nothing else of a scene.
struct OutsideError {
    double rms_error = 0.0;  // model units, two-sided, measured
    double max_error = 0.0;  // model units
};

// Points against triangles.
struct Crossing {
    // From the bounding sphere's centre, model units: up to there points are chosen; none: from anywhere.
    std::optional<double> distance;
    double triangles_error_percent = 0.0;  // of each in pictures: RMS, of the step from black to white
    double points_error_percent = 0.0;
};

struct PlanResponse {
    double dlr = 0.0;
    std::uint64_t ncp = 0;
    std::optional<double> rup;
    struct {
        std::uint64_t triangles = 0;
        std::string limited_by;
        bool feasible = true;
        std::optional<std::uint64_t> points;  // where points were allowed
    } budget;
    struct {
        std::uint64_t triangles = 0;
        std::uint64_t vertices = 0;
        std::uint64_t points = 0;  // where the level is a cloud, which has no triangles
        double rms_error = 0.0;
        double max_error = 0.0;
        double rms_error_percent = 0.0;
        double normal_error_degrees = 0.0;
        std::optional<OutsideError> outside;  // of a scene's levels for an eye outside of it
        double screen_space_error_px = 0.0;   // max_error, of `outside` where it is there, at the nearest point of the
                                              // bounding sphere
    } level;
    struct {
        double distance = 0.0;
        std::uint64_t gouraud = 0;
        std::uint64_t flat = 0;
        budget::Operations operations;
        std::string mode;  // what was sent: "hybrid", "gouraud", "flat" or "points"
    } shading;
    struct {
        std::string url;
        std::uint64_t bytes = 0;
        std::string media_type = "model/gltf-binary";
        std::string profile = "plain";
    } content;
    std::optional<Crossing> crossing;  // where the request allows both and points win from close by
    std::vector<LeftOut> left_out;
    struct {
        double plan = 0.0;    // ms, all of it
        double cut = 0.0;     // ms, 0 where the level was in the store
        double encode = 0.0;  // ms, 0 where the level was in the store
    } timing_ms;
    std::vector<std::string> warnings;
};

// RFC 9457.
struct Problem {
    int status = 500;
    std::string title;
    std::string detail;
    std::string type = "about:blank";
};

inline constexpr std::size_t max_json_depth = 32;

Result<PlanRequest> parse_plan_request(
    std::string_view json);  // invalid_input names the field: "device.cpu_mhz must be > 0"
Result<PlanResponse> parse_plan_response(std::string_view json);
Result<std::vector<Asset>> parse_assets(std::string_view json);  // {"assets":[…]}
Result<Asset> parse_asset(std::string_view json);
Result<Problem> parse_problem(std::string_view json);
// A device file of the client: the plan request without its asset, as in `{"device":…,"display":…,…}`; a bare device
// report too.
Result<PlanRequest> parse_device_file(std::string_view json);

std::string to_json(const PlanRequest& request);
std::string to_json(const PlanResponse& response);
std::string to_json(const Asset& asset);
std::string to_json(const std::vector<Asset>& assets);  // {"assets":[…]}
std::string to_json(const Problem& problem);

Problem problem_of(const Error& error);  // ErrorCode to HTTP status and title

const char* status_name(AssetStatus status);
const char* profile_name(Profile profile);
const char* shading_mode_name(ShadingMode mode);
const char* primitives_name(Primitives primitives);
Result<Primitives> parse_primitives(std::string_view name);
Result<ShadingMode> parse_shading_mode(std::string_view name);

}  // namespace lodestream::proto
