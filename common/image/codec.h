// PNG and JPEG to pixels and back; stb stays behind this face. Bytes are hostile: any damage is an error, never a
// crash, and no decoder allocates more than the size in the file's own header deserves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"

namespace lodestream::image {

inline constexpr std::uint32_t max_side = 16'384;         // px
inline constexpr std::uint64_t max_pixels = 64ull << 20;  // 256 MiB of RGBA
inline constexpr std::uint64_t max_file_bytes = 256ull << 20;

enum class Format { png, jpeg };
const char* media_type(Format format);  // "image/png", "image/jpeg"

struct Header {
    Format format = Format::png;
    std::uint32_t width = 0;     // px, >= 1
    std::uint32_t height = 0;    // px, >= 1
    std::uint32_t channels = 0;  // 1 … 4
    bool is_16_bit = false;      // a channel
};

// Looks at the header alone; sizes beyond the limits are read too. Errors: invalid_input (neither PNG nor JPEG).
Result<Header> read_header(std::span<const std::byte> bytes);

// 8-bit sRGB and straight alpha, four bytes a pixel, top row first, no padding.
struct Pixels {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<std::uint8_t> rgba;  // 4 * width * height

    std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }
};
bool is_consistent(const Pixels& pixels);  // not empty, and as many bytes as its size says

// Errors: invalid_input (damaged or another format), limit_exceeded (larger than the limits above, or out of memory).
Result<Pixels> decode(std::span<const std::byte> bytes);

struct Grey {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<std::uint16_t> levels;  // rows from the top
};
// A PNG of 16-bit grey levels. Errors: invalid_input, unsupported (not 16-bit grey), limit_exceeded.
Result<Grey> decode_grey16_png(std::span<const std::byte> bytes);

// Errors: invalid_input (not consistent), limit_exceeded.
Result<std::vector<std::byte>> encode_png(const Pixels& pixels);  // RGBA
// The same picture in as few channels as hold it: grey where all pixels are, without alpha where all are opaque.
Result<std::vector<std::byte>> encode_small_png(const Pixels& pixels);
inline constexpr int min_jpeg_quality = 1;
inline constexpr int max_jpeg_quality = 100;
// Alpha is dropped. Up to quality 90 colour is halved on both axes. `quality` is clamped.
Result<std::vector<std::byte>> encode_jpeg(const Pixels& pixels, int quality);

}  // namespace lodestream::image
