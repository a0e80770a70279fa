// Three spheres as a ladder, without a server.
#pragma once

#include <gtest/gtest.h>

#include "client/fly/scenery.h"
#include "client/render/renderer.h"
#include "tests/support/meshes.h"

namespace lodestream::fly::testing {

inline Scenery spheres(const std::string& kind = "mesh") {
    Scenery scenery;
    scenery.kind = kind;
    double error = 0.0;
    for (const std::uint32_t rings : {48u, 24u, 6u}) {
        mesh::Model model;
        model.mesh = lodestream::testing::sphere(rings);
        model.materials.emplace_back();
        scenery.levels.push_back({render::drawable(model, model.mesh), model.mesh.triangles.size(), error});
        error += 0.05;
    }
    EXPECT_TRUE(prepare(scenery));
    return scenery;
}

}  // namespace lodestream::fly::testing
