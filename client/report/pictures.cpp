#include "client/report/pictures.h"

#include <algorithm>
#include <array>

namespace lodestream::report {
namespace {

using Pixel = std::array<std::uint8_t, 4>;

Pixel mean_of(const render::Image& image, std::uint64_t x0, std::uint64_t x1, std::uint64_t y0, std::uint64_t y1) {
    std::array<std::uint64_t, 4> sum{};
    for (std::uint64_t y = y0; y < y1; ++y)
        for (std::uint64_t x = x0; x < x1; ++x)
            for (std::size_t k = 0; k < 4; ++k) sum[k] += image.rgba[4 * (y * image.width + x) + k];
    const std::uint64_t count = (x1 - x0) * (y1 - y0);
    Pixel out{};
    for (std::size_t k = 0; k < 4; ++k) out[k] = static_cast<std::uint8_t>((sum[k] + count / 2) / count);
    return out;
}

bool same_pixel(const render::Image& image, std::size_t a, std::size_t b) {
    return std::equal(image.rgba.begin() + static_cast<std::ptrdiff_t>(4 * a),
                      image.rgba.begin() + static_cast<std::ptrdiff_t>(4 * a + 4),
                      image.rgba.begin() + static_cast<std::ptrdiff_t>(4 * b));
}

}  // namespace

Rectangle shown_part(std::span<const render::Image> images, std::uint32_t margin_px) {
    if (images.empty()) return {};
    const std::uint32_t width = images.front().width, height = images.front().height;
    Rectangle part{width, height, 0, 0};
    for (const render::Image& image : images)
        for (std::uint32_t y = 0; y < height; ++y)
            for (std::uint32_t x = 0; x < width; ++x)
                if (!same_pixel(image, std::size_t{y} * width + x, 0))
                    part = {std::min(part.left, x), std::min(part.top, y), std::max(part.right, x + 1),
                            std::max(part.bottom, y + 1)};
    if (part.right == 0) return {0, 0, width, height};
    return {part.left - std::min(part.left, margin_px), part.top - std::min(part.top, margin_px),
            part.right + std::min(width - part.right, margin_px),
            part.bottom + std::min(height - part.bottom, margin_px)};
}

render::Image cropped(const render::Image& image, const Rectangle& part) {
    render::Image out{part.right - part.left, part.bottom - part.top, {}};
    out.rgba.reserve(4 * out.pixels());
    for (std::uint32_t y = part.top; y < part.bottom; ++y) {
        const auto row = image.rgba.begin() + std::ptrdiff_t{4} * y * image.width;
        out.rgba.insert(out.rgba.end(), row + std::ptrdiff_t{4} * part.left, row + std::ptrdiff_t{4} * part.right);
    }
    return out;
}

render::Image scaled_down(const render::Image& image, std::uint32_t width) {
    if (image.width <= width || width == 0 || image.height == 0) return image;
    const auto scaled = static_cast<std::uint64_t>(image.height) * width / image.width;
    const auto height = static_cast<std::uint32_t>(std::max<std::uint64_t>(scaled, 1));
    render::Image out{width, height, {}};
    out.rgba.reserve(4 * out.pixels());
    for (std::uint64_t y = 0; y < height; ++y)
        for (std::uint64_t x = 0; x < width; ++x) {
            const Pixel pixel = mean_of(image, x * image.width / width, (x + 1) * image.width / width,
                                        y * image.height / height, (y + 1) * image.height / height);
            out.rgba.insert(out.rgba.end(), pixel.begin(), pixel.end());
        }
    return out;
}

render::Image stacked(std::span<const render::Image> images, std::uint32_t gap_px) {
    std::uint32_t width = 0, height = 0;
    for (const render::Image& image : images) {
        width = std::max(width, image.width);
        height += image.height + (height > 0 ? gap_px : 0);
    }
    render::Image out = render::solid(width, height, 255, 255, 255);
    std::size_t row = 0;
    for (const render::Image& image : images) {
        for (std::uint32_t y = 0; y < image.height; ++y)
            std::copy_n(image.rgba.begin() + std::ptrdiff_t{4} * y * image.width, std::size_t{4} * image.width,
                        out.rgba.begin() + static_cast<std::ptrdiff_t>(4 * (row + y) * width));
        row += image.height + gap_px;
    }
    return out;
}

}  // namespace lodestream::report
