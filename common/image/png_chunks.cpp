#include "common/image/png_chunks.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace lodestream::image {
namespace {

constexpr std::string_view signature = "\x89PNG\r\n\x1a\n";
constexpr std::array<std::string_view, 5> kept{"IHDR", "PLTE", "tRNS", "IDAT", "IEND"};
constexpr std::size_t around_data = 12;  // bytes: length, type and checksum of a chunk

std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::uint64_t data_size(std::span<const std::byte> chunk) {
    std::uint64_t size = 0;
    for (std::size_t i = 0; i < 4; ++i) size = size << 8 | std::to_integer<std::uint64_t>(chunk[i]);
    return size;
}

}  // namespace

std::vector<std::byte> pixels_only(std::span<const std::byte> bytes) {
    const std::vector<std::byte> unchanged(bytes.begin(), bytes.end());
    if (!text_of(bytes).starts_with(signature)) return unchanged;
    std::vector<std::byte> result(bytes.begin(), bytes.begin() + signature.size());
    for (std::span<const std::byte> rest = bytes.subspan(signature.size()); !rest.empty();) {
        if (rest.size() < around_data || data_size(rest) > rest.size() - around_data) return unchanged;
        const std::span<const std::byte> chunk = rest.first(around_data + data_size(rest));
        const std::string_view type = text_of(chunk.subspan(4, 4));
        if (std::find(kept.begin(), kept.end(), type) != kept.end())
            result.insert(result.end(), chunk.begin(), chunk.end());
        if (type == "IEND") return result;
        rest = rest.subspan(chunk.size());
    }
    return unchanged;
}

}  // namespace lodestream::image
