#include "common/codec/glb.h"

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <string>

namespace lodestream::codec {
namespace {

static_assert(std::endian::native == std::endian::little, "GLB is little-endian and is written as it lies in memory");

constexpr std::uint32_t magic = 0x46546c67;       // "glTF"
constexpr std::uint32_t json_chunk = 0x4e4f534a;  // "JSON"
constexpr std::uint32_t binary_chunk = 0x004e4942;
constexpr std::size_t header_bytes = 12;
constexpr std::size_t chunk_header_bytes = 8;

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t offset) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + offset, sizeof word);
    return word;
}

void append(std::vector<std::byte>& bytes, const void* data, std::size_t size) {
    const auto* first = static_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), first, first + size);
}

// Takes the chunk of `type` from the front of `rest`; empty where `rest` does not begin with a whole one.
std::span<const std::byte> take_chunk(std::span<const std::byte>& rest, std::uint32_t type) {
    if (rest.size() < chunk_header_bytes || word_at(rest, 4) != type) return {};
    const std::size_t length = word_at(rest, 0);
    if (length % 4 != 0 || length > rest.size() - chunk_header_bytes) return {};
    const auto chunk = rest.subspan(chunk_header_bytes, length);
    rest = rest.subspan(chunk_header_bytes + length);
    return chunk;
}

// Brackets outside strings; the parser checks that they match.
std::size_t nesting_depth(std::string_view text) {
    std::size_t depth = 0, deepest = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string && c == '\\')
            ++i;
        else if (c == '"')
            in_string = !in_string;
        else if (!in_string && (c == '{' || c == '['))
            deepest = std::max(deepest, ++depth);
        else if (!in_string && (c == '}' || c == ']') && depth > 0)
            --depth;
    }
    return deepest;
}

template <std::size_t Count>
bool begins_with(std::span<const std::byte> bytes, const std::array<unsigned char, Count>& start) {
    return bytes.size() >= Count && std::memcmp(bytes.data(), start.data(), Count) == 0;
}

}  // namespace

int wrap_code(mesh::Wrap wrap) {
    switch (wrap) {
        case mesh::Wrap::repeat:
            return 10497;
        case mesh::Wrap::clamp_to_edge:
            return 33071;
        case mesh::Wrap::mirrored_repeat:
            return 33648;
    }
    return 10497;
}

std::string_view image_media_type(std::span<const std::byte> bytes) {
    if (begins_with<8>(bytes, {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'})) return "image/png";
    if (begins_with<3>(bytes, {0xff, 0xd8, 0xff})) return "image/jpeg";
    return "";
}

Result<nlohmann::json> parse_json(std::string_view text) {
    if (text.size() > max_json_bytes)
        return fail(ErrorCode::limit_exceeded, "JSON of more than " + std::to_string(max_json_bytes) + " bytes");
    if (nesting_depth(text) > max_json_depth)
        return fail(ErrorCode::limit_exceeded, "JSON nested deeper than " + std::to_string(max_json_depth));
    nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
    if (json.is_discarded()) return invalid_input("JSON syntax error");
    return json;
}

Result<Glb> split_glb(std::span<const std::byte> bytes) {
    if (bytes.size() < header_bytes || word_at(bytes, 0) != magic || word_at(bytes, 4) != 2)
        return invalid_input("GLB: not a version 2 header");
    if (word_at(bytes, 8) != bytes.size()) return invalid_input("GLB: the header's length is not the file's");
    std::span<const std::byte> rest = bytes.subspan(header_bytes);
    const auto text = take_chunk(rest, json_chunk);
    if (text.empty()) return invalid_input("GLB: no whole JSON chunk");
    Glb glb;
    if (!rest.empty()) {
        glb.binary = take_chunk(rest, binary_chunk);
        if (glb.binary.empty() || !rest.empty()) return invalid_input("GLB: damaged binary chunk");
    }
    Result<nlohmann::json> json = parse_json({reinterpret_cast<const char*>(text.data()), text.size()});
    if (!json) return fail(json.error().code, "GLB: " + json.error().message);
    glb.json = std::move(*json);
    return glb;
}

Result<Glb> split_glb_start(std::span<const std::byte> bytes) {
    if (bytes.size() < header_bytes || word_at(bytes, 0) != magic || word_at(bytes, 4) != 2 ||
        word_at(bytes, 8) < bytes.size())
        return invalid_input("GLB: not a version 2 header");
    std::span<const std::byte> rest = bytes.subspan(header_bytes);
    const auto text = take_chunk(rest, json_chunk);
    if (text.empty()) return invalid_input("GLB: no whole JSON chunk");
    Glb glb;
    if (rest.size() >= chunk_header_bytes) {
        if (word_at(rest, 4) != binary_chunk) return invalid_input("GLB: damaged binary chunk");
        const std::size_t length = word_at(rest, 0);
        glb.binary = rest.subspan(chunk_header_bytes);
        if (glb.binary.size() > length) return invalid_input("GLB: damaged binary chunk");
    }
    Result<nlohmann::json> json = parse_json({reinterpret_cast<const char*>(text.data()), text.size()});
    if (!json) return fail(json.error().code, "GLB: " + json.error().message);
    glb.json = std::move(*json);
    return glb;
}

Result<std::vector<std::byte>> join_glb(const nlohmann::json& json, std::vector<std::byte> binary) {
    std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (text.size() > max_json_bytes)
        return fail(ErrorCode::limit_exceeded, "glTF JSON of more than " + std::to_string(max_json_bytes) + " bytes");
    text.resize((text.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4);
    const std::uint64_t total =
        header_bytes + chunk_header_bytes + text.size() + (binary.empty() ? 0 : chunk_header_bytes + binary.size());
    if (total > std::numeric_limits<std::uint32_t>::max())
        return fail(ErrorCode::limit_exceeded, "a GLB file cannot exceed 4 GiB");
    std::vector<std::byte> glb;
    glb.reserve(total);
    const auto append_word = [&](std::uint64_t word) {
        const auto narrow = static_cast<std::uint32_t>(word);
        append(glb, &narrow, sizeof narrow);
    };
    for (const std::uint64_t word : {std::uint64_t{magic}, std::uint64_t{2}, total}) append_word(word);
    append_word(text.size());
    append_word(json_chunk);
    append(glb, text.data(), text.size());
    if (!binary.empty()) {
        append_word(binary.size());
        append_word(binary_chunk);
        append(glb, binary.data(), binary.size());
    }
    return glb;
}

}  // namespace lodestream::codec
