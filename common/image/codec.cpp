#include "common/image/codec.h"

#include <algorithm>
#include <climits>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>

#include "common/image/jpeg_tables.h"

namespace {

// A PNG's compressed data can swell a thousandfold whatever size its header states, so stb allocates from an allowance
// set by that size. stb's allocator takes no context, hence the only variable of its kind in common: a call sets it
// before it uses it, and no call sees another's.
thread_local std::size_t allowance_bytes = 0;

void* take_memory(std::size_t bytes) {
    return bytes > allowance_bytes ? nullptr : std::malloc(bytes);
}
void* retake_memory(void* old, std::size_t bytes) {
    return bytes > allowance_bytes ? nullptr : std::realloc(old, bytes);
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
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace lodestream::image {
namespace {

constexpr std::size_t header_allowance_bytes = 1 << 20;
constexpr std::size_t decoding_bytes_per_pixel = 16;  // the largest single block: 16-bit RGBA, twice for doubling

const stbi_uc* raw(std::span<const std::byte> bytes) {
    return reinterpret_cast<const stbi_uc*>(bytes.data());
}

int size_of(std::span<const std::byte> bytes) {
    return static_cast<int>(bytes.size());
}

Status check_size(std::uint64_t width, std::uint64_t height) {
    if (width <= max_side && height <= max_side && width * height <= max_pixels) return Nothing{};
    return fail(ErrorCode::limit_exceeded,
                "image of " + std::to_string(width) + "x" + std::to_string(height) + " px is larger than the limit");
}

Error damaged() {
    const char* reason = stbi_failure_reason();
    return invalid_input(std::string("damaged image: ") + (reason ? reason : "unknown reason"));
}

void set_allowance(std::uint64_t pixels) {
    allowance_bytes = pixels * decoding_bytes_per_pixel + header_allowance_bytes;
}

void append(void* context, void* data, int size) {
    const auto* first = static_cast<const std::byte*>(data);
    auto& bytes = *static_cast<std::vector<std::byte>*>(context);
    bytes.insert(bytes.end(), first, first + size);
}

Status check_encodable(const Pixels& pixels) {
    if (!is_consistent(pixels))
        return invalid_input("cannot encode an empty image or one whose size does not fit its pixels");
    return check_size(pixels.width, pixels.height);
}

Result<std::vector<std::byte>> encode_png_channels(const Pixels& pixels, int channels, const std::uint8_t* data) {
    std::vector<std::byte> png;
    const auto width = static_cast<int>(pixels.width), height = static_cast<int>(pixels.height);
    if (stbi_write_png_to_func(append, &png, width, height, channels, data, channels * width) == 0)
        return fail(ErrorCode::limit_exceeded, "not enough memory to encode a PNG");
    return png;
}

}  // namespace

const char* media_type(Format format) {
    return format == Format::png ? "image/png" : "image/jpeg";
}

bool is_consistent(const Pixels& pixels) {
    return pixels.width > 0 && pixels.height > 0 && pixels.rgba.size() == pixels.pixels() * 4;
}

Result<Header> read_header(std::span<const std::byte> bytes) {
    const Error unreadable = invalid_input("neither a readable PNG nor JPEG");
    if (bytes.size() > INT_MAX || !has_sound_huffman_tables(bytes)) return unreadable;
    allowance_bytes = header_allowance_bytes;
    int width = 0, height = 0, channels = 0;
    if (stbi_info_from_memory(raw(bytes), size_of(bytes), &width, &height, &channels) == 0 || width <= 0 || height <= 0)
        return unreadable;
    Header header;
    header.format = bytes[0] == std::byte{0x89} ? Format::png : Format::jpeg;
    header.width = static_cast<std::uint32_t>(width);
    header.height = static_cast<std::uint32_t>(height);
    header.channels = static_cast<std::uint32_t>(channels);
    header.is_16_bit = stbi_is_16_bit_from_memory(raw(bytes), size_of(bytes)) != 0;
    return header;
}

Result<Pixels> decode(std::span<const std::byte> bytes) {
    if (bytes.size() > max_file_bytes) return fail(ErrorCode::limit_exceeded, "image file is larger than the limit");
    const Result<Header> header = read_header(bytes);
    if (!header) return header.error();
    if (Status fits = check_size(header->width, header->height); !fits) return fits.error();

    Pixels pixels{header->width, header->height, {}};
    set_allowance(pixels.pixels());
    int width = 0, height = 0, channels = 0;
    const std::unique_ptr<stbi_uc, decltype(&std::free)> decoded(
        stbi_load_from_memory(raw(bytes), size_of(bytes), &width, &height, &channels, 4), &std::free);
    if (!decoded) return damaged();
    try {
        pixels.rgba.assign(decoded.get(), decoded.get() + pixels.pixels() * 4);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "not enough memory to decode an image");
    }
    return pixels;
}

Result<Grey> decode_grey16_png(std::span<const std::byte> bytes) {
    const Result<Header> header = read_header(bytes);
    if (!header || header->format != Format::png) return invalid_input("is not a readable PNG");
    if (header->channels > 2 || !header->is_16_bit)
        return fail(ErrorCode::unsupported, "is not a 16-bit grey PNG, so its levels are no heights");
    if (Status fits = check_size(header->width, header->height); !fits) return fits.error();

    Grey grey{header->width, header->height, {}};
    const std::uint64_t count = std::uint64_t{grey.width} * grey.height;
    set_allowance(count);
    int width = 0, height = 0, channels = 0;
    const std::unique_ptr<stbi_us, decltype(&std::free)> levels(
        stbi_load_16_from_memory(raw(bytes), size_of(bytes), &width, &height, &channels, 1), &std::free);
    if (!levels) return damaged();
    grey.levels.assign(levels.get(), levels.get() + count);
    return grey;
}

Result<std::vector<std::byte>> encode_png(const Pixels& pixels) {
    if (Status valid = check_encodable(pixels); !valid) return valid.error();
    return encode_png_channels(pixels, 4, pixels.rgba.data());
}

Result<std::vector<std::byte>> encode_small_png(const Pixels& pixels) {
    if (Status valid = check_encodable(pixels); !valid) return valid.error();
    bool is_grey = true, is_opaque = true;
    for (std::size_t i = 0; i < pixels.rgba.size(); i += 4) {
        const std::uint8_t* p = &pixels.rgba[i];
        is_grey = is_grey && p[0] == p[1] && p[1] == p[2];
        is_opaque = is_opaque && p[3] == 255;
    }
    std::vector<std::uint8_t> packed;
    const std::size_t colors = is_grey ? 1 : 3;
    packed.reserve(pixels.pixels() * (colors + 1));
    for (std::size_t i = 0; i < pixels.rgba.size(); i += 4) {
        const auto pixel = pixels.rgba.begin() + static_cast<std::ptrdiff_t>(i);
        packed.insert(packed.end(), pixel, pixel + static_cast<std::ptrdiff_t>(colors));
        if (!is_opaque) packed.push_back(pixels.rgba[i + 3]);
    }
    return encode_png_channels(pixels, static_cast<int>(colors) + (is_opaque ? 0 : 1), packed.data());
}

Result<std::vector<std::byte>> encode_jpeg(const Pixels& pixels, int quality) {
    if (Status valid = check_encodable(pixels); !valid) return valid.error();
    std::vector<std::byte> jpeg;
    if (stbi_write_jpg_to_func(append, &jpeg, static_cast<int>(pixels.width), static_cast<int>(pixels.height), 4,
                               pixels.rgba.data(), std::clamp(quality, min_jpeg_quality, max_jpeg_quality)) == 0)
        return fail(ErrorCode::limit_exceeded, "not enough memory to encode a JPEG");
    return jpeg;
}

}  // namespace lodestream::image
