// A glTF file taken apart: tinygltf's model of its JSON, and its buffers and images as bytes.
#pragma once

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_INCLUDE_STB_IMAGE
#define TINYGLTF_NO_INCLUDE_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <fstream>  // tiny_gltf.h needs it in spite of NO_FS

#include <tiny_gltf.h>

#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/importer/formats.h"

namespace lodestream::importer {

struct GltfBuffer {
    std::vector<std::byte> storage;    // where it is not part of the file itself
    std::span<const std::byte> bytes;  // exactly as many as stated
    bool is_placeholder = false;       // stands for data that an extension holds compressed
};

struct GltfImage {
    std::string label;  // for messages
    std::string uri;    // decoded, of a side file; else empty
    int buffer_view = -1;
    std::vector<std::byte> bytes;  // of a data URI
};

struct GltfDocument {
    tinygltf::Model json;  // without buffers, images, animations and cameras
    std::vector<GltfBuffer> buffers;
    std::vector<GltfImage> images;
    bool has_animations = false;
};

bool is_handled_gltf_extension(const std::string& extension);

// Errors: invalid_input, unsupported (version, required extension), limit_exceeded, not_found (buffers).
Result<GltfDocument> open_gltf(std::span<const std::byte> json, std::span<const std::byte> binary_chunk,
                               const Source& source);

}  // namespace lodestream::importer
