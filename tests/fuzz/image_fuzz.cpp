// libFuzzer over PNG and JPEG: what decodes is shrunk and encoded again. See run.sh.
#include <cstdlib>

#include "common/image/codec.h"
#include "common/texture/ladder.h"

namespace {

using namespace lodestream;

constexpr std::uint64_t max_texels = 1 << 20;  // keeps a run short

void expect(bool holds) {
    if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(data + 1), size - 1);
    const auto header = image::read_header(bytes);
    if (!header || std::uint64_t{header->width} * header->height > max_texels) return 0;
    const mesh::Image source{
        image::media_type(header->format), {bytes.begin(), bytes.end()}, header->width, header->height};
    const texture::ImageUse use{true, static_cast<image::Content>(data[0] % 3), data[0] % 2 == 1};
    const auto sizes = texture::smaller_sizes(source, use);
    if (!sizes) return 0;
    for (const texture::SmallerImage& smaller : *sizes) {
        const auto pixels = image::decode(smaller.image.bytes);
        expect(pixels.ok() && pixels->width == smaller.image.width && pixels->height == smaller.image.height);
        expect(smaller.image.bytes.size() < source.bytes.size());
    }
    return 0;
}
