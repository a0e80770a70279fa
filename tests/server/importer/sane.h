#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/mesh/mesh.h"

namespace lodestream::testing {

// What every later stage takes for granted of a mesh of an imported model.
inline void expect_sane(const mesh::Mesh& m, const mesh::Model& model, const std::string& name) {
    const std::size_t n = m.positions.size();
    const bool is_cloud = model.kind == mesh::Kind::points;
    ASSERT_EQ(m.triangles.empty(), is_cloud) << name;
    ASSERT_GT(n, 0u) << name;
    ASSERT_TRUE(m.normals.size() == n || (is_cloud && m.normals.empty())) << name;
    ASSERT_TRUE(m.texture_coordinates.empty() || m.texture_coordinates.size() == n) << name;
    ASSERT_TRUE(m.colors.empty() || m.colors.size() == n) << name;
    ASSERT_TRUE(m.triangle_materials.empty() || m.triangle_materials.size() == m.triangles.size()) << name;
    for (const Vec3f& p : m.positions) ASSERT_TRUE(all_finite(p)) << name;
    for (const Vec3f& v : m.normals) ASSERT_NEAR(glm::length(v), 1.0f, 1e-3f) << name;
    for (const Vec2f& t : m.texture_coordinates) ASSERT_TRUE(std::isfinite(t.x) && std::isfinite(t.y)) << name;
    for (const mesh::Triangle& t : m.triangles) {
        for (const std::uint32_t v : t) ASSERT_LT(v, n) << name;
        const Vec3f &a = m.positions[t[0]], &b = m.positions[t[1]], &c = m.positions[t[2]];
        ASSERT_TRUE(a != b && b != c && c != a) << name;
    }
    for (const std::uint32_t material : m.triangle_materials) ASSERT_LT(material, model.materials.size()) << name;
    for (const std::uint32_t object : m.triangle_objects) ASSERT_LT(object, model.graph.object_nodes.size()) << name;
}

// And of the model; its mesh may be empty where all of it is instances.
inline void expect_sane(const mesh::Model& model, const std::string& name) {
    ASSERT_FALSE(model.materials.empty()) << name;
    ASSERT_TRUE(all_finite(model.origin)) << name;
    if (model.instances.empty() || !model.mesh.triangles.empty()) expect_sane(model.mesh, model, name);
    for (const mesh::Mesh& shape : model.shapes) {
        expect_sane(shape, model, name + ", a shape");
        ASSERT_TRUE(shape.triangle_objects.empty()) << name;
    }
    for (const mesh::Instance& instance : model.instances) {
        ASSERT_LT(instance.object, model.graph.object_nodes.size()) << name;
        ASSERT_LT(instance.shape, model.shapes.size()) << name;
        ASSERT_GT(glm::determinant(instance.matrix), 0.0) << name;
    }
    for (const mesh::Material& material : model.materials)
        for (const mesh::TextureReference* t : {&material.base_color_texture, &material.metallic_roughness_texture,
                                                &material.occlusion_texture, &material.emissive_texture})
            ASSERT_LT(t->image, static_cast<int>(model.images.size())) << name;
}

}  // namespace lodestream::testing
