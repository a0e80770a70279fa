#include "proto/benchmark_runs.h"

#include "proto/json_reader.h"

namespace lodestream::proto {

namespace {

void read_level(const Fields& fields, MethodLevel level, std::vector<MethodLevel>& out) {
    fields.require("asked", level.asked);
    fields.require("triangles", level.triangles);
    fields.require("wall_ms", level.wall_ms);
    fields.require("cpu_ms", level.cpu_ms);
    fields.read("rms_error_percent", level.rms_error_percent);
    fields.read("max_error_percent", level.max_error_percent);
    fields.read(fields.has("own_normals_image_rms") ? "own_normals_image_rms" : "image_rms", level.image_rms);
    out.push_back(std::move(level));
}

void read_model(const Fields& fields, std::vector<MethodLevel>& out) {
    MethodLevel level;
    fields.require("model", level.model);
    fields.require("triangles", level.model_triangles);
    for (const Fields& method : fields.objects("methods")) {
        method.require("method", level.method);
        for (const Fields& one : method.objects("levels")) read_level(one, level, out);
    }
}

void read_trial(const Fields& fields, CodecTrial trial, std::vector<CodecTrial>& out) {
    fields.require("codec", trial.codec);
    fields.require("setting", trial.setting);
    fields.read("is_default", trial.is_default);
    fields.require("bytes", trial.bytes);
    fields.require("encode_ms", trial.encode_ms);
    fields.require("decode_ms", trial.decode_ms);
    fields.require("image_rms", trial.image_rms);
    out.push_back(std::move(trial));
}

void read_model(const Fields& fields, std::vector<CodecTrial>& out) {
    CodecTrial trial;
    fields.require("model", trial.model);
    fields.require("triangles", trial.triangles);
    for (const Fields& one : fields.objects("trials")) read_trial(one, trial, out);
}

RunOrigin read_origin(const Fields& fields) {
    RunOrigin origin;
    if (const std::optional<Fields> from = fields.object("run")) {
        from->require("command", origin.command);
        from->require("commit", origin.commit);
        from->require("date", origin.date);
        from->require("cpu", origin.cpu);
        from->require("cores", origin.cores);
    } else {
        fields.refuse("run", "is missing");
    }
    return origin;
}

// A run whose rows stand below its models. `rows`: the member of Run that they become
template <class Run, class Row>
Result<Run> parse_run(std::string_view json, std::vector<Row> Run::*rows) {
    const Result<Json> document = parse_json(json);
    if (!document) return document.error();
    std::optional<Error> error;
    const Fields fields(*document, "", error);
    Run run;
    run.origin = read_origin(fields);
    for (const Fields& model : fields.objects("models")) read_model(model, run.*rows);
    if (error) return *error;
    return run;
}

}  // namespace

Result<MethodRun> parse_method_run(std::string_view json) {
    return parse_run(json, &MethodRun::levels);
}

Result<CodecRun> parse_codec_run(std::string_view json) {
    return parse_run(json, &CodecRun::trials);
}

}  // namespace lodestream::proto
