#include "proto/records.h"

#include <nlohmann/json.hpp>

namespace lodestream::proto {

namespace {

using Object = nlohmann::ordered_json;

std::string print(const Object& object) {
    return object.dump(-1, ' ', false, Object::error_handler_t::replace);
}

}  // namespace

std::string bake_record(const Asset& asset) {
    const Object whole = Object::parse(to_json(asset));
    Object record{{"asset", asset.name}};
    for (const char* field : {"kind", "triangles", "vertices", "bake_ms", "peak_memory_bytes", "levels", "warnings"})
        record[field] = whole.at(field);
    if (asset.hierarchy) record["hierarchy"] = whole.at("hierarchy");
    return print(record);
}

std::string cut_record(const CutRecord& cut) {
    return print({{"asset", cut.asset},
                  {"triangles", cut.triangles},
                  {"vertices", cut.vertices},
                  {"bytes", cut.bytes},
                  {"cut_ms", cut.cut_ms},
                  {"encode_ms", cut.encode_ms},
                  {"rms_error", cut.rms_error},
                  {"max_error", cut.max_error},
                  {"rms_error_percent", cut.rms_error_percent},
                  {"out", cut.out}});
}

std::string cut_record(const PointCutRecord& cut) {
    return print({{"asset", cut.asset},
                  {"points", cut.points},
                  {"bytes", cut.bytes},
                  {"cut_ms", cut.cut_ms},
                  {"encode_ms", cut.encode_ms},
                  {"rms_error", cut.rms_error},
                  {"max_error", cut.max_error},
                  {"radius", cut.radius},
                  {"rms_error_percent", cut.rms_error_percent},
                  {"out", cut.out}});
}

std::string content_extras(const std::string& asset, const PlanResponse& plan) {
    const Object whole = Object::parse(to_json(plan));
    Object extras{{"asset", asset}, {"level", whole.at("level")}, {"shading", whole.at("shading")}};
    extras["level"].erase("vertices");               // known only after encoding
    extras["level"].erase("screen_space_error_px");  // of one client's canvas
    extras["shading"].erase("distance");             // of one client's view
    return print(extras);
}

}  // namespace lodestream::proto
