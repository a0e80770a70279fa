// Where the attributes of an interleaved point lie, and so what a point costs.
#pragma once

#include <cstddef>

namespace lodestream::codec {

inline constexpr const char* quantization_extension = "KHR_mesh_quantization";
inline constexpr int gltf_byte = 5120;
inline constexpr int gltf_points = 0;

struct PointLayout {
    bool has_normals = false;
    bool has_colors = false;

    static constexpr std::size_t normal_offset = 8;  // behind the position and its padding
    constexpr std::size_t color_offset() const { return has_normals ? 12 : 8; }
    constexpr std::size_t stride() const { return color_offset() + (has_colors ? 4 : 0); }
};

}  // namespace lodestream::codec
