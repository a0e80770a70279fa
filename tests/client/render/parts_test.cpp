// A scene of parts that come and go, and how they share the samples of a picture while they fade.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "client/render/renderer.h"
#include "tests/client/render/contents.h"
#include "tests/client/render/with_renderer.h"
#include "tests/support/meshes.h"

namespace lodestream::render {
namespace {

using codec::Decoded;
using codec::Shading;
using shading::View;

const View from_front{{0, 0, 4}, {0, 0, 0}, 45.0, {0, 0, 1}};

Box cube(double half) {
    return {Vec3d{-half}, Vec3d{half}};
}

Decoded content_of(mesh::Mesh mesh, Shading shading, Vec3f color) {
    return testing::content_of(std::move(mesh), shading, Vec4f(color, 1.0f));
}

// Wider than the picture, facing the eye; lit by its ambience alone it shows its colour as it is.
mesh::Mesh wall(float z = 0.0f, float half = 5.0f) {
    mesh::Mesh m;
    m.positions = {{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}};
    m.normals.assign(4, Vec3f{0, 0, 1});
    m.triangles = {{0, 1, 2}, {0, 2, 3}};
    return m;
}

class PartsTest : public testing::WithRenderer {
  protected:
    std::uint32_t add(const Decoded& content) {
        const auto part = prepare(content, scene);
        EXPECT_TRUE(part) << part.error().message;
        const auto added = renderer->add(*part);
        EXPECT_TRUE(added) << added.error().message;
        return *added;
    }
    Image picture(std::vector<DrawnPart> parts, std::uint32_t samples = 1) {
        DrawOptions options{.width = 96, .height = 96, .samples = samples, .background = {0, 1, 0}};
        options.phong = {.ambient = 1.0, .diffuse = 0.0, .specular = 0.0};
        options.parts = std::move(parts);
        const auto frame = renderer->draw(from_front, options);
        EXPECT_TRUE(frame) << frame.error().message;
        return frame ? frame->image : Image{};
    }

    Box scene = cube(5.0);
};

std::array<int, 3> color_of(const Image& image, std::size_t pixel) {
    return {image.rgba[4 * pixel], image.rgba[4 * pixel + 1], image.rgba[4 * pixel + 2]};
}

TEST_F(PartsTest, EverySampleShowsExactlyOneOfBothLevelsAtEveryStepOfAFade) {
    ASSERT_TRUE(renderer->begin_scene(scene));
    // Of both shadings, for these are different programs that must agree to the bit.
    const std::uint32_t red = add(content_of(wall(), Shading::flat, {1, 0, 0}));
    const std::uint32_t blue = add(content_of(wall(), Shading::gouraud, {0, 0, 1}));
    for (const double progress : {0.0, 1e-9, 0.1, 0.25, 1.0 / 3.0, 0.5, 0.7001, 0.984375, 1.0}) {
        const Image image = picture({{red, {0.0, progress}}, {blue, {progress, 1.0}}});
        std::size_t reds = 0;
        for (std::size_t p = 0; p < image.pixels(); ++p) {
            const auto color = color_of(image, p);
            ASSERT_EQ(color[1], 0) << "a hole at pixel " << p << ", " << progress;
            ASSERT_EQ(color[0] + color[2], 255) << "both at pixel " << p << ", " << progress;
            reds += color[0] == 255 ? 1 : 0;
        }
        // 96 is a multiple of the pattern's 8, so the share is exact but for its rounding to 64 steps.
        EXPECT_NEAR(static_cast<double>(reds) / static_cast<double>(image.pixels()), progress, 0.5 / 64 + 1e-9);
    }
}

TEST_F(PartsTest, WithSamplesEachPixelGoesOverInAsManySteps) {
    ASSERT_TRUE(renderer->begin_scene(scene));
    const std::uint32_t red = add(content_of(wall(), Shading::gouraud, {1, 0, 0}));
    const std::uint32_t blue = add(content_of(wall(), Shading::flat, {0, 0, 1}));
    std::vector<int> before(96 * 96, 0);
    for (const double progress : {0.1, 0.3, 0.5, 0.6, 0.9}) {
        const Image image = picture({{red, {0.0, progress}}, {blue, {progress, 1.0}}}, 4);
        double sum = 0.0;
        for (std::size_t p = 0; p < image.pixels(); ++p) {
            const auto color = color_of(image, p);
            ASSERT_EQ(color[1], 0) << "a hole at pixel " << p;
            // Quarters of linear light.
            const auto linear = [](int srgb) { return std::pow((srgb / 255.0 + 0.055) / 1.055, 2.4); };
            const double reds = 4.0 * (color[0] > 0 ? linear(color[0]) : 0.0);
            const double blues = 4.0 * (color[2] > 0 ? linear(color[2]) : 0.0);
            ASSERT_NEAR(reds + blues, 4.0, 0.05) << "both or none at pixel " << p;
            ASSERT_LE(std::abs(reds - 4.0 * progress), 1.0 + 0.05) << "pixel " << p;
            ASSERT_GE(color[0], before[p]) << "a pixel turns back";
            before[p] = color[0];
            sum += reds / 4.0;
        }
        EXPECT_NEAR(sum / static_cast<double>(image.pixels()), progress, 0.01);
    }
}

TEST_F(PartsTest, AFadingLevelStillHidesWhatIsBehindItAtItsSamplesAlone) {
    ASSERT_TRUE(renderer->begin_scene(scene));
    const std::uint32_t far = add(content_of(wall(-1.0f), Shading::flat, {0, 0, 1}));
    const std::uint32_t near = add(content_of(wall(0.0f), Shading::flat, {1, 0, 0}));
    const Image image = picture({{near, {0.25, 0.75}}, {far}});
    std::size_t reds = 0;
    for (std::size_t p = 0; p < image.pixels(); ++p) {
        const auto color = color_of(image, p);
        ASSERT_TRUE((color == std::array{255, 0, 0} || color == std::array{0, 0, 255}));
        reds += color[0] == 255 ? 1 : 0;
    }
    EXPECT_EQ(reds, image.pixels() / 2);
}

TEST_F(PartsTest, PartsTogetherDrawTheSamePictureAsTheirWholeWouldAndBordersHaveNoCracks) {
    // Two halves of a bumpy grid, whose border lies across the picture, moved far away.
    const mesh::Mesh whole =
        testing::grid(24, [](double x, double z) { return 0.7 * std::sin(x * 1.3) * std::cos(z * 0.9); });
    Decoded left = content_of(whole, Shading::flat, {0.5f, 0.5f, 0.5f});
    left.origin = {1e5, 0.0, -1e5};
    Decoded right = left, both = left;
    std::erase_if(left.primitives[0].mesh.triangles, [&](const mesh::Triangle& t) { return t[0] % 25 < 12; });
    std::erase_if(right.primitives[0].mesh.triangles, [&](const mesh::Triangle& t) { return t[0] % 25 >= 12; });
    const Box bounds = world_bounds(both);
    const View view = shading::framing_view(bounds);
    const DrawOptions options{.width = 400, .height = 300, .samples = 1, .background = {1, 0, 1}};
    ASSERT_TRUE(renderer->upload(both));
    const auto expected = renderer->draw(view, options);
    ASSERT_TRUE(expected);

    ASSERT_TRUE(renderer->begin_scene(bounds));
    DrawOptions of_parts = options;
    for (const Decoded& content : {left, right}) {
        const auto part = prepare(content, bounds);
        ASSERT_TRUE(part);
        const auto added = renderer->add(*part);
        ASSERT_TRUE(added);
        of_parts.parts.push_back({*added});
    }
    const auto frame = renderer->draw(view, of_parts);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->image.rgba, expected->image.rgba);
    EXPECT_EQ(frame->triangles, expected->triangles);
    EXPECT_EQ(frame->draw_calls, 2u);
}

// Halves of a cloud, each with the discs of the whole: what instances of one level draw.
TEST_F(PartsTest, PartsOfPointsTogetherDrawThePictureOfTheirWhole) {
    codec::Points whole;
    const mesh::Mesh sphere = lodestream::testing::sphere(40);
    whole.cloud.positions = sphere.positions;
    whole.cloud.normals = sphere.normals;
    whole.base_color = {0.5f, 0.25f, 0.1f, 1.0f};
    whole.levels = {{sphere.positions.size(), {}, 0.08}};
    std::array<codec::Points, 2> halves{whole, whole};
    for (codec::Points& half : halves) half.cloud = {};
    for (std::size_t i = 0; i < sphere.positions.size(); ++i) {
        points::PointCloud& half = halves[sphere.positions[i].x < 0.0f ? 0 : 1].cloud;
        half.positions.push_back(sphere.positions[i]);
        half.normals.push_back(sphere.normals[i]);
    }
    for (const double distance : {4.0, 1.6}) {  // as points, and so near that discs are quads
        const View view{{0, 0, distance}, {0, 0, 0}, 45.0, {0, 0, 1}};
        DrawOptions options{.width = 128, .height = 128, .samples = 1};
        ASSERT_TRUE(renderer->upload(whole));
        const auto expected = renderer->draw(view, options);
        ASSERT_TRUE(renderer->begin_scene(scene));
        std::uint64_t points = 0;
        for (const codec::Points& half : halves) {
            const auto part = prepare(half, scene);
            ASSERT_TRUE(part) << part.error().message;
            EXPECT_GE(part->gpu_bytes, 24 * part->points);
            points += part->points;
            options.parts.push_back({*renderer->add(*part)});
        }
        const auto drawn = renderer->draw(view, options);
        ASSERT_TRUE(expected && drawn);
        EXPECT_EQ(expected->points, points);
        EXPECT_EQ(drawn->points, points);
        EXPECT_EQ(points, sphere.positions.size());
        const auto difference = compare(expected->image, drawn->image);
        ASSERT_TRUE(difference);
        EXPECT_GT(difference->compared_pixels, 4000u);
        EXPECT_LT(difference->rms, 4.0) << distance;  // of two scales of floats: discs that touch may change places
    }
}

TEST_F(PartsTest, ACloudThatIsNoneIsRefusedAndAnEmptyOneDrawsNothing) {
    codec::Points cloud;
    const auto empty = prepare(cloud, scene);
    ASSERT_TRUE(empty) << empty.error().message;
    ASSERT_TRUE(renderer->begin_scene(scene));
    const auto added = renderer->add(*empty);
    ASSERT_TRUE(added);
    EXPECT_EQ(color_of(picture({{*added}}), 0), (std::array<int, 3>{0, 255, 0}));
    cloud.cloud.positions = {Vec3f(std::numeric_limits<float>::quiet_NaN())};
    EXPECT_FALSE(prepare(cloud, scene));
    EXPECT_FALSE(prepare(codec::Points{}, Box{}));
}

TEST_F(PartsTest, OnlyThePartsAskedForAreDrawnAndThoseOutOfSightAreLeftOut) {
    ASSERT_TRUE(renderer->begin_scene(scene));
    const std::uint32_t ahead = add(content_of(testing::sphere(8), Shading::gouraud, {1, 0, 0}));
    mesh::Mesh aside = testing::sphere(8);
    for (Vec3f& p : aside.positions) p = 0.1f * p + Vec3f{4.5f, 4.5f, 3.0f};
    const std::uint32_t out_of_sight = add(content_of(aside, Shading::flat, {0, 0, 1}));
    DrawOptions options{.width = 96, .height = 96, .samples = 1};
    EXPECT_EQ(renderer->draw(from_front, options)->triangles, 0u);
    options.parts = {{ahead}, {out_of_sight}};
    const auto frame = renderer->draw(from_front, options);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->triangles, 2u * 8 * 7);
    EXPECT_EQ(frame->draw_calls, 1u);
}

TEST_F(PartsTest, ARemovedPartIsGoneAndItsNameIsNotGivenAgain) {
    ASSERT_TRUE(renderer->begin_scene(scene));
    const std::uint32_t first = add(content_of(wall(), Shading::flat, {1, 0, 0}));
    const std::uint32_t second = add(content_of(wall(), Shading::flat, {0, 0, 1}));
    renderer->remove(first);
    renderer->remove(first);
    DrawOptions options{.width = 96, .height = 96, .samples = 1};
    options.parts = {{first}};
    const auto gone = renderer->draw(from_front, options);
    ASSERT_FALSE(gone);
    EXPECT_EQ(gone.error().code, ErrorCode::invalid_input);
    EXPECT_EQ(color_of(picture({{second}}), 0), (std::array{0, 0, 255}));
    const std::uint32_t third = add(content_of(wall(), Shading::flat, {1, 0, 0}));
    EXPECT_NE(third, first);
    EXPECT_NE(third, second);
    EXPECT_EQ(color_of(picture({{third}}), 0), (std::array{255, 0, 0}));
}

TEST_F(PartsTest, APartOfAnotherSceneIsRefused) {
    const auto part = prepare(content_of(wall(), Shading::flat, {1, 0, 0}), cube(5.0));
    ASSERT_TRUE(part);
    EXPECT_FALSE(renderer->add(*part)) << "no scene was begun";
    ASSERT_TRUE(renderer->begin_scene(cube(6.0)));
    EXPECT_FALSE(renderer->add(*part));
    EXPECT_FALSE(renderer->add({}));
    ASSERT_TRUE(renderer->begin_scene(cube(5.0)));
    EXPECT_TRUE(renderer->add(*part));
    ASSERT_TRUE(renderer->upload(content_of(wall(), Shading::flat, {1, 0, 0})));
    EXPECT_FALSE(renderer->add(*part)) << "a level took the scene's place";
}

TEST_F(PartsTest, WrongNumbersAreRefused) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const Decoded content = content_of(wall(), Shading::flat, {1, 0, 0});
    for (const Box& box : {Box{}, cube(infinite), Box{Vec3d{0.0}, Vec3d{1.0, none, 1.0}}}) {
        EXPECT_FALSE(renderer->begin_scene(box));
        EXPECT_FALSE(prepare(content, box));
    }
    Decoded broken = content;
    broken.primitives[0].mesh.triangles[0][0] = 99;
    EXPECT_FALSE(prepare(broken, scene));

    ASSERT_TRUE(renderer->begin_scene(scene));
    const std::uint32_t part = add(content);
    for (const Share share : {Share{-0.1, 0.5}, Share{0.5, 1.1}, Share{none, 1.0}, Share{0.0, none}}) {
        DrawOptions options{.width = 96, .height = 96, .samples = 1};
        options.parts = {{part, share}};
        EXPECT_FALSE(renderer->draw(from_front, options));
    }
}

TEST_F(PartsTest, APartTellsItsBytesAsTheUploadDoes) {
    Decoded content = content_of(testing::sphere(8), Shading::gouraud, {1, 1, 1});
    content.primitives.push_back({Shading::flat, 0, testing::sphere(6)});
    content.primitives.back().mesh.normals.clear();
    const auto uploaded = renderer->upload(content);
    const auto part = prepare(content, scene);
    ASSERT_TRUE(uploaded && part);
    EXPECT_EQ(part->gpu_bytes, uploaded->geometry_bytes);
    EXPECT_EQ(part->triangles, uploaded->triangles);
}

TEST_F(PartsTest, ADamagedImageIsWarnedOfWhileThePartIsPrepared) {
    Decoded content = content_of(wall(), Shading::flat, {1, 0, 0});
    content.primitives[0].mesh.texture_coordinates.assign(4, Vec2f{0.5f});
    content.images = {{"image/png", std::vector<std::byte>(32), 4, 4}};
    content.materials[0].base_color_texture.image = 0;
    const auto part = prepare(content, scene);
    ASSERT_TRUE(part);
    EXPECT_EQ(part.warnings.size(), 1u);
    ASSERT_TRUE(renderer->begin_scene(scene));
    const auto added = renderer->add(*part);
    ASSERT_TRUE(added);
    EXPECT_EQ(color_of(picture({{*added}}), 0), (std::array{255, 0, 0}));
}

}  // namespace
}  // namespace lodestream::render
