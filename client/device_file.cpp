#include "client/device_file.h"

#include <fstream>
#include <iterator>
#include <string>

namespace lodestream::client {

namespace {

constexpr std::uintmax_t max_device_file_bytes = 1u << 20;

}  // namespace

Result<proto::PlanRequest> read_device_file(const std::filesystem::path& path) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    if (error) return fail(ErrorCode::io, path.string() + ": " + error.message());
    if (size > max_device_file_bytes)
        return fail(ErrorCode::limit_exceeded, path.string() + ": too large for a device file");
    std::ifstream file(path, std::ios::binary);
    const std::string json((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (file.bad()) return fail(ErrorCode::io, path.string() + ": cannot be read");
    auto request = proto::parse_device_file(json);
    if (!request) return fail(request.error().code, path.string() + ": " + request.error().message);
    return request;
}

}  // namespace lodestream::client
