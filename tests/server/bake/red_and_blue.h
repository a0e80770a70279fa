// A scene of two colours, and surfaces that stand for it.
#pragma once

#include <gtest/gtest.h>

#include "server/bake/surface_colors.h"
#include "tests/support/scenes.h"

namespace lodestream::testing {

// Cubes that nearly touch, in one layer, the left ones red and the right ones blue.
inline mesh::Model layer_of_cubes(int side) {
    mesh::Mesh cube;
    for (int i = 0; i < 8; ++i) cube.positions.push_back(0.48f * Vec3f(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    cube.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    cube = mesh::with_normals(cube, 30);
    mesh::Model model = empty_scene();
    model.materials.resize(2);
    model.materials[0].base_color = {1, 0, 0, 1};
    model.materials[1].base_color = {0, 0, 1, 1};
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            add_object(model, moved(cube, {column, 0, row}));
            model.mesh.triangle_materials.resize(model.mesh.triangles.size(), 2 * column < side ? 0 : 1);
        }
    return model;
}

// Of a level of that, away from the border: at the middles of its triangles.
inline void expect_red_and_blue(const mesh::Model& model, const mesh::Mesh& level, int side) {
    const bake::SurfaceColors colors(model, level);
    for (std::size_t t = 0; t < level.triangles.size(); ++t) {
        float x = 0.0f;
        for (const std::uint32_t v : level.triangles[t]) x += level.positions[v].x / 3.0f;
        const Rgba8 color = colors.at(t, Vec3f(1.0f / 3.0f));
        EXPECT_TRUE(x > 0.4f * static_cast<float>(side) || color.x > 150) << t;
        EXPECT_TRUE(x < 0.6f * static_cast<float>(side) || color.z > 150) << t;
    }
}

}  // namespace lodestream::testing
