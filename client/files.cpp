#include "client/files.h"

#include <cstdio>
#include <fstream>
#include <iterator>
#include <string_view>

namespace lodestream::client {

namespace {

constexpr std::uintmax_t max_device_file_bytes = 1u << 20;
constexpr std::string_view built_in_prefix = "builtin:";
constexpr std::uintmax_t max_motion_bytes = 256u << 20;

}  // namespace

Result<std::string> read_text(const std::filesystem::path& path, std::uintmax_t max_bytes, const std::string& what) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    if (error) return fail(ErrorCode::io, path.string() + ": " + error.message());
    if (size > max_bytes) return fail(ErrorCode::limit_exceeded, path.string() + ": too large for " + what);
    std::ifstream file(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (file.bad()) return fail(ErrorCode::io, path.string() + ": cannot be read");
    return text;
}

Result<proto::PlanRequest> read_device_file(const std::filesystem::path& path) {
    const auto json = read_text(path, max_device_file_bytes, "a device file");
    if (!json) return json.error();
    auto request = proto::parse_device_file(*json);
    if (!request) return fail(request.error().code, path.string() + ": " + request.error().message);
    return request;
}

Result<motion::Trace> read_motion(const std::string& motion) {
    if (motion.starts_with(built_in_prefix)) {
        const auto kind = motion::parse_kind(std::string_view(motion).substr(built_in_prefix.size()));
        if (!kind) return kind.error();
        return motion::built_in({*kind});
    }
    const auto text = read_text(motion, max_motion_bytes, "a motion");
    if (!text) return text.error();
    auto trace = motion::parse_csv(*text);
    if (!trace) return fail(trace.error().code, motion + ": " + trace.error().message);
    return trace;
}

Status write_text(const std::filesystem::path& path, const std::string& text) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file << text << std::flush;
    if (!file) return fail(ErrorCode::io, "cannot write " + path.string());
    return Nothing{};
}

Status make_folder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return fail(ErrorCode::io, "cannot make the folder " + folder.string() + ": " + error.message());
    return Nothing{};
}

std::filesystem::path numbered_png(const std::filesystem::path& folder, std::size_t number) {
    char name[32];
    std::snprintf(name, sizeof name, "%06zu.png", number);
    return folder / name;
}

}  // namespace lodestream::client
