#include "common/image/resample.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "common/base/srgb.h"

namespace lodestream::image {
namespace {

constexpr std::size_t light_steps = 1 << 16;  // fine enough to tell all 8-bit sRGB steps apart

std::uint8_t to_byte(double value) {
    return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
}

std::array<float, 256> to_light_table(Content content) {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double value = static_cast<double>(i) / 255.0;
        table[i] = static_cast<float>(content == Content::data ? value : light_of_srgb(value));
    }
    return table;
}

std::vector<std::uint8_t> from_light_table(Content content) {
    std::vector<std::uint8_t> table(light_steps);
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double value = static_cast<double>(i) / static_cast<double>(light_steps - 1);
        table[i] = to_byte(content == Content::data ? value : srgb_of_light(value));
    }
    return table;
}

std::uint8_t byte_of_light(const std::vector<std::uint8_t>& table, float light) {
    const float place = std::clamp(light, 0.0f, 1.0f) * static_cast<float>(light_steps - 1);
    return table[static_cast<std::size_t>(place + 0.5f)];
}

// The part of the source line under one target pixel: whole pixels, the first and the last of which may count in part.
struct Span {
    std::uint32_t first = 0;
    std::vector<float> weights;  // sum 1
};

std::vector<Span> spans_of(std::uint32_t from, std::uint32_t to) {
    std::vector<Span> spans(to);
    const double ratio = static_cast<double>(from) / to;
    for (std::uint32_t i = 0; i < to; ++i) {
        const double begin = i * ratio, end = std::min<double>(from, (i + 1) * ratio);
        Span& span = spans[i];
        span.first = static_cast<std::uint32_t>(begin);
        for (std::uint32_t x = span.first; x < from && x < end; ++x)
            span.weights.push_back(
                static_cast<float>((std::min<double>(end, x + 1) - std::max<double>(begin, x)) / ratio));
    }
    return spans;
}

void average_row(const std::vector<float>& row, const std::vector<Span>& spans, std::vector<float>& result) {
    for (std::size_t i = 0; i < spans.size(); ++i) {
        std::array<float, 4> sum{};
        std::size_t at = std::size_t{spans[i].first} * 4;
        for (const float weight : spans[i].weights)
            for (float& channel : sum) channel += weight * row[at++];
        std::copy(sum.begin(), sum.end(), result.begin() + static_cast<std::ptrdiff_t>(i * 4));
    }
}

// `read_row(y, row)` fills one line of 4 * from_width floats.
template <class ReadRow>
LinearPixels shrink_rows(std::uint32_t from_width, std::uint32_t from_height, std::uint32_t width, std::uint32_t height,
                         ReadRow read_row) {
    assert(width >= 1 && height >= 1 && width <= from_width && height <= from_height);
    LinearPixels result{width, height, std::vector<float>(std::size_t{width} * height * 4, 0.0f)};
    const std::vector<Span> columns = spans_of(from_width, width), rows = spans_of(from_height, height);
    std::vector<float> row(std::size_t{from_width} * 4), averaged(std::size_t{width} * 4);
    std::uint32_t averaged_row = from_height;  // which line `averaged` holds: two target lines may share one
    for (std::uint32_t y = 0; y < height; ++y) {
        float* target = result.rgba.data() + std::size_t{y} * width * 4;
        for (std::size_t i = 0; i < rows[y].weights.size(); ++i) {
            const auto source_row = static_cast<std::uint32_t>(rows[y].first + i);
            if (source_row != averaged_row) {
                read_row(source_row, row);
                average_row(row, columns, averaged);
                averaged_row = source_row;
            }
            for (std::size_t x = 0; x < averaged.size(); ++x) target[x] += rows[y].weights[i] * averaged[x];
        }
    }
    return result;
}

}  // namespace

LinearPixels shrink(const Pixels& source, Content content, std::uint32_t width, std::uint32_t height) {
    assert(is_consistent(source));
    const std::array<float, 256> light = to_light_table(content);
    return shrink_rows(source.width, source.height, width, height, [&](std::uint32_t y, std::vector<float>& row) {
        const std::uint8_t* bytes = source.rgba.data() + std::size_t{y} * source.width * 4;
        for (std::size_t x = 0; x < row.size(); x += 4) {
            const float alpha = static_cast<float>(bytes[x + 3]) / 255.0f;
            const float weight = content == Content::color_under_alpha ? alpha : 1.0f;
            for (std::size_t c = 0; c < 3; ++c) row[x + c] = light[bytes[x + c]] * weight;
            row[x + 3] = alpha;
        }
    });
}

LinearPixels shrink(const LinearPixels& source, std::uint32_t width, std::uint32_t height) {
    return shrink_rows(source.width, source.height, width, height, [&](std::uint32_t y, std::vector<float>& row) {
        std::copy_n(source.rgba.begin() + static_cast<std::ptrdiff_t>(std::size_t{y} * source.width * 4), row.size(),
                    row.begin());
    });
}

Pixels to_pixels(const LinearPixels& source, Content content) {
    const std::vector<std::uint8_t> bytes = from_light_table(content);
    Pixels pixels{source.width, source.height, std::vector<std::uint8_t>(source.rgba.size())};
    for (std::size_t i = 0; i < source.rgba.size(); i += 4) {
        const float alpha = source.rgba[i + 3];
        const float weight = content == Content::color_under_alpha ? alpha : 1.0f;
        for (std::size_t c = 0; c < 3; ++c)
            pixels.rgba[i + c] = weight > 0.0f ? byte_of_light(bytes, source.rgba[i + c] / weight) : std::uint8_t{0};
        pixels.rgba[i + 3] = to_byte(alpha);
    }
    return pixels;
}

}  // namespace lodestream::image
