// The renderer on drivers that are hard to come by: short of memory, old, small or unwilling. And what it draws, as the
// shaders read it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>

#include "client/render/renderer.h"
#include "tests/client/render/contents.h"
#include "tests/client/render/fake/recording_gl.h"
#include "tests/support/meshes.h"

namespace lodestream::render {
namespace {

using codec::Decoded;
using codec::Shading;
using shading::View;
using testing::content_of;
using ::testing::Each;
using testing::GlDraw;
using testing::GlDriver;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::RecordingGl;

const View from_front{{0, 0, 4}, {0, 0, 0}, 45.0, {0, 0, 1}};
const DrawOptions small{.width = 32, .height = 24, .samples = 1};

// A Gouraud sphere with an image, of two materials, and a flat one.
Decoded everything() {
    mesh::Mesh sphere = testing::sphere(8);
    sphere.texture_coordinates.assign(sphere.positions.size(), Vec2f{0.5f});
    sphere.colors.assign(sphere.positions.size(), Rgba8{255, 0, 0, 255});
    Decoded content = content_of(sphere, Shading::gouraud);
    content.images.push_back({"image/png", *encode_png(solid(32, 32, 9, 9, 9)), 32, 32});
    content.materials[0].base_color_texture.image = 0;
    content.materials.emplace_back().alpha_mode = mesh::AlphaMode::blend;
    sphere.normals.clear();
    content.primitives.push_back({Shading::flat, 1, sphere});
    return content;
}

codec::Points cloud() {
    codec::Points content;
    for (const float x : {-1.0f, 0.0f, 1.0f}) content.cloud.positions.emplace_back(x, 0.0f, 0.0f);
    content.levels = {{3, {}, 0.1}};
    return content;
}

class DriversTest : public ::testing::Test {
  protected:
    void create() {
        auto made = Renderer::create();
        ASSERT_TRUE(made) << made.error().message;
        renderer.emplace(*std::move(made));
    }

    // Nothing lives on, and nothing was wrong meanwhile.
    void TearDown() override {
        renderer.reset();
        EXPECT_EQ(gl.record().deleted, gl.record().created);
        EXPECT_EQ(gl.record().bytes, 0u);
        EXPECT_THAT(gl.record().misuses, IsEmpty());
    }

    // The draw calls of one frame.
    std::vector<GlDraw> draws_of(const View& view = from_front, const DrawOptions& options = small) {
        gl.record().draws.clear();
        const auto frame = renderer->draw(view, options);
        EXPECT_TRUE(frame) << frame.error().message;
        EXPECT_EQ(frame ? frame->draw_calls : 0, gl.record().draws.size());
        return std::exchange(gl.record().draws, {});
    }

    RecordingGl gl;
    std::optional<Renderer> renderer;
};

TEST_F(DriversTest, OutOfMemoryAnywhereInAnUploadLeavesNothingAndTheNextLevelFits) {
    create();
    const std::uint64_t empty = gl.record().bytes;
    ASSERT_TRUE(renderer->upload(everything()));
    const std::uint64_t whole = gl.record().bytes - empty;
    for (std::uint64_t left = 0; left < whole; left += 97) {
        gl.driver().memory_bytes = empty + left;
        const auto refused = renderer->upload(everything());
        ASSERT_FALSE(refused) << left;
        EXPECT_EQ(refused.error().code, ErrorCode::limit_exceeded);
        EXPECT_THAT(refused.error().message, HasSubstr("224 triangles"));
        EXPECT_EQ(gl.record().bytes, empty) << left;
    }
    gl.driver().memory_bytes = empty + whole;
    EXPECT_TRUE(renderer->upload(everything()));
    gl.driver().memory_bytes = GlDriver{}.memory_bytes;
    EXPECT_EQ(draws_of().size(), 2u);
}

TEST_F(DriversTest, TwoLevelsAreNeverOnTheGpuAtOnce) {
    create();
    const std::uint64_t empty = gl.record().bytes;
    ASSERT_TRUE(renderer->upload(everything()));
    const std::uint64_t one = gl.record().bytes;
    gl.driver().memory_bytes = one;
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(renderer->upload(everything()));
    EXPECT_EQ(gl.record().peak_bytes, one);
    ASSERT_TRUE(renderer->upload(Decoded{}));
    EXPECT_EQ(gl.record().bytes, empty);
}

TEST_F(DriversTest, MemoryForALevelButNotForThePicture) {
    create();
    ASSERT_TRUE(renderer->upload(everything()));
    const std::uint64_t level = gl.record().bytes;
    for (const std::uint64_t left :
         {0u, 4u * 32u * 24u, 2u * 4u * 4u * 32u * 24u}) {  // colour; depth; what is resolved
        gl.driver().memory_bytes = level + left;
        const auto refused = renderer->draw(from_front, {.width = 32, .height = 24, .samples = 4});
        ASSERT_FALSE(refused) << left;
        EXPECT_EQ(refused.error().code, ErrorCode::limit_exceeded);
        EXPECT_THAT(refused.error().message, HasSubstr("32x24"));
    }
    gl.driver().memory_bytes = level + 2 * 4 * 32 * 24;
    EXPECT_EQ(draws_of().size(), 2u);  // without samples of their own there is room
}

TEST_F(DriversTest, ShadersThatDoNotCompileOrLinkAreNamed) {
    for (const char* define : {"#define FLAT\n", "#define DISCS\n", "gl_FrontFacing", "gl_Position"}) {
        gl.driver().refused_shader = define;
        const auto made = Renderer::create();
        ASSERT_FALSE(made) << define;
        EXPECT_EQ(made.error().code, ErrorCode::internal);
        EXPECT_EQ(made.error().message, "shader: refused");
        EXPECT_EQ(gl.record().deleted, gl.record().created);
    }
    gl.driver().refused_shader.clear();
    gl.driver().links = false;
    const auto made = Renderer::create();
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().message, "shader program does not link");
}

TEST_F(DriversTest, AShaderThatOnlyALevelNeedsIsItsUploadsErrorAndTheNextOneIsDrawn) {
    create();
    gl.driver().refused_shader = "#define BASE_COLOR_IMAGE\n";
    const auto refused = renderer->upload(everything());
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::internal);
    EXPECT_EQ(refused.error().message, "shader: refused");
    EXPECT_EQ(gl.record().bytes, 0u);
    EXPECT_TRUE(draws_of().empty());
    ASSERT_TRUE(renderer->upload(content_of(testing::sphere(8), Shading::gouraud)));
    EXPECT_EQ(draws_of().size(), 1u);
}

TEST_F(DriversTest, AnOlderContextOrNoneIsUnavailable) {
    gl.driver().version = 20;
    const auto old = Renderer::create();
    ASSERT_FALSE(old);
    EXPECT_EQ(old.error().code, ErrorCode::unavailable);
    while (glGetError() != GL_NO_ERROR) continue;
}

TEST_F(DriversTest, FramebuffersThatADriverDoesNotCompleteAreAnErrorOfThePicture) {
    create();
    gl.driver().completes_framebuffers = false;
    const auto refused = renderer->draw(from_front, small);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::limit_exceeded);
    gl.driver().completes_framebuffers = true;
    EXPECT_TRUE(renderer->draw(from_front, small));
}

TEST_F(DriversTest, ErrorsOfOthersAreNotTheRenderers) {
    create();
    glActiveTexture(GL_TEXTURE0 + 31);
    EXPECT_TRUE(renderer->upload(everything()));
    glActiveTexture(GL_TEXTURE0 + 31);
    EXPECT_EQ(draws_of().size(), 2u);
    gl.record().misuses.clear();
}

TEST_F(DriversTest, SmallLimitsOfADriverAreKept) {
    gl.driver().max_side = 64;
    gl.driver().max_texture_side = 16;
    gl.driver().max_samples = 2;
    create();
    EXPECT_EQ(renderer->draw(from_front, {.width = 65, .height = 8}).error().code, ErrorCode::limit_exceeded);
    EXPECT_TRUE(renderer->draw(from_front, {.width = 64, .height = 64, .samples = 8}));  // with those that there are
    const auto uploaded = renderer->upload(everything());
    ASSERT_TRUE(uploaded);
    EXPECT_EQ(uploaded->texture_bytes, 0u);
    ASSERT_EQ(uploaded.warnings.size(), 1u);
    EXPECT_THAT(uploaded.warnings[0], HasSubstr("larger than the driver"));
}

TEST_F(DriversTest, WithoutSampleMasksExposuresAreUnsupportedAndOneMomentIsDrawn) {
    gl.driver().version = 30;
    create();
    ASSERT_TRUE(renderer->upload(everything()));
    DrawOptions options = small;
    options.samples = 4;
    EXPECT_EQ(draws_of(from_front, options).size(), 2u);
    options.earlier = {from_front};
    EXPECT_EQ(renderer->draw(from_front, options).error().code, ErrorCode::unsupported);
    EXPECT_EQ(draws_of().size(), 2u);
}

TEST_F(DriversTest, ExposuresShareTheSamplesBetweenThem) {
    create();
    ASSERT_TRUE(renderer->upload(content_of(testing::sphere(8), Shading::gouraud)));
    DrawOptions options = small;
    options.samples = 4;
    options.earlier = {from_front, from_front};
    const std::vector<GlDraw> draws = draws_of(from_front, options);
    ASSERT_EQ(draws.size(), 3u);
    EXPECT_EQ(draws[0].samples, 0b1001u);
    EXPECT_EQ(draws[1].samples, 0b0010u);
    EXPECT_EQ(draws[2].samples, 0b0100u);
    EXPECT_THAT(draws_of(), Each(::testing::Field(&GlDraw::samples, ~0u)));  // the mask does not outlive its frame
    options.earlier.assign(3, from_front);
    gl.driver().max_samples = 2;  // of a driver that has fewer than were asked for
    renderer.reset();
    create();
    EXPECT_EQ(renderer->draw(from_front, options).error().code, ErrorCode::unsupported);
}

TEST_F(DriversTest, DiscsAreWidenedForSamplesAndShadedByTheSampleWhereTheDriverCan) {
    DrawOptions options = small;
    options.samples = 4;
    for (const int version : {30, 31, 32}) {
        gl.driver().version = version;
        create();
        ASSERT_TRUE(renderer->upload(cloud()));
        const GlDraw many = draws_of(from_front, options).at(0), one = draws_of().at(0);
        EXPECT_EQ(many.shades_samples, version >= 32);
        EXPECT_EQ(many.uniforms.at("u_disc")[1], 1.0f);
        EXPECT_FALSE(one.shades_samples);
        EXPECT_EQ(one.uniforms.at("u_disc")[1], 0.0f);
        ASSERT_TRUE(renderer->upload(everything()));
        EXPECT_THAT(draws_of(from_front, options), Each(::testing::Field(&GlDraw::shades_samples, false)));
        renderer.reset();
    }
}

TEST_F(DriversTest, DiscsThatAreTooLargeForPointsOrLieAcrossTheEdgeAreQuads) {
    gl.driver().max_point_px = 9.0f;
    create();
    codec::Points discs = cloud();
    discs.cloud.normals.assign(3, Vec3f{0, 0, 1});
    ASSERT_TRUE(renderer->upload(discs));
    const auto is_quads = [](const GlDraw& draw) { return draw.mode == GL_TRIANGLE_STRIP; };
    const View far{{0, 0, 8}, {0, 0, 0}, 45.0, {0, 0, 1}};
    DrawOptions options = small;
    options.width = options.height = 128;  // 4 px across at a distance of 8, 9 px at that of 4
    EXPECT_FALSE(is_quads(draws_of(far, options).at(0)));
    options.instances = {{{0, 0, 0}}, {{0, 0, 5}}, {{0, 0, -5}}};
    const std::vector<GlDraw> draws = draws_of(far, options);
    ASSERT_EQ(draws.size(), 3u);
    EXPECT_EQ(std::count_if(draws.begin(), draws.end(), is_quads), 1);
    const GlDraw& quads = draws[2];  // points first
    ASSERT_TRUE(is_quads(quads));
    EXPECT_EQ(quads.count, 4);
    EXPECT_EQ(quads.instances, 3);
    EXPECT_EQ(quads.vertices, draws[0].vertices);  // read once a disc instead of once a corner
    EXPECT_EQ(quads.uniforms.at("u_offset")[2], 5.0f);
    EXPECT_EQ(draws_of(far, options), draws);  // points are read once a point again
    gl.driver().max_point_px = 255.0f;
    renderer.reset();
    create();
    ASSERT_TRUE(renderer->upload(discs));
    options.instances = {{{0, 0, 4}}};
    EXPECT_FALSE(is_quads(draws_of({{0, 0, 12}, {0, 0, 0}, 45.0, {0, 0, 1}}, options).at(0)));
    options.instances = {{{2.5, 0, 4}}};  // across the edge
    EXPECT_TRUE(is_quads(draws_of({{0, 0, 12}, {0, 0, 0}, 45.0, {0, 0, 1}}, options).at(0)));
}

TEST_F(DriversTest, WhatIsDrawnIsTheLevelWithItsMaterials) {
    create();
    ASSERT_TRUE(renderer->upload(everything()));
    const std::vector<GlDraw> draws = draws_of();
    ASSERT_EQ(draws.size(), 2u);
    EXPECT_FALSE(draws[0].blends);
    EXPECT_TRUE(draws[0].writes_depth);
    EXPECT_TRUE(draws[1].blends);
    EXPECT_FALSE(draws[1].writes_depth);
    for (const GlDraw& draw : draws) {
        EXPECT_TRUE(draw.tests_depth);
        EXPECT_EQ(draw.count, 3 * 112);
        EXPECT_THAT(draw.vertices.at("a_color"), Each(Vec4f(1, 0, 0, 1)));
        for (const Vec4f& p : draw.vertices.at("a_position")) EXPECT_LE(length(Vec3f(p)), 1.0f + 1e-6f);
    }
    EXPECT_TRUE(draws[0].uniforms.contains("u_base_color_texture"));
    EXPECT_NE(draws[0].textures[0], 0u);
}

// What a material does not have, its program does not read.
TEST_F(DriversTest, ProgramsReadWhatTheMaterialHasAndNothingElse) {
    create();
    const auto reads = [&](const Decoded& content, const char* what) {
        EXPECT_TRUE(renderer->upload(content)) << what;
        const GlDraw draw = draws_of().at(0);
        return draw.uniforms.contains(what) || draw.vertices.contains(what);
    };
    for (const Shading shading : {Shading::gouraud, Shading::flat}) {
        Decoded content = content_of(testing::sphere(8), shading);
        for (const char* what :
             {"u_base_color_texture", "u_emissive_texture", "a_texture_coordinate", "a_color", "u_alpha_cutoff"})
            EXPECT_FALSE(reads(content, what)) << what;
        content.materials[0].alpha_mode = mesh::AlphaMode::mask;
        EXPECT_TRUE(reads(content, "u_alpha_cutoff"));
        mesh::Mesh& mesh = content.primitives[0].mesh;
        mesh.colors.assign(mesh.positions.size(), Rgba8{1, 2, 3, 255});
        EXPECT_TRUE(reads(content, "a_color"));
        mesh.texture_coordinates.assign(mesh.positions.size(), Vec2f{0.5f});
        EXPECT_FALSE(reads(content, "a_texture_coordinate"));
        content.images.push_back({"image/png", *encode_png(solid(8, 8, 9, 9, 9)), 8, 8});
        content.materials[0].emissive_texture.image = 0;
        EXPECT_TRUE(reads(content, "a_texture_coordinate"));
        EXPECT_TRUE(reads(content, "u_emissive_texture"));
        EXPECT_FALSE(reads(content, "u_base_color_texture"));
        content.images[0].bytes.assign(40, std::byte{7});  // damaged: not there
        EXPECT_FALSE(reads(content, "u_emissive_texture"));
        EXPECT_FALSE(reads(content, "a_texture_coordinate"));
    }
}

// A flat face is lit at its last corner, which needs the other two; whoever drives it may take no other for them.
TEST_F(DriversTest, EveryFlatFaceFindsItsCornersAtTheProvokingVertex) {
    create();
    mesh::Mesh mesh = testing::grid(5, [](double x, double z) { return std::sin(x) * z; });
    ASSERT_TRUE(renderer->upload(content_of(mesh, Shading::flat)));
    const View view = shading::framing_view(world_bounds(content_of(mesh, Shading::flat)));
    const GlDraw draw = draws_of(view).at(0);
    const auto& positions = draw.vertices.at("a_position");
    ASSERT_EQ(positions.size(), 150u);
    for (std::size_t corner = 0; corner < positions.size(); corner += 3) {
        EXPECT_EQ(draw.vertices.at("a_first_corner")[corner + 2], positions[corner]);
        EXPECT_EQ(draw.vertices.at("a_previous_corner")[corner + 2], positions[corner + 1]);
    }
}

TEST_F(DriversTest, AMovedBorderDrawsEveryTriangleOnceAndUploadsNothing) {
    create();
    const MovableLevel level = *movable_level(content_of(testing::sphere(8), Shading::gouraud));
    ASSERT_TRUE(renderer->upload(level));
    std::vector<Vec4f> all = draws_of().at(0).vertices.at("a_position");
    const std::uint64_t uploads = gl.record().uploads;
    for (const std::uint64_t gouraud : {std::uint64_t{1}, std::uint64_t{40}, std::uint64_t{111}}) {
        renderer->move_split(gouraud);
        const std::vector<GlDraw> draws = draws_of();
        ASSERT_EQ(draws.size(), 2u);
        EXPECT_EQ(draws[0].count, static_cast<GLsizei>(3 * gouraud));
        EXPECT_EQ(draws[1].count, static_cast<GLsizei>(3 * (112 - gouraud)));
        EXPECT_TRUE(draws[1].vertices.contains("a_first_corner"));
        const auto& smooth = draws[0].vertices.at("a_position");
        EXPECT_TRUE(std::equal(smooth.begin(), smooth.end(), all.begin()));  // a prefix, in the same order
        Vec4f sum{0.0f};
        for (const GlDraw& draw : draws)
            for (const Vec4f& p : draw.vertices.at("a_position")) sum += p;
        for (const Vec4f& p : all) sum -= p;
        EXPECT_NEAR(length(Vec3f(sum)), 0.0f, 1e-4f);
    }
    EXPECT_EQ(gl.record().uploads, uploads);
}

TEST_F(DriversTest, TwoRenderersDrawTheSameSideBySideAsAlone) {
    create();
    ASSERT_TRUE(renderer->upload(everything()));
    DrawOptions options = small;
    options.samples = 4;
    const std::vector<GlDraw> alone = draws_of(from_front, options);
    auto second = Renderer::create();
    ASSERT_TRUE(second);
    ASSERT_TRUE(second->upload(cloud()));
    options.earlier = {from_front};
    ASSERT_TRUE(second->draw(from_front, options));
    options.earlier.clear();
    EXPECT_EQ(draws_of(from_front, options), alone);
    ASSERT_TRUE(second->draw(from_front, options));  // without normals: those of the constant attribute
    EXPECT_EQ(draws_of(from_front, options), alone);
}

TEST_F(DriversTest, ACloudWithoutNormalsReadsNoneOfAnother) {
    create();
    codec::Points facing = cloud();
    facing.cloud.normals.assign(3, Vec3f{0, 0, 1});
    ASSERT_TRUE(renderer->upload(facing));
    EXPECT_THAT(draws_of().at(0).vertices.at("a_normal"), Each(Vec4f(0, 0, 1, 1)));
    ASSERT_TRUE(renderer->upload(cloud()));
    EXPECT_THAT(draws_of().at(0).vertices.at("a_normal"), Each(Vec4f(0, 0, 0, 1)));
}

TEST_F(DriversTest, ContextsInTurnKeepTheirObjectsApart) {
    create();
    ASSERT_TRUE(renderer->upload(everything()));
    {
        RecordingGl other;
        auto second = Renderer::create();
        ASSERT_TRUE(second);
        ASSERT_TRUE(second->upload(cloud()));
        ASSERT_TRUE(second->draw(from_front, small));
        EXPECT_THAT(other.record().misuses, IsEmpty());
    }
    EXPECT_EQ(Renderer::create().error().code, ErrorCode::unavailable);  // no context is current
    gl.make_current();
    EXPECT_EQ(draws_of().size(), 2u);
}

constexpr double cube_side = 4.0;
const Box cube{Vec3d{-cube_side / 2.0}, Vec3d{cube_side / 2.0}};

Part part_of(const Decoded& content) {
    auto part = prepare(content, cube);
    EXPECT_TRUE(part) << part.error().message;
    return part ? *std::move(part) : Part{};
}

// At every byte where it may run out: what was there is drawn as before, and nothing of the other is left.
TEST_F(DriversTest, APartThatDoesNotFitLeavesTheSceneAsItWas) {
    create();
    ASSERT_TRUE(renderer->begin_scene(cube));
    const auto first = renderer->add(part_of(content_of(testing::sphere(6), Shading::flat)));
    ASSERT_TRUE(first);
    DrawOptions options = small;
    options.parts = {{*first, {}}};
    const std::vector<GlDraw> before = draws_of(from_front, options);
    const std::uint64_t bytes = gl.record().bytes;
    const Part other = part_of(everything());
    bool refused = false;
    for (std::uint64_t more = 0; more < 64'000; more += 997) {
        gl.driver().memory_bytes = bytes + more;
        const auto added = renderer->add(other);
        if (!added) {
            EXPECT_EQ(added.error().code, ErrorCode::limit_exceeded);
            refused = true;
        } else {
            renderer->remove(*added);
        }
        EXPECT_EQ(gl.record().bytes, bytes) << more;
    }
    EXPECT_TRUE(refused);
    EXPECT_EQ(draws_of(from_front, options), before);
}

// Both see the same pattern, and their thresholds meet: no sample is left out and none has both.
TEST_F(DriversTest, LevelsThatFadeIntoEachOtherAreToldWhereTheirThresholdsMeet) {
    for (const int version : {30, 32}) {
        gl.driver().version = version;
        create();
        ASSERT_TRUE(renderer->begin_scene(cube));
        const auto going = renderer->add(part_of(content_of(testing::sphere(8), Shading::gouraud)));
        const auto coming = renderer->add(part_of(content_of(testing::sphere(6), Shading::flat)));
        ASSERT_TRUE(going && coming);
        DrawOptions options = small;
        options.samples = 4;
        for (const double share : {0.0, 0.1, 1.0 / 3.0, 0.5, 0.999, 1.0}) {
            options.parts = {{*coming, {0.0, share}}, {*going, {share, 1.0}}};
            std::vector<std::vector<float>> shares;
            for (const GlDraw& draw : draws_of(from_front, options))
                if (const auto found = draw.uniforms.find("u_share"); found != draw.uniforms.end())
                    shares.push_back(found->second);
            if (share == 0.0 || share == 1.0) {
                EXPECT_TRUE(shares.empty()) << share;  // one of both is not drawn, the other whole
                continue;
            }
            ASSERT_EQ(shares.size(), 2u) << share;
            const auto [low, high] = std::minmax(shares[0], shares[1]);
            EXPECT_EQ(low[0], 0.0f);
            EXPECT_EQ(low[1], high[0]) << share;
            EXPECT_EQ(low[2], version >= 32 ? 4.0f : 1.0f);
            EXPECT_EQ(high[1], 64.0f * high[2]);
        }
        renderer.reset();
    }
}

TEST_F(DriversTest, PartsOfAnotherSceneAndWholeSceneGoWithoutATrace) {
    create();
    const std::uint64_t bytes = gl.record().bytes;
    ASSERT_TRUE(renderer->begin_scene(cube));
    ASSERT_TRUE(renderer->add(part_of(everything())));
    ASSERT_TRUE(renderer->begin_scene({Vec3d{-1.0}, Vec3d{1.0}}));
    EXPECT_EQ(gl.record().bytes, bytes);
    EXPECT_FALSE(renderer->add(part_of(everything())));  // prepared for the scene before
    EXPECT_FALSE(renderer->begin_scene({}));
    EXPECT_EQ(gl.record().bytes, bytes);
}

}  // namespace
}  // namespace lodestream::render
