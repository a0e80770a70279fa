// Small constructed scenes of several objects.
#pragma once

#include "common/base/transform.h"
#include "common/mesh/operations.h"
#include "tests/support/meshes.h"

namespace lodestream::testing {

// Scaled about the origin, then moved.
inline mesh::Mesh moved(mesh::Mesh mesh, const Vec3f& by, float scale = 1.0f) {
    for (Vec3f& p : mesh.positions) p = scale * p + by;
    return mesh;
}

// One material, one node, no object yet.
inline mesh::Model empty_scene() {
    mesh::Model model;
    model.kind = mesh::Kind::scene;
    model.materials.resize(1);
    model.graph.parents = {mesh::no_parent};
    return model;
}

inline void add_object(mesh::Model& model, const mesh::Mesh& mesh, std::uint32_t node = 0) {
    const auto object = static_cast<std::uint32_t>(model.graph.object_nodes.size());
    mesh::append(model.mesh, mesh);
    model.mesh.triangle_objects.resize(model.mesh.triangles.size(), object);
    model.graph.object_nodes.push_back(node);
    model.objects = object + 1;
}

// side * side spheres of 2 * n * (n - 1) triangles in the xz plane.
inline mesh::Model spheres(std::uint32_t side, std::uint32_t n) {
    mesh::Model model = empty_scene();
    for (std::uint32_t row = 0; row < side; ++row)
        for (std::uint32_t column = 0; column < side; ++column)
            add_object(model, moved(sphere(n), 3.0f * Vec3f(column, 0, row)));
    return model;
}

// The same, all but those of the first row instances of one shape, every second one mirrored.
inline mesh::Model instanced_spheres(std::uint32_t side, std::uint32_t n) {
    mesh::Model model = empty_scene();
    model.shapes.push_back(sphere(n));
    for (std::uint32_t row = 0; row < side; ++row)
        for (std::uint32_t column = 0; column < side; ++column) {
            const Vec3d place = 3.0 * Vec3d(column, 0, row);
            if (row == 0) {
                add_object(model, moved(sphere(n), Vec3f(place)));
                continue;
            }
            const Vec3d scale(column % 2 == 0 ? 1 : -1, 1, 1);
            model.instances.push_back({model.objects++, 0, matrix_of(place, {0, 0, 0, 1}, scale)});
            model.graph.object_nodes.push_back(0);
        }
    return model;
}

// Small spheres inside a hull of radius 5 that hides them, of 2 * n * (n - 1) triangles.
inline mesh::Model hull_with_cargo(std::uint32_t n) {
    mesh::Model model = empty_scene();
    for (int i = 0; i < 20; ++i) add_object(model, moved(sphere(8), Vec3f(i % 5 - 2, i % 4, 0)));
    add_object(model, moved(sphere(n), {0, 0, 0}, 5.0f));
    return model;
}

}  // namespace lodestream::testing
