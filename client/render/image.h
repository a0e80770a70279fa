// Pictures in memory: PNG in and out, and how two renderings of one view differ.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "common/base/result.h"

namespace lodestream::render {

inline constexpr std::uint32_t max_image_side = 16'384;         // px
inline constexpr std::uint64_t max_image_pixels = 64ull << 20;  // 256 MiB of RGBA
inline constexpr std::uint64_t max_image_file_bytes = 256ull << 20;

// 8-bit sRGB and alpha, four bytes a pixel, top row first, no padding.
struct Image {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<std::uint8_t> rgba;  // 4 * width * height

    std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }
};

Image solid(std::uint32_t width, std::uint32_t height, std::uint8_t red, std::uint8_t green, std::uint8_t blue);

// Errors: invalid_input (empty or inconsistent image), limit_exceeded, io (the path).
Result<std::vector<std::byte>> encode_png(const Image& image);
Status write_png(const std::filesystem::path& path, const Image& image);

// PNG or JPEG of at most max_image_side × max_image_side and max_image_pixels; the bytes are hostile.
// Errors: invalid_input (damaged or another format), limit_exceeded.
Result<Image> decode_image(std::span<const std::byte> bytes);
Result<Image> read_image(const std::filesystem::path& path);

// Beside each other, tops aligned, on white, `gap_px` apart.
Image side_by_side(std::span<const Image> images, std::uint32_t gap_px = 8);

struct Difference {
    double rms = 0.0;                     // 8-bit steps, over R, G and B of the compared pixels
    double max = 0.0;                     // 8-bit steps, of one channel
    double psnr_db = 0.0;                 // of rms against 255; max_psnr_db where the images agree
    std::uint64_t compared_pixels = 0;    // where either image differs from the background
    std::uint64_t silhouette_pixels = 0;  // covered in one image and background in the other
    double silhouette_percent = 0.0;      // of compared_pixels
};

inline constexpr double max_psnr_db = 100.0;

// The background is the colour of the first image's upper left pixel: frame the object so that a corner is free.
// Errors: invalid_input (sizes differ, or empty).
Result<Difference> compare(const Image& a, const Image& b);

// |a - b| * amplification on white: equal pixels are white, different ones dark. Errors as compare().
Result<Image> difference_image(const Image& a, const Image& b, double amplification = 8.0);

}  // namespace lodestream::render
