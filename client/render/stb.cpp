// stb_image and stb_image_write, compiled once and with the limits that hostile files need.
#include "client/render/stb.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "client/render/image.h"

namespace {

// An inflated PNG may claim any size: no single allocation of a decoder passes twice the largest 16-bit RGBA picture.
constexpr std::size_t max_allocation_bytes = 2 * 8 * lodestream::render::max_image_pixels;

void* limited_malloc(std::size_t bytes) {
    return bytes > max_allocation_bytes ? nullptr : std::malloc(bytes);
}
void* limited_realloc(void* block, std::size_t bytes) {
    return bytes > max_allocation_bytes ? nullptr : std::realloc(block, bytes);
}

}  // namespace

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_FAILURE_USERMSG
#define STBI_MAX_DIMENSIONS 16384
#define STBI_MALLOC(bytes) limited_malloc(bytes)
#define STBI_REALLOC(block, bytes) limited_realloc(block, bytes)
#define STBI_FREE(block) std::free(block)
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace lodestream::render {

static_assert(STBI_MAX_DIMENSIONS == max_image_side);

ImageSize stb_size(const std::uint8_t* data, std::size_t size) {
    ImageSize out;
    if (size > static_cast<std::size_t>(std::numeric_limits<int>::max())) return out;
    int components = 0;
    if (!stbi_info_from_memory(data, static_cast<int>(size), &out.width, &out.height, &components)) return {};
    return out;
}

bool stb_decode(const std::uint8_t* data, std::size_t size, std::vector<std::uint8_t>& rgba, std::string& reason) {
    int width = 0, height = 0, components = 0;
    stbi_uc* pixels = stbi_load_from_memory(data, static_cast<int>(size), &width, &height, &components, 4);
    if (!pixels) {
        reason = stbi_failure_reason();
        return false;
    }
    rgba.assign(pixels, pixels + static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
    std::free(pixels);
    return true;
}

bool stb_encode_png(int width, int height, const std::uint8_t* rgba, std::vector<std::byte>& png) {
    const auto append = [](void* context, void* data, int size) {
        const auto* bytes = static_cast<const std::byte*>(data);
        static_cast<std::vector<std::byte>*>(context)->assign(bytes, bytes + size);
    };
    return stbi_write_png_to_func(append, &png, width, height, 4, rgba, 4 * width) != 0;
}

}  // namespace lodestream::render
