#include "proto/messages.h"

#include "proto/json_reader.h"

namespace lodestream::proto {

namespace {

void read_device(const Fields& fields, budget::DeviceReport& device) {
    fields.read("name", device.name);
    fields.require("cpu_mhz", device.cpu_mhz);
    fields.read("cpu_cores", device.cpu_cores);
    fields.read_name("gpu", device.gpu, {{"none", budget::Gpu::none}, {"discrete", budget::Gpu::discrete}});
    fields.read("memory_mb", device.memory_mb);
    fields.read("triangles_per_second", device.triangles_per_second);
    fields.read("points_per_second", device.points_per_second);
    fields.read("flat_triangles_per_second", device.flat_triangles_per_second);
}

budget::Display read_display(const Fields& fields) {
    budget::Display display;
    fields.require("width", display.width);
    fields.require("height", display.height);
    return display;
}

void read_preference(const Fields& fields, budget::Preference& preference) {
    fields.read("triangles", preference.triangles);
    fields.read("quality", preference.quality);
    fields.read("target_fps", preference.target_fps);
}

budget::Network read_network(const Fields& fields) {
    budget::Network network;
    fields.require("downlink_mbps", network.downlink_mbps);
    fields.read("rtt_ms", network.rtt_ms);
    fields.read("max_wait_s", network.max_wait_s);
    return network;
}

void read_reference(const Fields& fields, budget::Reference& reference) {
    fields.read("capacity_mhz", reference.capacity_mhz);
    fields.read("triangles", reference.triangles);
}

shading::View read_view(const Fields& fields) {
    shading::View view;
    fields.require("eye", view.eye);
    fields.read("target", view.target);
    fields.read("fov_y_deg", view.fov_y_deg);
    fields.read("light", view.light);
    return view;
}

// All of a plan request but its asset.
void read_circumstances(const Fields& fields, PlanRequest& request) {
    if (const auto device = fields.object("device"))
        read_device(*device, request.budget.device);
    else
        fields.refuse("device", "is missing");
    if (const auto display = fields.object("display")) request.budget.display = read_display(*display);
    if (const auto preference = fields.object("preference")) read_preference(*preference, request.budget.preference);
    if (const auto network = fields.object("network")) request.budget.network = read_network(*network);
    if (const auto reference = fields.object("reference")) read_reference(*reference, request.budget.reference);
    if (const auto view = fields.object("view")) request.view = read_view(*view);
    fields.read_name("profile", request.profile, {{"plain", Profile::plain}, {"lean", Profile::lean}});
    fields.read_name("shading", request.shading,
                     {{"hybrid", ShadingMode::hybrid}, {"gouraud", ShadingMode::gouraud}, {"flat", ShadingMode::flat}});
    fields.read_name("primitives", request.primitives,
                     {{"triangles", Primitives::triangles}, {"points", Primitives::points}, {"any", Primitives::any}});
}

Level read_level(const Fields& fields) {
    Level level;
    fields.require("triangles", level.triangles);
    fields.read("vertices", level.vertices);
    fields.read("rms_error", level.rms_error);
    fields.read("max_error", level.max_error);
    fields.read("rms_error_percent", level.rms_error_percent);
    fields.read("normal_error_degrees", level.normal_error_degrees);
    fields.read("bytes", level.bytes);
    fields.read("texture_bytes", level.texture_bytes);
    fields.read("encode_ms", level.encode_ms);
    fields.read("url", level.url);
    return level;
}

Hierarchy read_hierarchy(const Fields& fields) {
    Hierarchy hierarchy;
    fields.require("tiles", hierarchy.tiles);
    fields.read("depth", hierarchy.depth);
    fields.read("triangles", hierarchy.triangles);
    fields.read("bytes", hierarchy.bytes);
    fields.read("max_error", hierarchy.max_error);
    fields.read("bake_ms", hierarchy.bake_ms);
    return hierarchy;
}

Asset read_asset(const Fields& fields) {
    Asset asset;
    fields.require("id", asset.id);
    fields.require("name", asset.name);
    fields.require("kind", asset.kind);
    fields.require("triangles", asset.triangles);
    fields.require("vertices", asset.vertices);
    if (!fields.has("status")) fields.refuse("status", "is missing");
    fields.read_name("status", asset.status,
                     {{"baking", AssetStatus::baking}, {"ready", AssetStatus::ready}, {"failed", AssetStatus::failed}});
    fields.read("error", asset.error);
    fields.read("bake_ms", asset.bake_ms);
    fields.read("progress", asset.progress);
    fields.read("peak_memory_bytes", asset.peak_memory_bytes);
    fields.read("bounds_min", asset.bounds_min);
    fields.read("bounds_max", asset.bounds_max);
    for (const Fields& level : fields.objects("levels")) asset.levels.push_back(read_level(level));
    if (const auto hierarchy = fields.object("hierarchy")) asset.hierarchy = read_hierarchy(*hierarchy);
    fields.read("warnings", asset.warnings);
    return asset;
}

// Reads a whole message with read(fields) and gives its value or the first error.
template <class Read>
auto parse_message(const Json& json, Read read) -> Result<decltype(read(std::declval<Fields>()))> {
    std::optional<Error> error;
    auto message = read(Fields(json, "", error));
    if (error) return *error;
    return message;
}

template <class Read>
auto parse_message(std::string_view text, Read read) -> Result<decltype(read(std::declval<Fields>()))> {
    auto json = parse_json(text);
    if (!json) return json.error();
    return parse_message(*json, read);
}

Result<PlanRequest> validated(Result<PlanRequest> request) {
    if (!request) return request;
    if (auto status = budget::validate(request->budget); !status) return status.error();
    if (request->view)
        if (auto status = shading::validate(*request->view); !status) return status.error();
    return request;
}

}  // namespace

Result<PlanRequest> parse_plan_request(std::string_view json) {
    return validated(parse_message(json, [](const Fields& fields) {
        PlanRequest request;
        fields.require("asset", request.asset);
        if (fields.has("asset") && request.asset.empty()) fields.refuse("asset", "must not be empty");
        read_circumstances(fields, request);
        return request;
    }));
}

Result<PlanRequest> parse_device_file(std::string_view text) {
    auto json = parse_json(text);
    if (!json) return json.error();
    if (json->is_object() && !json->contains("device")) {
        Json device = *json;
        (*json)["device"] = std::move(device);
    }
    return validated(parse_message(*json, [](const Fields& fields) {
        PlanRequest request;
        fields.read("asset", request.asset);
        read_circumstances(fields, request);
        return request;
    }));
}

Result<PlanResponse> parse_plan_response(std::string_view json) {
    return parse_message(json, [](const Fields& fields) {
        PlanResponse response;
        fields.require("dlr", response.dlr);
        fields.require("ncp", response.ncp);
        fields.read("rup", response.rup);
        for (const char* name : {"budget", "level", "shading", "content"})
            if (!fields.has(name)) fields.refuse(name, "is missing");
        if (const auto budget = fields.object("budget")) {
            budget->require("triangles", response.budget.triangles);
            budget->require("limited_by", response.budget.limited_by);
            budget->read("feasible", response.budget.feasible);
            budget->read("points", response.budget.points);
        }
        if (const auto level = fields.object("level")) {
            level->require("triangles", response.level.triangles);
            level->read("vertices", response.level.vertices);
            level->read("points", response.level.points);
            level->read("rms_error", response.level.rms_error);
            level->read("max_error", response.level.max_error);
            level->read("rms_error_percent", response.level.rms_error_percent);
            level->read("normal_error_degrees", response.level.normal_error_degrees);
            level->read("screen_space_error_px", response.level.screen_space_error_px);
            if (const auto outside = level->object("outside")) {
                OutsideError& error = response.level.outside.emplace();
                outside->require("rms_error", error.rms_error);
                outside->require("max_error", error.max_error);
            }
        }
        if (const auto shading = fields.object("shading")) {
            shading->read("distance", response.shading.distance);
            shading->require("gouraud", response.shading.gouraud);
            shading->require("flat", response.shading.flat);
            shading->read("mode", response.shading.mode);
            if (const auto operations = shading->object("operations")) {
                operations->read("criterion", response.shading.operations.criterion);
                operations->read("total", response.shading.operations.total);
            }
        }
        if (const auto content = fields.object("content")) {
            content->require("url", response.content.url);
            content->require("bytes", response.content.bytes);
            content->read("media_type", response.content.media_type);
            content->read("profile", response.content.profile);
        }
        if (const auto crossing = fields.object("crossing")) {
            Crossing& at = response.crossing.emplace();
            crossing->read("distance", at.distance);
            crossing->require("triangles_error_percent", at.triangles_error_percent);
            crossing->require("points_error_percent", at.points_error_percent);
        }
        for (const Fields& item : fields.objects("left_out")) {
            LeftOut left_out;
            item.require("what", left_out.what);
            item.read("bytes", left_out.bytes);
            response.left_out.push_back(std::move(left_out));
        }
        if (const auto timing = fields.object("timing_ms")) {
            timing->read("plan", response.timing_ms.plan);
            timing->read("cut", response.timing_ms.cut);
            timing->read("encode", response.timing_ms.encode);
        }
        fields.read("warnings", response.warnings);
        return response;
    });
}

Result<Asset> parse_asset(std::string_view json) {
    return parse_message(json, read_asset);
}

Result<std::vector<Asset>> parse_assets(std::string_view json) {
    return parse_message(json, [](const Fields& fields) {
        std::vector<Asset> assets;
        if (!fields.has("assets")) fields.refuse("assets", "is missing");
        for (const Fields& asset : fields.objects("assets")) assets.push_back(read_asset(asset));
        return assets;
    });
}

Result<Problem> parse_problem(std::string_view json) {
    return parse_message(json, [](const Fields& fields) {
        Problem problem;
        std::uint32_t status = 0;
        fields.require("status", status);
        if (!fields.failed() && (status < 100 || status > 599)) fields.refuse("status", "must be an HTTP status");
        problem.status = static_cast<int>(status);
        fields.read("title", problem.title);
        fields.read("detail", problem.detail);
        fields.read("type", problem.type);
        return problem;
    });
}

Result<ShadingMode> parse_shading_mode(std::string_view name) {
    for (const ShadingMode mode : {ShadingMode::hybrid, ShadingMode::gouraud, ShadingMode::flat})
        if (name == shading_mode_name(mode)) return mode;
    return invalid_input("shading must be hybrid, gouraud or flat, got \"" + std::string(name) + "\"");
}

Result<Primitives> parse_primitives(std::string_view name) {
    for (const Primitives primitives : {Primitives::triangles, Primitives::points, Primitives::any})
        if (name == primitives_name(primitives)) return primitives;
    return invalid_input("primitives must be triangles, points or any, got \"" + std::string(name) + "\"");
}

const char* status_name(AssetStatus status) {
    switch (status) {
        case AssetStatus::baking:
            return "baking";
        case AssetStatus::ready:
            return "ready";
        case AssetStatus::failed:
            return "failed";
    }
    return "failed";
}

const char* profile_name(Profile profile) {
    return profile == Profile::lean ? "lean" : "plain";
}

const char* shading_mode_name(ShadingMode mode) {
    switch (mode) {
        case ShadingMode::hybrid:
            return "hybrid";
        case ShadingMode::gouraud:
            return "gouraud";
        case ShadingMode::flat:
            return "flat";
    }
    return "hybrid";
}

const char* primitives_name(Primitives primitives) {
    switch (primitives) {
        case Primitives::triangles:
            return "triangles";
        case Primitives::points:
            return "points";
        case Primitives::any:
            return "any";
    }
    return "triangles";
}

Problem problem_of(const Error& error) {
    const auto problem = [&](int status, const char* title, const char* kind) {
        return Problem{status, title, error.message, std::string("urn:lodestream:problem:") + kind};
    };
    switch (error.code) {
        case ErrorCode::invalid_input:
            return problem(422, "Invalid input", "invalid-input");
        case ErrorCode::unsupported:
            return problem(415, "Unsupported format", "unsupported");
        case ErrorCode::limit_exceeded:
            return problem(413, "Too large", "limit-exceeded");
        case ErrorCode::not_found:
            return problem(404, "Not found", "not-found");
        case ErrorCode::conflict:
            return problem(409, "Conflict", "conflict");
        case ErrorCode::unauthorized:
            return problem(401, "Token needed", "unauthorized");
        case ErrorCode::unavailable:
            return problem(503, "Not available now", "unavailable");
        case ErrorCode::io:
            return problem(500, "Storage or network failed", "io");
        case ErrorCode::internal:
            break;
    }
    return problem(500, "Internal error", "internal");
}

}  // namespace lodestream::proto
