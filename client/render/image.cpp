#include "client/render/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <string>

namespace lodestream::render {
namespace {

Status check_pair(const Image& a, const Image& b) {
    if (!is_consistent(a) || !is_consistent(b))
        return invalid_input("image is empty or its size does not fit its pixels");
    if (a.width != b.width || a.height != b.height) return invalid_input("images differ in size");
    return Nothing{};
}

bool is_color(const std::uint8_t* pixel, const std::array<std::uint8_t, 3>& color) {
    return std::equal(color.begin(), color.end(), pixel);
}

}  // namespace

Image solid(std::uint32_t width, std::uint32_t height, std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
    Image image{width, height, {}};
    image.rgba.resize(image.pixels() * 4, 255);
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        image.rgba[i] = red;
        image.rgba[i + 1] = green;
        image.rgba[i + 2] = blue;
    }
    return image;
}

Status write_png(const std::filesystem::path& path, const Image& image) {
    const auto png = encode_png(image);
    if (!png) return png.error();
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(png->data()), static_cast<std::streamsize>(png->size()));
    file.close();
    if (!file) return fail(ErrorCode::io, path.string() + ": cannot be written");
    return Nothing{};
}

Result<Image> read_image(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    const std::streamoff size = file.tellg();
    if (!file || size < 0) return fail(ErrorCode::io, path.string() + ": cannot be read");
    if (static_cast<std::uint64_t>(size) > image::max_file_bytes)
        return fail(ErrorCode::limit_exceeded, path.string() + ": larger than the limit");
    std::vector<std::byte> bytes(static_cast<std::size_t>(size));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(bytes.data()), size);
    if (!file) return fail(ErrorCode::io, path.string() + ": cannot be read");
    auto image = image::decode(bytes);
    if (!image) return fail(image.error().code, path.string() + ": " + image.error().message);
    return image;
}

Image side_by_side(std::span<const Image> images, std::uint32_t gap_px) {
    Image all;
    for (const Image& image : images) {
        all.width += image.width + (all.width > 0 ? gap_px : 0);
        all.height = std::max(all.height, image.height);
    }
    all = solid(all.width, all.height, 255, 255, 255);
    std::size_t left = 0;
    for (const Image& image : images) {
        for (std::size_t y = 0; y < image.height; ++y)
            std::copy_n(image.rgba.begin() + static_cast<std::ptrdiff_t>(y * image.width * 4), image.width * 4,
                        all.rgba.begin() + static_cast<std::ptrdiff_t>((y * all.width + left) * 4));
        left += image.width + gap_px;
    }
    return all;
}

Result<Difference> compare(const Image& a, const Image& b) {
    if (auto pair = check_pair(a, b); !pair) return pair.error();
    const std::array<std::uint8_t, 3> background{a.rgba[0], a.rgba[1], a.rgba[2]};
    Difference out;
    double squares = 0.0;
    for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
        const bool empty_a = is_color(&a.rgba[i], background), empty_b = is_color(&b.rgba[i], background);
        if (empty_a && empty_b) continue;
        ++out.compared_pixels;
        if (empty_a != empty_b) ++out.silhouette_pixels;
        for (std::size_t c = 0; c < 3; ++c) {
            const double step = std::abs(double{0} + a.rgba[i + c] - b.rgba[i + c]);
            squares += step * step;
            out.max = std::max(out.max, step);
        }
    }
    if (out.compared_pixels > 0) {
        const auto compared = static_cast<double>(out.compared_pixels);
        out.rms = std::sqrt(squares / (3.0 * compared));
        out.silhouette_percent = 100.0 * static_cast<double>(out.silhouette_pixels) / compared;
    }
    out.psnr_db = out.rms > 0.0 ? std::min(max_psnr_db, 20.0 * std::log10(255.0 / out.rms)) : max_psnr_db;
    return out;
}

Result<Image> difference_image(const Image& a, const Image& b, double amplification) {
    if (auto pair = check_pair(a, b); !pair) return pair.error();
    Image out = solid(a.width, a.height, 255, 255, 255);
    for (std::size_t i = 0; i < a.rgba.size(); i += 4)
        for (std::size_t c = 0; c < 3; ++c) {
            const double step = amplification * std::abs(double{0} + a.rgba[i + c] - b.rgba[i + c]);
            out.rgba[i + c] = static_cast<std::uint8_t>(255.0 - std::clamp(step, 0.0, 255.0));
        }
    return out;
}

}  // namespace lodestream::render
