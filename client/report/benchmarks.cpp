#include "client/report/benchmarks.h"

#include <fstream>
#include <iterator>

namespace lodestream::report {

namespace {

Result<std::string> read_text(const std::filesystem::path& file) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(file, error);
    if (error) return fail(ErrorCode::io, "cannot read " + file.string() + ": " + error.message());
    if (bytes > max_benchmark_file_bytes)
        return fail(ErrorCode::limit_exceeded, file.string() + " has " + std::to_string(bytes) + " bytes; at most " +
                                                   std::to_string(max_benchmark_file_bytes) + " are read");
    std::ifstream in(file, std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(in), {}};
}

template <class Run>
Result<Run> read_run(const std::filesystem::path& file, Result<Run> (*parse)(std::string_view), const char* benchmark) {
    const Result<std::string> text = read_text(file);
    if (!text) return text.error();
    Result<Run> run = parse(*text);
    if (!run)
        return invalid_input(file.string() + " is not what the " + benchmark +
                             " benchmark writes: " + run.error().message);
    return run;
}

}  // namespace

Result<proto::MethodRun> read_methods(const std::filesystem::path& file) {
    return read_run(file, proto::parse_method_run, "simplification");
}

Result<proto::CodecRun> read_codecs(const std::filesystem::path& file) {
    return read_run(file, proto::parse_codec_run, "codec");
}

Result<proto::PointsRun> read_points(const std::filesystem::path& file) {
    return read_run(file, proto::parse_points_run, "points");
}

Result<proto::SceneRun> read_scenes(const std::filesystem::path& file) {
    return read_run(file, proto::parse_scene_run, "hlod");
}

}  // namespace lodestream::report
