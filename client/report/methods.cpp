#include "client/report/methods.h"

#include <fstream>
#include <iterator>

namespace lodestream::report {

Result<proto::MethodRun> read_methods(const std::filesystem::path& file) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(file, error);
    if (error) return fail(ErrorCode::io, "cannot read " + file.string() + ": " + error.message());
    if (bytes > max_methods_file_bytes)
        return fail(ErrorCode::limit_exceeded, file.string() + " has " + std::to_string(bytes) + " bytes; at most " +
                                                   std::to_string(max_methods_file_bytes) + " are read");
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    Result<proto::MethodRun> run = proto::parse_method_run(text);
    if (!run)
        return invalid_input(file.string() +
                             " is not what the simplification benchmark writes: " + run.error().message);
    return run;
}

}  // namespace lodestream::report
