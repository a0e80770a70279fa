// Pictures in files and beside each other, and how two renderings of one view differ.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/image/codec.h"

namespace lodestream::render {

using Image = image::Pixels;
using image::encode_png;

Image solid(std::uint32_t width, std::uint32_t height, std::uint8_t red, std::uint8_t green, std::uint8_t blue);

// Errors: those of image::encode_png, io (the path).
Status write_png(const std::filesystem::path& path, const Image& image);

// Errors: those of image::decode, io (the path).
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
