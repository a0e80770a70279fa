// The messages' JSON. Members stand in the contract's order, so that a reader finds them where the documents show them.
#include <nlohmann/json.hpp>

#include "proto/messages.h"

namespace lodestream::proto {

namespace {

using Object = nlohmann::ordered_json;

// Text from outside may not be UTF-8; JSON must be.
std::string print(const Object& object) {
    return object.dump(-1, ' ', false, Object::error_handler_t::replace);
}

template <class T>
Object or_null(const std::optional<T>& value) {
    return value ? Object(*value) : Object(nullptr);
}

Object vector_of(const Vec3d& v) {
    return Object::array({v.x, v.y, v.z});
}

Object object_of(const Level& level) {
    return {{"triangles", level.triangles},
            {"vertices", level.vertices},
            {"rms_error", level.rms_error},
            {"max_error", level.max_error},
            {"rms_error_percent", level.rms_error_percent},
            {"normal_error_degrees", level.normal_error_degrees},
            {"bytes", level.bytes},
            {"texture_bytes", level.texture_bytes},
            {"encode_ms", level.encode_ms},
            {"url", level.url}};
}

Object object_of(const Hierarchy& hierarchy) {
    return {{"tiles", hierarchy.tiles}, {"depth", hierarchy.depth},         {"triangles", hierarchy.triangles},
            {"bytes", hierarchy.bytes}, {"max_error", hierarchy.max_error}, {"bake_ms", hierarchy.bake_ms}};
}

Object object_of(const Asset& asset) {
    Object levels = Object::array();
    for (const Level& level : asset.levels) levels.push_back(object_of(level));
    Object object{{"id", asset.id},
                  {"name", asset.name},
                  {"kind", asset.kind},
                  {"triangles", asset.triangles},
                  {"vertices", asset.vertices},
                  {"status", status_name(asset.status)}};
    if (!asset.error.empty()) object["error"] = asset.error;
    object["bake_ms"] = asset.bake_ms;
    object["progress"] = asset.progress;
    object["peak_memory_bytes"] = asset.peak_memory_bytes;
    if (asset.bounds_min) object["bounds_min"] = *asset.bounds_min;
    if (asset.bounds_max) object["bounds_max"] = *asset.bounds_max;
    object["levels"] = std::move(levels);
    if (asset.hierarchy) object["hierarchy"] = object_of(*asset.hierarchy);
    object["warnings"] = asset.warnings;
    return object;
}

Object object_of(const budget::DeviceReport& device) {
    Object object;
    if (!device.name.empty()) object["name"] = device.name;
    object["cpu_mhz"] = device.cpu_mhz;
    object["cpu_cores"] = device.cpu_cores;
    object["gpu"] = device.gpu == budget::Gpu::discrete ? "discrete" : "none";
    object["memory_mb"] = or_null(device.memory_mb);
    object["triangles_per_second"] = or_null(device.triangles_per_second);
    if (device.points_per_second) object["points_per_second"] = *device.points_per_second;
    if (device.flat_triangles_per_second) object["flat_triangles_per_second"] = *device.flat_triangles_per_second;
    return object;
}

}  // namespace

std::string to_json(const PlanRequest& request) {
    const budget::Request& budget = request.budget;
    Object object;
    if (!request.asset.empty()) object["asset"] = request.asset;
    object["device"] = object_of(budget.device);
    if (budget.display) object["display"] = {{"width", budget.display->width}, {"height", budget.display->height}};
    object["preference"] = {{"triangles", or_null(budget.preference.triangles)},
                            {"quality", budget.preference.quality},
                            {"target_fps", budget.preference.target_fps}};
    if (budget.network)
        object["network"] = {{"downlink_mbps", budget.network->downlink_mbps},
                             {"rtt_ms", budget.network->rtt_ms},
                             {"max_wait_s", budget.network->max_wait_s}};
    object["reference"] = {{"capacity_mhz", budget.reference.capacity_mhz},
                           {"triangles", or_null(budget.reference.triangles)}};
    if (request.view)
        object["view"] = {{"eye", vector_of(request.view->eye)},
                          {"target", vector_of(request.view->target)},
                          {"fov_y_deg", request.view->fov_y_deg},
                          {"light", vector_of(request.view->light)}};
    object["profile"] = profile_name(request.profile);
    object["shading"] = shading_mode_name(request.shading);
    object["primitives"] = primitives_name(request.primitives);
    return print(object);
}

std::string to_json(const PlanResponse& response) {
    Object left_out = Object::array();
    for (const LeftOut& item : response.left_out) left_out.push_back({{"what", item.what}, {"bytes", item.bytes}});
    const auto& [budget, level, shading, content, timing] =
        std::tie(response.budget, response.level, response.shading, response.content, response.timing_ms);
    Object object{
        {"dlr", response.dlr},
        {"ncp", response.ncp},
        {"rup", or_null(response.rup)},
        {"budget", {{"triangles", budget.triangles}, {"limited_by", budget.limited_by}, {"feasible", budget.feasible}}},
        {"level",
         {{"triangles", level.triangles},
          {"vertices", level.vertices},
          {"rms_error", level.rms_error},
          {"max_error", level.max_error},
          {"rms_error_percent", level.rms_error_percent},
          {"normal_error_degrees", level.normal_error_degrees},
          {"screen_space_error_px", level.screen_space_error_px}}},
        {"shading",
         {{"distance", shading.distance},
          {"gouraud", shading.gouraud},
          {"flat", shading.flat},
          {"operations", {{"criterion", shading.operations.criterion}, {"total", shading.operations.total}}},
          {"mode", shading.mode}}},
        {"content",
         {{"url", content.url},
          {"bytes", content.bytes},
          {"media_type", content.media_type},
          {"profile", content.profile}}},
        {"left_out", std::move(left_out)},
        {"timing_ms", {{"plan", timing.plan}, {"cut", timing.cut}, {"encode", timing.encode}}},
        {"warnings", response.warnings}};
    if (budget.points) object["budget"]["points"] = *budget.points;
    if (level.points > 0) object["level"]["points"] = level.points;
    if (level.outside)
        object["level"]["outside"] = {{"rms_error", level.outside->rms_error}, {"max_error", level.outside->max_error}};
    if (const auto& crossing = response.crossing) {
        object["crossing"] = {{"triangles_error_percent", crossing->triangles_error_percent},
                              {"points_error_percent", crossing->points_error_percent}};
        if (crossing->distance) object["crossing"]["distance"] = *crossing->distance;
    }
    return print(object);
}

std::string to_json(const Asset& asset) {
    return print(object_of(asset));
}

std::string to_json(const std::vector<Asset>& assets) {
    Object list = Object::array();
    for (const Asset& asset : assets) list.push_back(object_of(asset));
    return print({{"assets", std::move(list)}});
}

std::string to_json(const Problem& problem) {
    return print(
        {{"type", problem.type}, {"title", problem.title}, {"status", problem.status}, {"detail", problem.detail}});
}

}  // namespace lodestream::proto
