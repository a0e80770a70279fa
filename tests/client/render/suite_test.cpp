// The renderer as every driver shows it: what it counts, sends, refuses, leaves out and gives back. The same source
// runs on EGL and on the recording fake; nothing here looks at a pixel that something is drawn on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "client/render/renderer.h"
#include "tests/client/render/backend.h"
#include "tests/client/render/contents.h"
#include "tests/support/meshes.h"

namespace lodestream::render {
namespace {

using codec::Decoded;
using codec::Shading;
using shading::View;
using testing::content_of;
using testing::live_objects;
using testing::LiveObjects;
using testing::square;

const View from_front{{0, 0, 4}, {0, 0, 0}, 45.0, {0, 0, 1}};
const View turned_away{{0, 0, 4}, {0, 0, 8}, 45.0, {0, 0, 1}};
const DrawOptions small{.width = 32, .height = 24, .samples = 1};
constexpr double infinity = std::numeric_limits<double>::infinity();

// Every case ends with the renderer's end, after which no object of OpenGL may be left.
class RendererSuite : public ::testing::Test {
  protected:
    void SetUp() override {
        auto made = Renderer::create();
        ASSERT_TRUE(made) << made.error().message;
        renderer.emplace(*std::move(made));
    }

    void TearDown() override {
        renderer.reset();
        EXPECT_EQ(live_objects(), LiveObjects{});
        EXPECT_THAT(backend.misuses(), ::testing::IsEmpty());
    }

    template <class Level>
    UploadStatistics put(const Level& level) {
        const auto uploaded = renderer->upload(level);
        EXPECT_TRUE(uploaded) << uploaded.error().message;
        return uploaded ? *uploaded : UploadStatistics{};
    }

    Frame drawn(const View& view = from_front, const DrawOptions& options = small) {
        auto frame = renderer->draw(view, options);
        EXPECT_TRUE(frame) << frame.error().message;
        return frame ? *std::move(frame) : Frame{};
    }

    template <class Level>
    ErrorCode refusal_of(const Level& level) {
        const auto uploaded = renderer->upload(level);
        EXPECT_FALSE(uploaded);
        return uploaded ? ErrorCode::internal : uploaded.error().code;
    }

    ErrorCode refusal_of(const View& view, const DrawOptions& options) {
        const auto frame = renderer->draw(view, options);
        EXPECT_FALSE(frame);
        return frame ? ErrorCode::internal : frame.error().code;
    }

    testing::Backend backend;
    std::optional<Renderer> renderer;
};

bool is_background(const Image& image) {
    for (const std::uint8_t channel : image.rgba)
        if (channel != 255) return false;
    return !image.rgba.empty();
}

mesh::Image image_of(std::uint32_t side) {
    return {"image/png", *encode_png(solid(side, side, 9, 9, 9)), side, side};
}

// Two materials, the second with an image.
Decoded textured() {
    Decoded content = content_of(square(), Shading::gouraud);
    content.materials.emplace_back().base_color_texture.image = 0;
    content.primitives.push_back({Shading::gouraud, 1, square(0.5f)});
    content.images.push_back(image_of(4));
    return content;
}

MovableLevel movable_sphere() {
    return *movable_level(content_of(testing::sphere(8), Shading::gouraud));  // 112 triangles
}

codec::Points cloud_of(std::uint32_t points) {
    codec::Points content;
    for (std::uint32_t i = 0; i < points; ++i) {
        const double around = 2.4 * i;
        content.cloud.positions.emplace_back(std::cos(around), std::sin(around), 0.5);
        content.cloud.normals.emplace_back(0, 0, 1);
    }
    content.levels = {{points, {}, 0.1}};
    return content;
}

TEST_F(RendererSuite, CountsWhatItPutsOnTheGpu) {
    const UploadStatistics flat = put(content_of(testing::sphere(8), Shading::flat));
    EXPECT_EQ(flat.triangles, 112u);
    EXPECT_EQ(flat.gouraud_triangles, 0u);
    EXPECT_EQ(flat.flat_vertices, 112u);  // one evaluation of the light a face
    EXPECT_EQ(flat.gouraud_vertices, 0u);
    EXPECT_EQ(flat.geometry_bytes, 112u * (36u + 12u));
    const UploadStatistics smooth = put(content_of(testing::sphere(8), Shading::gouraud));
    EXPECT_EQ(smooth.gouraud_triangles, 112u);
    EXPECT_EQ(smooth.gouraud_vertices, 58u);
    EXPECT_EQ(smooth.flat_vertices, 0u);
    EXPECT_EQ(smooth.geometry_bytes, 58u * 24u + 112u * 12u);
    EXPECT_EQ(drawn().triangles, 112u);
    EXPECT_EQ(drawn().draw_calls, 1u);
}

TEST_F(RendererSuite, GeometryBytesAreThoseOfTheBuffers) {
    mesh::Mesh colored = testing::sphere(9);
    colored.colors.assign(colored.positions.size(), Rgba8{1, 2, 3, 255});
    Decoded content = textured();
    content.primitives.push_back({Shading::gouraud, 0, colored});
    colored.normals.clear();
    content.primitives.push_back({Shading::flat, 1, colored});
    std::uint64_t bytes = put(content).geometry_bytes;
    EXPECT_EQ(live_objects().buffer_bytes, bytes);
    bytes = put(movable_sphere()).geometry_bytes;
    EXPECT_EQ(live_objects().buffer_bytes, bytes);
    bytes = put(cloud_of(17)).geometry_bytes;
    EXPECT_EQ(bytes, 17u * 24u);
    EXPECT_EQ(live_objects().buffer_bytes, bytes);
}

TEST_F(RendererSuite, AnUploadTakesThePlaceOfTheOneBefore) {
    put(textured());  // whose programs stay
    put(content_of(testing::sphere(8), Shading::gouraud));
    const LiveObjects one = live_objects();
    for (int i = 0; i < 3; ++i) {
        put(textured());
        put(movable_sphere());
        put(cloud_of(5));
        put(content_of(testing::sphere(8), Shading::gouraud));
        EXPECT_EQ(live_objects(), one);
    }
    put(Decoded{});
    EXPECT_EQ(live_objects().buffers, 0);
    EXPECT_EQ(live_objects().vertex_arrays, 0);
    EXPECT_EQ(live_objects().textures, 0);
}

TEST_F(RendererSuite, AFrameOfTheSameSizeMakesNoObject) {
    put(textured());
    drawn();
    const LiveObjects first = live_objects();
    EXPECT_EQ(first.framebuffers, 1);
    drawn(turned_away);
    drawn();
    EXPECT_EQ(live_objects(), first);
    DrawOptions options = small;
    options.samples = 4;  // and what they are resolved into
    drawn(from_front, options);
    EXPECT_EQ(live_objects().framebuffers, 2);
    drawn();
    EXPECT_EQ(live_objects().renderbuffers, first.renderbuffers + 1);  // kept for the next picture with samples
}

TEST_F(RendererSuite, PicturesMayChangeTheirSizeAndSamples) {
    put(content_of(testing::sphere(8), Shading::gouraud));
    for (const std::uint32_t side : {8u, 300u, 3u})
        for (const std::uint32_t samples : {4u, 1u, 8u}) {
            const Frame frame = drawn(from_front, {.width = side, .height = 2 * side, .samples = samples, .frames = 3});
            EXPECT_EQ(frame.image.rgba.size(), std::size_t{side} * side * 2 * 4);
            EXPECT_EQ(frame.draw_calls, 1u);
        }
}

TEST_F(RendererSuite, AMovedBorderChangesRangesAloneAndUploadsNothing) {
    const UploadStatistics uploaded = put(movable_sphere());
    EXPECT_EQ(uploaded.triangles, 112u);
    EXPECT_EQ(uploaded.gouraud_triangles, 112u);
    EXPECT_EQ(uploaded.gouraud_vertices, 58u);
    EXPECT_EQ(drawn().draw_calls, 1u);
    const LiveObjects before = live_objects();
    for (const std::uint64_t gouraud : {std::uint64_t{50}, std::uint64_t{1}, std::uint64_t{111}}) {
        renderer->move_split(gouraud);
        const Frame frame = drawn();
        EXPECT_EQ(frame.draw_calls, 2u);
        EXPECT_EQ(frame.triangles, 112u);
    }
    for (const std::uint64_t gouraud : {std::uint64_t{0}, std::uint64_t{112}, ~std::uint64_t{0}}) {
        renderer->move_split(gouraud);
        EXPECT_EQ(drawn().draw_calls, 1u);
        EXPECT_EQ(drawn().triangles, 112u);
    }
    EXPECT_EQ(live_objects(), before);
}

TEST_F(RendererSuite, ABorderWithoutAMovableLevelIsNothing) {
    renderer->move_split(3);
    put(textured());
    renderer->move_split(0);
    const Frame frame = drawn();
    EXPECT_EQ(frame.triangles, 4u);
    EXPECT_EQ(frame.draw_calls, 2u);
}

TEST_F(RendererSuite, RefusesAMovableLevelWithoutItsPlaces) {
    MovableLevel level = movable_sphere();
    level.places.clear();
    EXPECT_EQ(refusal_of(level), ErrorCode::invalid_input);
    level = movable_sphere();
    level.places[0].pop_back();
    EXPECT_EQ(refusal_of(level), ErrorCode::invalid_input);
    level = movable_sphere();
    level.content.primitives[0].shading = Shading::flat;
    EXPECT_EQ(refusal_of(level), ErrorCode::invalid_input);
    EXPECT_EQ(drawn().draw_calls, 0u);
}

TEST_F(RendererSuite, ARefusedLevelLeavesNothingOfItselfOrOfTheOneBefore) {
    const auto refused = [&](auto damage) {
        put(textured());
        Decoded content = textured();
        damage(content);
        EXPECT_EQ(refusal_of(content), ErrorCode::invalid_input);
        const Frame frame = drawn();
        EXPECT_EQ(frame.draw_calls, 0u);
        EXPECT_EQ(frame.triangles, 0u);
        EXPECT_TRUE(is_background(frame.image));
        EXPECT_EQ(live_objects().buffers, 0);
        EXPECT_EQ(live_objects().textures, 0);
    };
    refused([](Decoded& d) { d.primitives[0].mesh.triangles[1][2] = 4; });
    refused([](Decoded& d) { d.primitives[0].mesh.normals.pop_back(); });
    refused([](Decoded& d) { d.primitives[0].mesh.normals.clear(); });
    refused([](Decoded& d) { d.primitives[0].mesh.colors.resize(2); });
    refused([](Decoded& d) { d.primitives[1].mesh.texture_coordinates.resize(1); });
    refused([](Decoded& d) { d.primitives[0].mesh.positions[0].x = NAN; });
    refused([](Decoded& d) { d.primitives[1].material = 2; });
    refused([](Decoded& d) { d.origin.y = infinity; });
}

TEST_F(RendererSuite, RefusesCloudsThatContradictThemselves) {
    const auto refused = [&](auto damage) {
        codec::Points cloud = cloud_of(10);
        damage(cloud);
        EXPECT_EQ(refusal_of(cloud), ErrorCode::invalid_input);
        EXPECT_EQ(drawn().draw_calls, 0u);
    };
    refused([](codec::Points& p) { p.cloud.positions[3].y = NAN; });
    refused([](codec::Points& p) { p.cloud.normals.pop_back(); });
    refused([](codec::Points& p) { p.cloud.colors.resize(3); });
    refused([](codec::Points& p) { p.levels[0].radius = infinity; });
    refused([](codec::Points& p) { p.levels[0].radius = -1.0; });
    refused([](codec::Points& p) { p.origin.z = NAN; });
}

TEST_F(RendererSuite, WithoutTrianglesOrPointsThereIsTheBackgroundAlone) {
    EXPECT_TRUE(world_bounds(Decoded{}).empty());
    EXPECT_TRUE(is_background(drawn().image));
    put(Decoded{});
    EXPECT_TRUE(is_background(drawn().image));
    put(content_of(mesh::Mesh{}, Shading::gouraud));
    EXPECT_TRUE(is_background(drawn().image));
    put(MovableLevel{});
    renderer->move_split(7);
    EXPECT_TRUE(is_background(drawn().image));
    put(codec::Points{});
    const Frame frame = drawn();
    EXPECT_TRUE(is_background(frame.image));
    EXPECT_EQ(frame.draw_calls, 0u);
    EXPECT_EQ(live_objects().buffers, 0);
}

TEST_F(RendererSuite, WhatTheEyeCannotSeeIsNotSent) {
    put(content_of(testing::sphere(8), Shading::flat));
    for (const View& view : {turned_away, View{{0, 0, 1e9}, {0, 0, 0}, 45, {0, 0, 1}},
                             View{{1e300, 1e300, 1e308}, {-1e308, 0, -1e308}, 45, {0, 0, 1e308}}}) {
        const Frame frame = drawn(view);
        EXPECT_EQ(frame.draw_calls, 0u);
        EXPECT_EQ(frame.triangles, 0u);
        EXPECT_TRUE(is_background(frame.image));
    }
}

TEST_F(RendererSuite, InstancesOutsideThePictureAreNotSent) {
    const View far{{0, 0, 16}, {0, 0, 0}, 45.0, {0, 0, 1}};
    DrawOptions options = small;
    for (const bool as_points : {false, true}) {
        as_points ? put(cloud_of(40)) : put(content_of(testing::sphere(8), Shading::gouraud));
        options.instances = {{{-3, 0, 0}}, {{0, 0, 0}}, {{3, 0, 0}}, {{0, 0, 30}}, {{500, 0, 0}}, {{0, -500, 0}}};
        const Frame frame = drawn(far, options);
        EXPECT_EQ(frame.draw_calls, 3u);
        EXPECT_EQ(frame.triangles, as_points ? 0u : 3u * 112u);
        EXPECT_EQ(frame.points, as_points ? 3u * 40u : 0u);
        options.instances = {{{0, 0, 30}}, {{500, 0, 0}}};
        EXPECT_TRUE(is_background(drawn(far, options).image));
        options.instances.clear();
        EXPECT_EQ(drawn(far, options).draw_calls, 0u);
        options.instances = {{{1e300, 0, 0}}, {{0, 0, 0}}};
        drawn(far, options);
        options.instances = {{{infinity, 0, 0}}};
        EXPECT_EQ(refusal_of(far, options), ErrorCode::invalid_input);
    }
}

TEST_F(RendererSuite, ALevelOfACloudSendsItsFirstPointsAlone) {
    put(cloud_of(40));
    DrawOptions options = small;
    options.instances = {{{}, 7}, {{}, 1000}, {{}, 0}};  // the last one shows nothing and is not drawn
    const Frame frame = drawn(from_front, options);
    EXPECT_EQ(frame.points, 47u);
    EXPECT_EQ(frame.draw_calls, 2u);
    EXPECT_EQ(live_objects().buffer_bytes, 40u * 24u);
}

TEST_F(RendererSuite, DiscsOfAnySizeAreDrawn) {
    codec::Points cloud = cloud_of(20);
    for (const double radius : {0.0, 1e-300, 1e3, 1e300}) {
        cloud.levels[0].radius = radius;
        put(cloud);
        EXPECT_EQ(drawn().points, 20u) << radius;
        EXPECT_EQ(drawn({{0, 0, 0.5}, {3, 0, 0.5}, 45.0, {0, 0, 1}}).points, 20u) << radius;
    }
}

TEST_F(RendererSuite, EveryExposureIsADrawingOfTheScene) {
    put(textured());
    DrawOptions options = small;
    options.samples = 4;
    options.earlier = {from_front, from_front};
    const Frame frame = drawn(from_front, options);
    EXPECT_EQ(frame.draw_calls, 3u * 2u);
    EXPECT_EQ(frame.triangles, 3u * 4u);
}

TEST_F(RendererSuite, WhatOnlyAnEarlierMomentSeesIsDrawn) {
    put(content_of(testing::sphere(8), Shading::gouraud));
    DrawOptions options = small;
    options.samples = 4;
    options.earlier = {from_front};
    EXPECT_EQ(drawn(turned_away, options).draw_calls, 1u);
    EXPECT_EQ(drawn(from_front, options).draw_calls, 2u);
    options.earlier = {turned_away};
    EXPECT_EQ(drawn(from_front, options).draw_calls, 1u);
    EXPECT_EQ(drawn(turned_away, options).draw_calls, 0u);
}

TEST_F(RendererSuite, ExposuresNeedASampleEachAndViewsThatLookSomewhere) {
    DrawOptions options = small;
    options.samples = 2;
    options.earlier = {from_front, from_front};
    EXPECT_EQ(refusal_of(from_front, options), ErrorCode::invalid_input);
    options.samples = 4;
    options.earlier = {View{{0, 0, 1}, {0, 0, 1}, 45.0, {0, 0, 1}}};
    EXPECT_EQ(refusal_of(from_front, options), ErrorCode::invalid_input);
}

TEST_F(RendererSuite, OnlyImagesThatAMaterialShowsTakeTextures) {
    Decoded content = textured();
    content.images.push_back(image_of(64));  // of no material
    EXPECT_EQ(put(content).texture_bytes, 4u * 4u * 4u);
    EXPECT_EQ(live_objects().textures, 1);
    content.materials[1].emissive_texture.image = 0;  // the same once more
    content.materials[0].base_color_texture.image = 5;
    EXPECT_EQ(put(content).texture_bytes, 4u * 4u * 4u);
    EXPECT_EQ(drawn().draw_calls, 2u);
}

TEST_F(RendererSuite, ADamagedImageIsWarnedOfAndTakesNoTexture) {
    Decoded content = textured();
    content.images[0].bytes.assign(40, std::byte{7});
    const auto uploaded = renderer->upload(content);
    ASSERT_TRUE(uploaded) << uploaded.error().message;
    EXPECT_EQ(uploaded.warnings.size(), 1u);
    EXPECT_EQ(uploaded->texture_bytes, 0u);
    EXPECT_EQ(live_objects().textures, 0);
    EXPECT_EQ(drawn().draw_calls, 2u);
}

TEST_F(RendererSuite, RefusesPicturesWithoutPixelsAndTooLargeOnes) {
    const auto code = [&](const DrawOptions& options) { return refusal_of(from_front, options); };
    EXPECT_EQ(code({.width = 0, .height = 0}), ErrorCode::invalid_input);
    EXPECT_EQ(code({.width = 5, .height = 0}), ErrorCode::invalid_input);
    EXPECT_EQ(code({.width = 5, .height = 5, .samples = 0}), ErrorCode::invalid_input);
    EXPECT_EQ(code({.width = 5, .height = 5, .samples = 9}), ErrorCode::invalid_input);
    EXPECT_EQ(code({.width = 5, .height = 5, .frames = 0}), ErrorCode::invalid_input);
    EXPECT_EQ(code({.width = image::max_side + 1, .height = 1}), ErrorCode::limit_exceeded);
    EXPECT_EQ(code({.width = 4'000'000'000u, .height = 4'000'000'000u}), ErrorCode::limit_exceeded);
    EXPECT_EQ(code({.width = image::max_side, .height = image::max_side}), ErrorCode::limit_exceeded);
}

TEST_F(RendererSuite, RefusesAViewThatLooksNowhere) {
    EXPECT_EQ(refusal_of({{1, 1, 1}, {1, 1, 1}, 45, {0, 0, 1}}, small), ErrorCode::invalid_input);
    EXPECT_EQ(refusal_of({{NAN, 1, 1}, {0, 0, 0}, 45, {0, 0, 1}}, small), ErrorCode::invalid_input);
}

TEST_F(RendererSuite, RefusesMoreLightsThanTheLimitAndLightsFromNowhere) {
    DrawOptions options = small;
    options.lights.assign(max_lights, {});
    put(textured());
    drawn(from_front, options);
    options.lights.assign(max_lights + 1, {});
    EXPECT_EQ(refusal_of(from_front, options), ErrorCode::limit_exceeded);
    for (const Light& light : {Light{{0, 0, 0}, 1.0}, Light{{NAN, 0, 0}, 1.0}, Light{{0, 1, 0}, -1.0}}) {
        options.lights = {light};
        EXPECT_EQ(refusal_of(from_front, options), ErrorCode::invalid_input);
    }
}

// The fake names every number that is not finite, of a vertex or of a uniform.
TEST_F(RendererSuite, BrokenAttributesAndFacesWithoutAreaAreDrawn) {
    mesh::Mesh broken = square();
    broken.normals[0] = Vec3f{NAN, 0, INFINITY};
    broken.normals[1] = Vec3f{0.0f};
    broken.texture_coordinates[1] = Vec2f{INFINITY, NAN};
    broken.triangles.push_back({3, 3, 3});
    broken.triangles.push_back({0, 1, 1});
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        Decoded content = content_of(broken, shading);
        content.materials[0].base_color_texture.image = 0;
        content.images.push_back(image_of(2));
        put(content);
        EXPECT_EQ(drawn().triangles, 4u);
        put(*movable_level(content));
        EXPECT_EQ(drawn().triangles, 2u);  // those of fewer than three positions are left out
    }
    mesh::Mesh point = square();
    point.positions.assign(4, Vec3f{1, 1, 1});
    put(content_of(point, Shading::flat));
    drawn();
    codec::Points cloud = cloud_of(3);
    cloud.cloud.positions.assign(3, Vec3f{1, 1, 1});
    cloud.cloud.normals[1] = Vec3f{NAN};
    put(cloud);
    EXPECT_EQ(drawn().points, 3u);
}

TEST_F(RendererSuite, ExtentsFromTinyToHugeAndFarOriginsAreDrawn) {
    for (const float scale : {1e-30f, 1e-9f, 1e9f, 1e30f}) {
        mesh::Mesh sphere = testing::sphere(8);
        for (Vec3f& p : sphere.positions) p *= scale;
        for (const Shading shading : {Shading::flat, Shading::gouraud}) {
            Decoded content = content_of(sphere, shading);
            content.origin = {1e7, -1e7, 3e6};
            if (scale < 1.0f) content.origin = Vec3d{0.0};
            put(content);
            EXPECT_EQ(drawn(shading::framing_view(world_bounds(content))).triangles, 112u) << scale;
        }
    }
}

TEST_F(RendererSuite, AnEyeInsideACloudOrOnAPointIsDrawn) {
    put(cloud_of(300));
    for (const Vec3d eye : {Vec3d(0, 0, 0), Vec3d(0, 0, 0.5), Vec3d(1, 0, 0.5), Vec3d(1e-9, 0, 0.5)})
        EXPECT_EQ(drawn({eye, {3, 0, 0}, 45.0, {0, 0, 1}}).points, 300u);
}

TEST_F(RendererSuite, AMovedRendererIsTheSameOneAndFreesTheOther) {
    put(textured());
    drawn();
    auto second = Renderer::create();
    ASSERT_TRUE(second);
    ASSERT_TRUE(second->upload(textured()));
    ASSERT_TRUE(second->upload(cloud_of(9)));
    const LiveObjects both = live_objects();
    *second = std::move(*renderer);
    EXPECT_LT(live_objects().buffers, both.buffers);
    EXPECT_EQ(live_objects().programs, both.programs / 2);
    renderer.emplace(*std::move(second));
    EXPECT_EQ(drawn().triangles, 4u);
}

TEST_F(RendererSuite, TwoRenderersInOneContextKeepToTheirOwn) {
    put(textured());
    {
        auto second = Renderer::create();
        ASSERT_TRUE(second);
        ASSERT_TRUE(second->upload(movable_sphere()));
        second->move_split(30);
        for (int i = 0; i < 2; ++i) {
            const auto frame = second->draw(from_front, {.width = 16, .height = 16});
            ASSERT_TRUE(frame) << frame.error().message;
            EXPECT_EQ(frame->triangles, 112u);
            EXPECT_EQ(drawn().triangles, 4u);
        }
    }
    EXPECT_EQ(drawn().triangles, 4u);
}

}  // namespace
}  // namespace lodestream::render
