#pragma once

#include <vector>

#include "common/base/result.h"
#include "server/importer/gltf_accessor.h"
#include "server/importer/gltf_material.h"

namespace lodestream::importer {

// A primitive of triangles or points in its mesh's own space. Attributes are empty or along positions.
struct GltfPrimitive {
    std::vector<Vec3f> positions;
    std::vector<Vec3f> normals;
    std::vector<Vec2f> texture_coordinates;
    std::vector<Rgba8> colors;
    std::vector<Vec4f> joints;  // of the skin, four a vertex
    std::vector<Vec4f> weights;
    std::vector<mesh::Triangle> triangles;  // empty: points
};

// Morph targets are applied at the weights given (the mesh's defaults). Draco, sparse and quantized data are expanded.
Result<GltfPrimitive> read_primitive(const tinygltf::Primitive& primitive, const std::vector<double>& morph_weights,
                                     const GltfTextureCoordinates& coordinates, GltfAccessors& accessors,
                                     const Limits& limits);

}  // namespace lodestream::importer
