#include "server/bake/scene_colors.h"

#include <gtest/gtest.h>

#include "tests/common/texture/textured.h"
#include "tests/server/bake/red_and_blue.h"
#include "tests/support/scenes.h"

namespace lodestream::bake {
namespace {

TEST(SceneColors, OneColourNeedsNoImage) {
    mesh::Model model = testing::spheres(2, 12);
    model.materials[0].base_color = {0.2f, 0.4f, 0.6f, 1.0f};
    const Result<mesh::Model> painted = SceneColors(model, model.mesh).paint(testing::sphere(6));
    ASSERT_TRUE(painted.ok()) << painted.error().message;
    EXPECT_TRUE(painted->images.empty());
    EXPECT_TRUE(painted->mesh.texture_coordinates.empty());
    EXPECT_EQ(painted->materials[0].base_color, model.materials[0].base_color);
}

TEST(SceneColors, ASurfaceBesideTheSceneShowsWhatIsNearest) {
    const mesh::Model model = testing::layer_of_cubes(6);
    mesh::Mesh sheet = testing::moved(testing::flat_grid(12), {-0.5f, 0.7f, -0.5f}, 0.5f);
    const Result<mesh::Model> painted = SceneColors(model, model.mesh).paint(sheet);
    ASSERT_TRUE(painted.ok()) << painted.error().message;
    ASSERT_EQ(painted->images.size(), 1u);
    EXPECT_EQ(painted->mesh.triangles.size(), sheet.triangles.size());
    EXPECT_EQ(painted->mesh.normals.size(), painted->mesh.positions.size());
    testing::expect_red_and_blue(*painted, painted->mesh, 6);
}

TEST(SceneColors, TexturesOfTheSceneAreSeen) {
    image::Pixels halves{8, 8, {}};
    for (std::uint32_t i = 0; i < 64; ++i) {
        const std::uint8_t left = i % 8 < 4 ? 255 : 0;
        halves.rgba.insert(halves.rgba.end(), {left, 0, static_cast<std::uint8_t>(255 - left), 255});
    }
    mesh::Model model = texture::square_with(texture::png_of(halves));
    const Result<mesh::Model> painted = SceneColors(model, model.mesh).paint(model.mesh);
    ASSERT_TRUE(painted.ok()) << painted.error().message;
    const SurfaceColors before(model, model.mesh), after(*painted, painted->mesh);
    for (const Vec3f weights : {Vec3f(0.8f, 0.1f, 0.1f), Vec3f(0.1f, 0.8f, 0.1f), Vec3f(0.1f, 0.1f, 0.8f)})
        for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t)
            EXPECT_EQ(after.at(t, weights), before.at(t, weights));
}

TEST(SceneColors, TheSameBytesTwiceAndFiniteOnNeedles) {
    const mesh::Model model = testing::layer_of_cubes(3);
    const SceneColors colors(model, model.mesh);
    mesh::Mesh needle = testing::single_triangle();
    needle.positions[2] = needle.positions[0] + Vec3f(1e-30f, 0, 0);
    for (const mesh::Mesh& surface : {testing::sphere(9), needle}) {
        const Result<mesh::Model> first = colors.paint(surface), second = colors.paint(surface);
        ASSERT_TRUE(first.ok()) << first.error().message;
        EXPECT_EQ(first->images.at(0).bytes, second->images.at(0).bytes);
        for (const Vec3f& normal : first->mesh.normals) EXPECT_NEAR(length(normal), 1.0f, 1e-3f);
        for (const Vec2f& place : first->mesh.texture_coordinates) EXPECT_TRUE(place.x >= 0 && place.x <= 1);
    }
}

}  // namespace
}  // namespace lodestream::bake
