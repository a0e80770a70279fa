#include "server/importer/images.h"

#include <climits>
#include <cstdlib>
#include <memory>

namespace {

// A PNG's compressed data can swell a thousandfold whatever size its header states, so stb_image allocates from an
// allowance that decode_grey16_png() sets by the stated size.
thread_local std::size_t allowance_bytes = 0;

void* take_memory(std::size_t bytes) {
    if (bytes > allowance_bytes) return nullptr;
    return std::malloc(bytes);
}
void* retake_memory(void* old, std::size_t bytes) {
    if (bytes > allowance_bytes) return nullptr;
    return std::realloc(old, bytes);
}

}  // namespace

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_MALLOC take_memory
#define STBI_REALLOC retake_memory
#define STBI_FREE std::free
#include <stb/stb_image.h>

namespace lodestream::importer {
namespace {

constexpr std::size_t info_allowance_bytes = 1 << 20;

struct Header {
    int width = 0, height = 0, channels = 0;
};

const stbi_uc* raw(std::span<const std::byte> bytes) {
    return reinterpret_cast<const stbi_uc*>(bytes.data());
}

bool read_header(std::span<const std::byte> bytes, Header& header) {
    if (bytes.size() > INT_MAX) return false;
    allowance_bytes = info_allowance_bytes;
    return stbi_info_from_memory(raw(bytes), static_cast<int>(bytes.size()), &header.width, &header.height,
                                 &header.channels) != 0 &&
           header.width > 0 && header.height > 0;
}

bool is_png(std::span<const std::byte> bytes) {
    return bytes.size() > 4 && bytes[0] == std::byte{0x89} && bytes[1] == std::byte{'P'};
}

}  // namespace

int add_image(std::span<const std::byte> bytes, const std::string& name, const Limits& limits, Soup& soup) {
    Header header;
    const auto drop = [&](const std::string& why) {
        soup.warn("image " + name + " dropped: " + why);
        return -1;
    };
    if (soup.image_bytes + bytes.size() > limits.image_bytes) return drop("more image bytes than the limit");
    if (!read_header(bytes, header)) return drop("neither readable PNG nor JPEG");
    const auto width = static_cast<std::uint32_t>(header.width), height = static_cast<std::uint32_t>(header.height);
    if (width > limits.image_side || height > limits.image_side) return drop("sides longer than the limit");
    const char* media_type = is_png(bytes) ? "image/png" : "image/jpeg";
    soup.image_bytes += bytes.size();
    soup.images.push_back({media_type, {bytes.begin(), bytes.end()}, width, height});
    return static_cast<int>(soup.images.size() - 1);
}

int add_image_file(const std::string& name, const SideFiles& side_files, const Limits& limits, Soup& soup) {
    const Result<std::vector<std::byte>> bytes = side_files(name);
    if (!bytes) {
        soup.warn("image dropped: " + bytes.error().message);
        return -1;
    }
    return add_image(*bytes, name, limits, soup);
}

Result<GreyImage> decode_grey16_png(std::span<const std::byte> bytes, const Limits& limits) {
    Header header;
    if (!is_png(bytes) || !read_header(bytes, header)) return invalid_input("is not a readable PNG");
    if (header.channels > 2 || !stbi_is_16_bit_from_memory(raw(bytes), static_cast<int>(bytes.size())))
        return fail(ErrorCode::unsupported, "is not a 16-bit grey PNG, so its levels are no heights");
    const auto width = static_cast<std::uint64_t>(header.width), height = static_cast<std::uint64_t>(header.height);
    if (width > limits.image_side || height > limits.image_side)
        return fail(ErrorCode::limit_exceeded, "is " + std::to_string(width) + " x " + std::to_string(height) +
                                                   ", sides longer than the limit of " +
                                                   std::to_string(limits.image_side));
    if (const Status fits = admit(width * height, 2 * width * height, limits); !fits) return fits.error();

    allowance_bytes = width * height * 16 + info_allowance_bytes;
    const std::unique_ptr<stbi_us, decltype(&std::free)> levels(
        stbi_load_16_from_memory(raw(bytes), static_cast<int>(bytes.size()), &header.width, &header.height,
                                 &header.channels, 1),
        &std::free);
    if (!levels) return invalid_input(std::string("has damaged PNG data: ") + stbi_failure_reason());
    GreyImage image{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
    image.levels.assign(levels.get(), levels.get() + width * height);
    return image;
}

}  // namespace lodestream::importer
