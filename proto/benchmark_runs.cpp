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

void read_model(const Fields& fields, MethodRun& run) {
    MethodLevel level;
    fields.require("model", level.model);
    fields.require("triangles", level.model_triangles);
    for (const Fields& method : fields.objects("methods")) {
        method.require("method", level.method);
        for (const Fields& one : method.objects("levels")) read_level(one, level, run.levels);
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

void read_model(const Fields& fields, CodecRun& run) {
    CodecTrial trial;
    fields.require("model", trial.model);
    fields.require("triangles", trial.triangles);
    for (const Fields& one : fields.objects("trials")) read_trial(one, trial, run.trials);
}

void read_match(const Fields& fields, SilhouetteMatch& match) {
    fields.require("recall", match.recall);
    fields.require("precision", match.precision);
    fields.require("f_measure", match.f_measure);
}

void read_score(const Fields& fields, PointsScore score, PointsRun& run) {
    fields.require("level", score.level);
    fields.require("is_scaled", score.is_scaled);
    fields.require("points", score.points);
    fields.require("instances", score.instances);
    fields.require("views", score.views);
    read_match(fields, score.match);
    fields.read("paper_f", score.paper_f);
    run.scores.push_back(std::move(score));
}

void read_setting(const Fields& fields, const std::string& model, PointsRun& run) {
    PointsSetting setting;
    setting.model = model;
    fields.require("varied", setting.varied);
    fields.require("filter", setting.filter);
    fields.require("slices", setting.slices);
    fields.require("side", setting.side);
    fields.require("point_size", setting.point_size);
    fields.require("points", setting.points);
    fields.require("holes", setting.holes);
    fields.require("hole_px", setting.hole_px);
    fields.require("views", setting.views);
    read_match(fields, setting.match);
    run.settings.push_back(std::move(setting));
}

void read_crowd(const Fields& fields, const std::string& model, PointsRun& run) {
    PointsCrowd crowd;
    crowd.model = model;
    fields.require("instances", crowd.instances);
    fields.require("full_triangles", crowd.full_triangles);
    fields.require("points", crowd.points);
    fields.require("full_ms", crowd.full_ms);
    fields.require("points_ms", crowd.points_ms);
    fields.read("paper_gain", crowd.paper_gain);
    fields.read("scaled_gain", crowd.scaled_gain);
    run.crowds.push_back(std::move(crowd));
}

void read_choice(const Fields& fields, const std::string& model, PointsRun& run) {
    PointsChoice choice;
    choice.model = model;
    fields.require("device", choice.device);
    fields.require("points_per_triangle", choice.points_per_triangle);
    fields.require("frame_share", choice.frame_share);
    fields.require("distance", choice.distance);
    fields.require("triangles", choice.triangles);
    fields.require("points", choice.points);
    fields.require("triangles_percent", choice.triangles_percent);
    fields.require("points_percent", choice.points_percent);
    fields.require("chose_points", choice.chose_points);
    fields.read("crossing", choice.crossing);
    run.choices.push_back(std::move(choice));
}

void read_picture(const Fields& fields, const std::string& model, PointsRun& run) {
    constexpr std::string_view base64 = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/=";
    PointsPicture picture;
    picture.model = model;
    fields.require("title", picture.title);
    fields.require("png", picture.png_base64);
    fields.read("panels", picture.panels);
    if (picture.png_base64.find_first_not_of(base64) != std::string::npos) fields.refuse("png", "is not base64");
    run.pictures.push_back(std::move(picture));
}

void read_model(const Fields& fields, PointsRun& run) {
    PointsScore score;
    fields.require("model", score.model);
    fields.require("triangles", score.triangles);
    for (const Fields& one : fields.objects("scores")) read_score(one, score, run);
    for (const Fields& one : fields.objects("settings")) read_setting(one, score.model, run);
    for (const Fields& one : fields.objects("crowds")) read_crowd(one, score.model, run);
    for (const Fields& one : fields.objects("choices")) read_choice(one, score.model, run);
    for (const Fields& one : fields.objects("pictures")) read_picture(one, score.model, run);
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

void read_bake(const Fields& fields, SceneBake bake, std::vector<SceneBake>& out) {
    fields.require("objects", bake.objects);
    fields.require("triangles", bake.triangles);
    fields.require("tiles", bake.tiles);
    fields.require("bytes", bake.bytes);
    fields.require("wall_ms", bake.wall_ms);
    fields.require("cpu_ms", bake.cpu_ms);
    fields.require("tiles_ms", bake.tiles_ms);
    fields.require("peak_memory_bytes", bake.peak_memory_bytes);
    out.push_back(std::move(bake));
}

void read_model(const Fields& fields, SceneRun& run) {
    SceneBake bake;
    fields.require("model", bake.scene);
    for (const Fields& one : fields.objects("bakes")) read_bake(one, bake, run.bakes);
}

// A run whose rows stand below its models.
template <class Run>
Result<Run> parse_run(std::string_view json) {
    const Result<Json> document = parse_json(json);
    if (!document) return document.error();
    std::optional<Error> error;
    const Fields fields(*document, "", error);
    Run run;
    run.origin = read_origin(fields);
    for (const Fields& model : fields.objects("models")) read_model(model, run);
    if (error) return *error;
    return run;
}

}  // namespace

Result<MethodRun> parse_method_run(std::string_view json) {
    return parse_run<MethodRun>(json);
}

Result<CodecRun> parse_codec_run(std::string_view json) {
    return parse_run<CodecRun>(json);
}

Result<PointsRun> parse_points_run(std::string_view json) {
    return parse_run<PointsRun>(json);
}

Result<SceneRun> parse_scene_run(std::string_view json) {
    return parse_run<SceneRun>(json);
}

}  // namespace lodestream::proto
