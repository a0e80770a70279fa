// Small contents that tests of the renderer draw.
#pragma once

#include <utility>

#include "common/codec/level_codec.h"

namespace lodestream::testing {

// One primitive of one material.
inline codec::Decoded content_of(mesh::Mesh mesh, codec::Shading shading,
                                 const Vec4f& color = Vec4f{0.5f, 0.5f, 0.5f, 1.0f}) {
    codec::Decoded content;
    content.materials.emplace_back().base_color = color;
    if (shading == codec::Shading::flat) mesh.normals.clear();
    content.primitives.push_back({shading, 0, std::move(mesh)});
    return content;
}

// Two units wide, facing +z.
inline mesh::Mesh square(float z = 0.0f) {
    mesh::Mesh m;
    m.positions = {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}};
    m.normals.assign(4, Vec3f{0, 0, 1});
    m.texture_coordinates = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    m.triangles = {{0, 1, 2}, {0, 2, 3}};
    return m;
}

}  // namespace lodestream::testing
