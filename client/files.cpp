#include "client/files.h"

#include <fstream>
#include <iterator>

namespace lodestream::client {

namespace {

constexpr std::uintmax_t max_device_file_bytes = 1u << 20;

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

}  // namespace lodestream::client
