// Takes images along with a model.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "server/importer/importer.h"
#include "server/importer/soup.h"

namespace lodestream::importer {

// Adds a readable PNG or JPEG within the limits to soup.images, a PNG without what does not make its pixels;
// else warns with `name` and gives -1.
int add_image(std::span<const std::byte> bytes, const std::string& name, const Limits& limits, Soup& soup);
// The same for an image in a file beside the model.
int add_image_file(const std::string& name, const SideFiles& side_files, const Limits& limits, Soup& soup);

}  // namespace lodestream::importer
