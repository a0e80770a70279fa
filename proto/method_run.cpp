#include "proto/method_run.h"

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

}  // namespace

Result<MethodRun> parse_method_run(std::string_view json) {
    const Result<Json> document = parse_json(json);
    if (!document) return document.error();
    std::optional<Error> error;
    const Fields fields(*document, "", error);
    MethodRun run;
    if (const std::optional<Fields> from = fields.object("run")) {
        from->require("command", run.command);
        from->require("commit", run.commit);
        from->require("date", run.date);
        from->require("cpu", run.cpu);
        from->require("cores", run.cores);
    } else {
        fields.refuse("run", "is missing");
    }
    for (const Fields& model : fields.objects("models")) read_model(model, run.levels);
    if (error) return *error;
    return run;
}

}  // namespace lodestream::proto
