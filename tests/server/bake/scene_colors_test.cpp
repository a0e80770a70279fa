#include "server/bake/scene_colors.h"

#include <gtest/gtest.h>

#include "common/mesh/operations.h"
#include "tests/common/texture/textured.h"
#include "tests/server/bake/red_and_blue.h"
#include "tests/support/scenes.h"

namespace lodestream::bake {
namespace {

// Faces up.
mesh::Mesh square_at(float height) {
    mesh::Mesh mesh;
    mesh.positions = {{-1, height, -1}, {1, height, -1}, {-1, height, 1}, {1, height, 1}};
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}};
    return mesh;
}

mesh::Model red_over_blue() {
    mesh::Model model = testing::layer_of_cubes(1);  // for its materials
    model.mesh = square_at(0.0f);
    mesh::append(model.mesh, square_at(-0.1f));
    model.mesh.triangle_materials = {0, 0, 1, 1};
    return model;
}

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

TEST(SceneColors, AsSeenATexelShowsWhatLiesBeforeItNotWhatIsNearest) {
    const mesh::Model model = red_over_blue();
    const SceneColors colors(model, model.mesh);
    const mesh::Mesh near_blue = square_at(-0.09f);
    const Result<mesh::Model> nearest = colors.paint(near_blue), seen = colors.paint_as_seen(near_blue);
    ASSERT_TRUE(nearest.ok() && seen.ok());
    const Vec3f middle(1.0f / 3.0f);
    for (std::size_t t = 0; t < near_blue.triangles.size(); ++t) {
        EXPECT_EQ(SurfaceColors(*nearest, nearest->mesh).at(t, middle), Rgba8(0, 0, 255, 255));
        EXPECT_EQ(SurfaceColors(*seen, seen->mesh).at(t, middle), Rgba8(255, 0, 0, 255));
    }
}

TEST(SceneColors, AsSeenATexelThatTheSurfaceItselfHidesShowsWhatIsNearest) {
    const mesh::Model model = red_over_blue();
    mesh::Mesh covered = square_at(-0.09f);
    mesh::append(covered, testing::moved(square_at(0.0f), {0, 0.01f, 0}, 4.0f));
    const Result<mesh::Model> painted = SceneColors(model, model.mesh).paint_as_seen(covered);
    ASSERT_TRUE(painted.ok());
    EXPECT_EQ(SurfaceColors(*painted, painted->mesh).at(0, Vec3f(1.0f / 3.0f)), Rgba8(0, 0, 255, 255));
}

TEST(SceneColors, AsSeenAFineSurfaceShowsWhatIsNearest) {
    const mesh::Model model = testing::layer_of_cubes(3);
    const SceneColors colors(model, model.mesh);
    const mesh::Mesh fine = testing::sphere(40);
    ASSERT_GT(fine.triangles.size(), max_seen_triangles);
    EXPECT_EQ(colors.paint_as_seen(fine)->images.at(0).bytes, colors.paint(fine)->images.at(0).bytes);
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
        const Result<mesh::Model> first = colors.paint_as_seen(surface), second = colors.paint_as_seen(surface);
        ASSERT_TRUE(first.ok()) << first.error().message;
        EXPECT_EQ(first->images.at(0).bytes, second->images.at(0).bytes);
        for (const Vec3f& normal : first->mesh.normals) EXPECT_NEAR(length(normal), 1.0f, 1e-3f);
        for (const Vec2f& place : first->mesh.texture_coordinates) EXPECT_TRUE(place.x >= 0 && place.x <= 1);
    }
}

}  // namespace
}  // namespace lodestream::bake
