#include "server/http/packing.h"

#include <algorithm>
#include <fstream>

#include "proto/gzip.h"

namespace lodestream::http {
namespace {

constexpr std::size_t json_length_at = 12, json_at = 20;  // of a GLB: its first chunk's

std::size_t end_of_json(std::string_view glb) {
    if (glb.size() < json_at) return glb.size();
    std::uint32_t length = 0;
    for (std::size_t i = 4; i-- > 0;) length = length << 8 | static_cast<unsigned char>(glb[json_length_at + i]);
    return std::min(json_at + std::size_t{length}, glb.size());
}

}  // namespace

bool takes_gzip(const Request& request) {
    const auto codings = request.headers.find("accept-encoding");
    return codings != request.headers.end() && !request.headers.contains("range") &&
           proto::accepts_gzip(codings->second);
}

void pack_body(Response& response, const Request& request) {
    if (response.body.size() < least_packed_bytes || response.body.size() > most_packed_bytes ||
        response.headers.contains("content-encoding"))
        return;
    response.headers["vary"] = "Accept-Encoding";
    if (!takes_gzip(request)) return;
    response.body = proto::gzip(response.body);
    response.headers["content-encoding"] = "gzip";
}

std::optional<std::string> packed_glb(const store::StoredFile& file) {
    std::ifstream in(file.path, std::ios::binary);
    std::string bytes(file.bytes, '\0');
    if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) return std::nullopt;
    return proto::gzip(bytes, end_of_json(bytes));
}

}  // namespace lodestream::http
