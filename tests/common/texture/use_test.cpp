#include "common/texture/use.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/common/texture/textured.h"

namespace lodestream::texture {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

mesh::Image of_size(std::uint32_t width, std::uint32_t height) {
    return {"image/png", {}, width, height};
}

TEST(ImageUses, FollowTheMaterialsOfTrianglesAlone) {
    mesh::Model model = square_with(of_size(8, 8));
    model.images.resize(4, of_size(8, 8));
    model.materials[0].occlusion_texture.image = 1;
    model.materials.resize(2);
    model.materials[1].base_color_texture.image = 3;  // no triangle has this material
    const std::vector<ImageUse> uses = image_uses(model);
    EXPECT_TRUE(uses[0].is_used);
    EXPECT_EQ(uses[0].content, image::Content::color);
    EXPECT_TRUE(uses[1].is_used);
    EXPECT_EQ(uses[1].content, image::Content::data);
    EXPECT_FALSE(uses[2].is_used);
    EXPECT_FALSE(uses[3].is_used);
    model.mesh.texture_coordinates.clear();
    EXPECT_FALSE(image_uses(model)[0].is_used);
}

TEST(ImageUses, OneReadUnderAlphaIsAveragedSo) {
    mesh::Model model = square_with(of_size(8, 8));
    model.materials[0].emissive_texture.image = 0;
    model.materials[0].metallic_roughness_texture.image = 0;
    EXPECT_EQ(image_uses(model)[0].content, image::Content::color);
    EXPECT_FALSE(image_uses(model)[0].reads_alpha);
    model.materials[0].alpha_mode = mesh::AlphaMode::blend;
    EXPECT_EQ(image_uses(model)[0].content, image::Content::color_under_alpha);
    EXPECT_TRUE(image_uses(model)[0].reads_alpha);
}

TEST(TexelSizes, AreSideOverTexels) {
    EXPECT_DOUBLE_EQ(texel_sizes(square_with(of_size(256, 256)))[0], 1.0 / 256);
    EXPECT_DOUBLE_EQ(texel_sizes(square_with(of_size(1, 1)))[0], 1.0);
}

TEST(TexelSizes, ThatStretchTakeTheLongerAxis) {
    EXPECT_DOUBLE_EQ(texel_sizes(square_with(of_size(256, 16)))[0], 1.0 / 16);
    mesh::Model model = square_with(of_size(256, 256));
    for (Vec3f& p : model.mesh.positions) p.x *= 10.0f;
    EXPECT_NEAR(texel_sizes(model)[0], 10.0 / 256, 1e-9);
    for (Vec2f& t : model.mesh.texture_coordinates) t.x *= 10.0f;  // the image ten times across it
    EXPECT_NEAR(texel_sizes(model)[0], 1.0 / 256, 1e-9);
}

TEST(TexelSizes, OfFacesThatShowOneTexelAreInfinite) {
    mesh::Model model = square_with(of_size(64, 64));
    for (Vec2f& t : model.mesh.texture_coordinates) t = {0.5f, 0.5f};
    EXPECT_EQ(texel_sizes(model)[0], infinity);
}

TEST(TexelSizes, DoNotCountASmallStretchedPart) {
    mesh::Model model = square_with(of_size(64, 64));
    model.mesh.positions.insert(model.mesh.positions.end(), {{0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}});
    model.mesh.texture_coordinates.insert(model.mesh.texture_coordinates.end(), 3, {0, 0});
    model.mesh.triangles.push_back({4, 6, 5});
    EXPECT_DOUBLE_EQ(texel_sizes(model)[0], 1.0 / 64);
}

TEST(TexelSizes, OfUnusedImagesAndUntexturedMeshesAreInfinite) {
    mesh::Model model = square_with(of_size(64, 64));
    model.images.push_back(of_size(8, 8));
    EXPECT_EQ(texel_sizes(model)[1], infinity);
    model.mesh.texture_coordinates.clear();
    EXPECT_EQ(texel_sizes(model)[0], infinity);
    EXPECT_TRUE(texel_sizes(mesh::Model{}).empty());
}

}  // namespace
}  // namespace lodestream::texture
