// Private to the codec: the GLB container and the glTF numbers that writer and reader share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::codec {

inline constexpr int gltf_unsigned_byte = 5121;
inline constexpr int gltf_unsigned_short = 5123;
inline constexpr int gltf_unsigned_int = 5125;
inline constexpr int gltf_float = 5126;
inline constexpr int gltf_array_buffer = 34962;
inline constexpr int gltf_element_array_buffer = 34963;
inline constexpr int gltf_triangles = 4;
inline constexpr const char* draco_extension = "KHR_draco_mesh_compression";
// A primitive whose geometry is a lean stream (lean_mesh.h) in a buffer view.
inline constexpr const char* lean_extension = "LODESTREAM_lean_mesh";

inline constexpr std::size_t max_json_bytes = std::size_t{8} << 20;
inline constexpr std::size_t max_json_depth = 64;
inline constexpr std::size_t max_gltf_elements = 1u << 16;  // materials, primitives, images, … each

// Indices below which glTF's unsigned short may number vertices (65535 is the primitive restart value).
inline constexpr std::uint32_t max_short_vertices = 65535;

int wrap_code(mesh::Wrap wrap);

// "image/png" or "image/jpeg" by the first bytes, "" for anything else.
std::string_view image_media_type(std::span<const std::byte> bytes);

// Parses within max_json_bytes and max_json_depth.
Result<nlohmann::json> parse_json(std::string_view text);

struct Glb {
    nlohmann::json json;
    std::span<const std::byte> binary;  // of the bytes given; empty where there is no binary chunk
};

Result<Glb> split_glb(std::span<const std::byte> bytes);
// The same of a file that may end early, but not before the end of its JSON.
Result<Glb> split_glb_start(std::span<const std::byte> bytes);
Result<std::vector<std::byte>> join_glb(const nlohmann::json& json, std::vector<std::byte> binary);

}  // namespace lodestream::codec
