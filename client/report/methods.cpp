#include "client/report/methods.h"

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

namespace lodestream::report {
namespace {

using nlohmann::json;

std::optional<double> optional_number(const json& level, const char* key) {
    return level.contains(key) ? std::optional(level.at(key).get<double>()) : std::nullopt;
}

MethodLevel level_of(const json& model, const json& method, const json& level) {
    MethodLevel out;
    out.model = model.at("model").get<std::string>();
    out.model_triangles = model.at("triangles").get<std::uint64_t>();
    out.method = method.at("method").get<std::string>();
    out.asked = level.at("asked").get<std::uint64_t>();
    out.triangles = level.at("triangles").get<std::uint64_t>();
    out.wall_ms = level.at("wall_ms").get<double>();
    out.cpu_ms = level.at("cpu_ms").get<double>();
    out.rms_error_percent = optional_number(level, "rms_error_percent");
    out.max_error_percent = optional_number(level, "max_error_percent");
    out.image_rms = optional_number(level, "own_normals_image_rms");
    if (!out.image_rms) out.image_rms = optional_number(level, "image_rms");
    return out;
}

MethodComparison comparison_of(const json& document) {
    MethodComparison out;
    const json& run = document.at("run");
    out.provenance.command = run.at("command").get<std::string>();
    out.provenance.commit = run.at("commit").get<std::string>();
    out.provenance.date = run.at("date").get<std::string>();
    out.provenance.cpu = run.at("cpu").get<std::string>();
    out.provenance.cores = run.at("cores").get<std::uint32_t>();
    for (const json& model : document.at("models"))
        for (const json& method : model.at("methods"))
            for (const json& level : method.at("levels")) out.levels.push_back(level_of(model, method, level));
    return out;
}

}  // namespace

Result<MethodComparison> read_methods(const std::filesystem::path& file) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(file, error);
    if (error) return fail(ErrorCode::io, "cannot read " + file.string() + ": " + error.message());
    if (bytes > max_methods_file_bytes)
        return fail(ErrorCode::limit_exceeded, file.string() + " has " + std::to_string(bytes) + " bytes; at most " +
                                                   std::to_string(max_methods_file_bytes) + " are read");
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    try {
        return comparison_of(json::parse(text));
    } catch (const json::exception& why) {
        return invalid_input(file.string() + " is not what the simplification benchmark writes: " + why.what());
    }
}

}  // namespace lodestream::report
