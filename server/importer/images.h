// Looks into PNG and JPEG files; stb_image stays behind this face.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "server/importer/importer.h"
#include "server/importer/soup.h"

namespace lodestream::importer {

// Adds a readable PNG or JPEG within the limits to soup.images, bytes as they are; else warns with `name` and gives -1.
int add_image(std::span<const std::byte> bytes, const std::string& name, const Limits& limits, Soup& soup);
// The same for an image in a file beside the model.
int add_image_file(const std::string& name, const SideFiles& side_files, const Limits& limits, Soup& soup);

struct GreyImage {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint16_t> levels;  // rows from the top
};
// Errors: invalid_input, limit_exceeded, unsupported (not 16-bit grey).
Result<GreyImage> decode_grey16_png(std::span<const std::byte> bytes, const Limits& limits);

}  // namespace lodestream::importer
