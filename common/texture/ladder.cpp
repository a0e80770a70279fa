#include "common/texture/ladder.h"

#include <algorithm>

#include "common/image/codec.h"
#include "common/image/resample.h"

namespace lodestream::texture {
namespace {

using image::Format;

struct Encoded {
    Format format = Format::png;
    std::vector<std::byte> bytes;
};

std::uint32_t halved(std::uint32_t side, int halvings) {
    const std::uint32_t rounded_up = ((side - 1) >> halvings) + 1;
    return std::max(rounded_up, std::min(side, min_side));
}

Result<Encoded> encode(const image::Pixels& pixels, Format source, const ImageUse& use) {
    const bool is_data = use.content == image::Content::data;
    if (source == Format::jpeg) {
        auto jpeg = image::encode_jpeg(pixels, is_data ? data_jpeg_quality : jpeg_quality);
        return jpeg ? Result<Encoded>(Encoded{Format::jpeg, *std::move(jpeg)}) : jpeg.error();
    }
    auto png = image::encode_small_png(pixels);
    if (!png) return png.error();
    if (!use.reads_alpha && !is_data) {
        auto jpeg = image::encode_jpeg(pixels, jpeg_quality);
        if (jpeg && static_cast<double>(jpeg->size()) < jpeg_over_png * static_cast<double>(png->size()))
            return Encoded{Format::jpeg, *std::move(jpeg)};
    }
    return Encoded{Format::png, *std::move(png)};
}

Result<Sizes> sizes_within(const mesh::Image& source, const ImageUse& use, std::uint64_t& texels_allowed) {
    const Result<image::Header> header = image::read_header(source.bytes);
    if (!header) return header.error();
    const std::uint64_t texels = std::uint64_t{header->width} * header->height;
    if (texels > texels_allowed)
        return fail(ErrorCode::limit_exceeded, "the model's images together have more texels than the limit");
    texels_allowed -= texels;
    return smaller_sizes(source, use);
}

image::Pixels pixels_of(const image::LinearPixels& linear, const ImageUse& use) {
    image::Pixels pixels = image::to_pixels(linear, use.content);
    if (!use.reads_alpha)
        for (std::size_t i = 3; i < pixels.rgba.size(); i += 4) pixels.rgba[i] = 255;
    return pixels;
}

}  // namespace

Result<Sizes> smaller_sizes(const mesh::Image& source, const ImageUse& use) {
    const Result<image::Header> header = image::read_header(source.bytes);
    if (!header) return header.error();
    const Result<image::Pixels> full = image::decode(source.bytes);
    if (!full) return full.error();

    Sizes sizes;
    std::size_t fewest_bytes = source.bytes.size();
    image::LinearPixels linear{full->width, full->height, {}};
    for (int halvings = 1;; ++halvings) {
        const std::uint32_t width = halved(full->width, halvings), height = halved(full->height, halvings);
        if (width == linear.width && height == linear.height) return sizes;
        linear =
            halvings == 1 ? image::shrink(*full, use.content, width, height) : image::shrink(linear, width, height);
        Result<Encoded> encoded = encode(pixels_of(linear, use), header->format, use);
        if (!encoded) return encoded.error();
        if (encoded->bytes.size() >= fewest_bytes) continue;
        fewest_bytes = encoded->bytes.size();
        sizes.push_back({halvings, {image::media_type(encoded->format), std::move(encoded->bytes), width, height}});
    }
}

Result<Ladder> make_ladder(const mesh::Model& model, const std::vector<ImageUse>& uses, std::uint64_t texels_allowed) {
    Result<Ladder> ladder(Ladder(model.images.size()));
    for (std::size_t i = 0; i < uses.size(); ++i) {
        if (!uses[i].is_used) continue;
        Result<Sizes> sizes = sizes_within(model.images[i], uses[i], texels_allowed);
        if (sizes)
            (*ladder)[i] = *std::move(sizes);
        else
            ladder.warnings.push_back("image " + std::to_string(i) + " is sent as it is: " + sizes.error().message);
    }
    return ladder;
}

}  // namespace lodestream::texture
