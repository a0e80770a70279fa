#include "server/importer/images.h"

#include "common/image/codec.h"
#include "common/image/png_chunks.h"

namespace lodestream::importer {

int add_image(std::span<const std::byte> bytes, const std::string& name, const Limits& limits, Soup& soup) {
    const auto drop = [&](const std::string& why) {
        soup.warn("image " + name + " dropped: " + why);
        return -1;
    };
    if (soup.image_bytes + bytes.size() > limits.image_bytes) return drop("more image bytes than the limit");
    const Result<image::Header> header = image::read_header(bytes);
    if (!header) return drop(header.error().message);
    if (header->width > limits.image_side || header->height > limits.image_side)
        return drop("sides longer than the limit");
    soup.image_bytes += bytes.size();
    soup.images.push_back(
        {image::media_type(header->format), image::pixels_only(bytes), header->width, header->height});
    return static_cast<int>(soup.images.size() - 1);
}

int add_image_file(const std::string& name, const SideFiles& side_files, const Limits& limits, Soup& soup) {
    const Result<std::vector<std::byte>> bytes = side_files(name);
    if (!bytes) {
        soup.warn("image dropped: " + bytes.error().message);
        return -1;
    }
    return add_image(*bytes, name, limits, soup);
}

}  // namespace lodestream::importer
