#include "client/render/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/client/render/contents.h"
#include "tests/client/render/with_renderer.h"
#include "tests/support/meshes.h"

namespace lodestream::render {
namespace {

using codec::Decoded;
using codec::Shading;
using shading::View;
using testing::content_of;
using testing::square;

const View from_front{{0, 0, 4}, {0, 0, 0}, 45.0, {0, 0, 1}};
const DrawOptions small{.width = 96, .height = 96, .samples = 1};

double to_srgb(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    return 255.0 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055);
}

class RendererTest : public testing::WithRenderer {
  protected:
    Image picture(const Decoded& content, const View& view, const DrawOptions& options = small) {
        const auto uploaded = renderer->upload(content);
        EXPECT_TRUE(uploaded) << uploaded.error().message;
        const auto frame = renderer->draw(view, options);
        EXPECT_TRUE(frame) << frame.error().message;
        return frame ? frame->image : Image{};
    }
};

const std::uint8_t* pixel(const Image& image, std::uint32_t x, std::uint32_t y) {
    return &image.rgba[(std::size_t{y} * image.width + x) * 4];
}

std::size_t covered(const Image& image, std::uint8_t background = 255) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        if (image.rgba[i] != background || image.rgba[i + 1] != background || image.rgba[i + 2] != background) ++count;
    return count;
}

double rms_between(const Image& a, const Image& b) {
    const auto difference = compare(a, b);
    EXPECT_TRUE(difference);
    return difference ? difference->rms : 1e9;
}

// Around (0,0,0) in the plane z = 0, facing +z.
mesh::Mesh facing_triangle() {
    mesh::Mesh m;
    m.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 2, 0}};
    m.normals.assign(3, Vec3f{0, 0, 1});
    m.triangles = {{0, 1, 2}};
    return m;
}

mesh::Mesh bumpy_grid(std::uint32_t n) {
    mesh::Mesh m = testing::grid(n, [](double x, double z) { return 0.7 * std::sin(x * 1.3) * std::cos(z * 0.9); });
    m.normals.assign(m.positions.size(), Vec3f{0, 1, 0});
    return m;
}

mesh::Mesh scaled(mesh::Mesh m, float scale) {
    for (Vec3f& p : m.positions) p *= scale;
    return m;
}

View view_of(const Decoded& content) {
    return shading::framing_view(world_bounds(content));
}

mesh::Image png_of(const Image& image) {
    auto png = encode_png(image);
    EXPECT_TRUE(png);
    return {"image/png", *png, image.width, image.height};
}

TEST_F(RendererTest, TriangleLitHeadOnHasPhongsSumInSrgb) {
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        const Image image = picture(content_of(facing_triangle(), shading), from_front);
        // Ambient and diffuse on the grey base; the highlight of the flat face, looked at and lit along its normal, is
        // whole.
        const double specular = shading == Shading::flat ? 0.25 : 0.25 * std::pow(4 / std::sqrt(18.0), 16.0);
        if (shading == Shading::flat)
            EXPECT_NEAR(pixel(image, 48, 48)[0], to_srgb(0.5 + specular), 1.0);
        else
            EXPECT_GT(pixel(image, 48, 48)[0], to_srgb(0.5));
        EXPECT_LE(pixel(image, 48, 48)[0], to_srgb(0.75) + 1.0);
        EXPECT_EQ(pixel(image, 48, 48)[3], 255);
    }
}

TEST_F(RendererTest, LightAtSixtyDegreesGivesHalfTheDiffuse) {
    View view = from_front;
    view.light = {std::sqrt(3.0), 0, 1};
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        const Image image = picture(content_of(facing_triangle(), shading, Vec4f{0.8f, 0.4f, 0.2f, 1.0f}), view);
        for (int c = 0; c < 3; ++c) {
            const double base = std::array{0.8, 0.4, 0.2}[static_cast<std::size_t>(c)];
            EXPECT_NEAR(pixel(image, 48, 48)[c], to_srgb(base * (0.25 + 0.75 * 0.5)), 1.0);
        }
    }
}

TEST_F(RendererTest, LightFromBehindLeavesTheAmbientPart) {
    View view = from_front;
    view.light = {0, 0, -1};
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        const Image image = picture(content_of(facing_triangle(), shading), view);
        EXPECT_NEAR(pixel(image, 48, 48)[0], to_srgb(0.5 * 0.25), 1.0);
    }
}

TEST_F(RendererTest, PhongConstantsAreTheCallers) {
    DrawOptions options = small;
    options.phong = {.ambient = 0.1, .diffuse = 0.3, .specular = 0.0, .shininess = 4.0};
    const Image image = picture(content_of(facing_triangle(), Shading::flat), from_front, options);
    EXPECT_NEAR(pixel(image, 48, 48)[0], to_srgb(0.5 * 0.4), 1.0);
}

TEST_F(RendererTest, FlatFacetHasOneColour) {
    View view = from_front;
    view.light = {0.3, 0.4, 1};
    const Image image = picture(content_of(facing_triangle(), Shading::flat), view);
    std::set<std::array<std::uint8_t, 3>> colors;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        colors.insert({image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]});
    EXPECT_EQ(colors.size(), 2u);  // the face and the background
}

TEST_F(RendererTest, EachFlatFaceIsLitByItsOwnNormal) {
    mesh::Mesh roof;  // two faces that share an edge and its vertices
    roof.positions = {{0, -1, 1}, {0, 1, 1}, {-1, 0, 0}, {1, 0, 0}};
    roof.triangles = {{0, 1, 2}, {1, 0, 3}};
    View view = from_front;
    view.light = {1, 0, 1};
    const DrawOptions no_highlight{.width = 96, .height = 96, .samples = 1, .phong = {.specular = 0.0}};
    const Image image = picture(content_of(roof, Shading::flat), view, no_highlight);
    EXPECT_NEAR(pixel(image, 40, 48)[0], to_srgb(0.5 * 0.25), 1.0);  // turned away from the light by 90°
    EXPECT_NEAR(pixel(image, 56, 48)[0], to_srgb(0.5), 1.0);         // towards it
}

TEST_F(RendererTest, GouraudSphereIsNearerToTheFineOneThanTheFlatSphere) {
    const mesh::Mesh coarse = testing::sphere(24);
    const Decoded smooth = content_of(coarse, Shading::gouraud), flat = content_of(coarse, Shading::flat);
    const Decoded fine = content_of(testing::sphere(128), Shading::gouraud);
    View close = view_of(fine);  // the surface fills the picture, so that no outline counts
    close.eye *= 0.5;
    close.fov_y_deg = 20.0;
    const Image truth = picture(fine, close);
    ASSERT_EQ(covered(truth), truth.pixels());
    EXPECT_LT(2.0 * rms_between(picture(smooth, close), truth), rms_between(picture(flat, close), truth));
}

TEST_F(RendererTest, BorderBetweenGouraudAndFlatPrimitivesHasNoCracks) {
    mesh::Model model;
    model.mesh = bumpy_grid(24);
    std::vector<std::uint8_t> alternating(model.mesh.triangles.size());
    for (std::size_t t = 0; t < alternating.size(); ++t) alternating[t] = static_cast<std::uint8_t>((t / 3) % 2);
    const Decoded whole = drawable(model, model.mesh), split = drawable(model, model.mesh, alternating);
    ASSERT_EQ(split.primitives.size(), 2u);
    View view = view_of(whole);
    view.eye = view.target + (view.eye - view.target) * 0.8;
    const DrawOptions options{.width = 400, .height = 300, .samples = 1, .background = {1, 0, 1}};
    const Image a = picture(whole, view, options), b = picture(split, view, options);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
        const bool drawn_a = a.rgba[i + 1] != 0, drawn_b = b.rgba[i + 1] != 0;
        EXPECT_EQ(drawn_a, drawn_b) << "pixel " << i / 4;
        inside += drawn_a ? 1 : 0;
    }
    EXPECT_GT(inside, 10'000u);
}

TEST_F(RendererTest, FacesAreLitFromBothSides) {
    View behind = from_front;
    behind.eye = {0, 0, -4};
    behind.light = {0, 0, -1};
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        const Image front = picture(content_of(facing_triangle(), shading), from_front);
        const Image back = picture(content_of(facing_triangle(), shading), behind);
        EXPECT_NEAR(pixel(front, 48, 48)[0], pixel(back, 48, 48)[0], 1.0);
        EXPECT_GT(pixel(back, 48, 48)[0], to_srgb(0.5));
    }
}

TEST_F(RendererTest, TwoHalfLightsFromOnePlaceShineLikeOne) {
    DrawOptions options = small;
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        const Decoded content = content_of(testing::sphere(16), shading);
        options.lights.clear();
        const Image one = picture(content, view_of(content), options);
        options.lights.assign(2, {view_of(content).light, 0.5});
        EXPECT_LT(rms_between(one, picture(content, view_of(content), options)), 0.1);
        options.lights.assign(max_lights, {view_of(content).light, 1.0 / max_lights});
        EXPECT_LT(rms_between(one, picture(content, view_of(content), options)), 0.1);
    }
}

TEST_F(RendererTest, LightsAddUpAndReplaceTheViewsLight) {
    DrawOptions options = small;
    options.phong.specular = 0.0;
    options.lights = {{{0, 0, 1}, 0.5}, {{0, 0, -1}, 1.0}, {{0, 0, 7}, 0.25}};  // the second shines on the other side
    View view = from_front;
    view.light = {0, 0, -1};
    for (const Shading shading : {Shading::flat, Shading::gouraud})
        EXPECT_NEAR(pixel(picture(content_of(facing_triangle(), shading), view, options), 48, 48)[0],
                    to_srgb(0.5 * (0.25 + 0.75 * 0.75)), 1.0);
}

TEST_F(RendererTest, FlatSharesVerticesWithoutMixingFacesColoursOrCorners) {
    mesh::Mesh grid = bumpy_grid(12);
    for (std::size_t v = 0; v < grid.positions.size(); ++v)
        grid.colors.emplace_back(37 * v % 256, 91 * v % 256, 53 * v % 256, 255);
    mesh::Mesh apart;  // the same faces with corners of their own
    for (const mesh::Triangle& t : grid.triangles)
        for (const std::uint32_t v : t) {
            apart.positions.push_back(grid.positions[v]);
            apart.colors.push_back(grid.colors[v]);
        }
    for (std::uint32_t t = 0; t < grid.triangles.size(); ++t) apart.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    const Decoded shared = content_of(grid, Shading::flat), own = content_of(apart, Shading::flat);
    EXPECT_LT(rms_between(picture(shared, view_of(shared)), picture(own, view_of(shared))), 0.2);
    EXPECT_EQ(renderer->upload(own)->flat_vertices, 3u * 288u);
    EXPECT_EQ(renderer->upload(shared)->flat_vertices, 288u);
}

TEST_F(RendererTest, WindingAgainstTheNormalsDoesNotTurnTheLightOff) {
    mesh::Mesh turned = testing::sphere(16);
    for (std::size_t t = 0; t < turned.triangles.size(); t += 2)
        std::swap(turned.triangles[t][1], turned.triangles[t][2]);
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        const Decoded straight = content_of(testing::sphere(16), shading);
        EXPECT_LT(
            rms_between(picture(straight, view_of(straight)), picture(content_of(turned, shading), view_of(straight))),
            0.5);
    }
}

TEST_F(RendererTest, NearerFaceHidesTheFartherOneWhateverTheOrder) {
    for (const bool near_first : {true, false}) {
        Decoded content;
        content.materials.resize(2);
        content.materials[0].base_color = {1, 0, 0, 1};
        content.materials[1].base_color = {0, 0, 1, 1};
        content.primitives.push_back({Shading::gouraud, near_first ? 0u : 1u, square(near_first ? 0.5f : -0.5f)});
        content.primitives.push_back({Shading::flat, near_first ? 1u : 0u, square(near_first ? -0.5f : 0.5f)});
        View view = from_front;
        view.light = {1, 0, 0.2};
        const Image image = picture(content, view);
        EXPECT_GT(pixel(image, 48, 48)[0], pixel(image, 48, 48)[2]);
    }
}

TEST_F(RendererTest, FarOriginGivesTheSamePicture) {
    Decoded content = content_of(testing::sphere(24), Shading::gouraud);
    content.primitives.push_back({Shading::flat, 0, bumpy_grid(3)});
    content.primitives[1].mesh.normals.clear();
    const Image near = picture(content, view_of(content));
    content.origin = {1e7, -1e7, 3e6};
    const Image far = picture(content, view_of(content));
    EXPECT_LT(rms_between(near, far), 0.2);
    EXPECT_GT(covered(far), 500u);
}

TEST_F(RendererTest, ExtentsFromTinyToHugeGiveTheSamePicture) {
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        const Decoded unit = content_of(testing::sphere(24), shading);
        const Image expected = picture(unit, view_of(unit));
        for (const float scale : {1e-9f, 1e9f, 1e-30f, 1e30f}) {
            const Decoded content = content_of(scaled(testing::sphere(24), scale), shading);
            EXPECT_LT(rms_between(expected, picture(content, view_of(content))), 0.2) << scale;
        }
    }
}

TEST_F(RendererTest, DetailFarFromTheCentreOfAHugeSceneIsSharp) {
    Decoded content = content_of(testing::sphere(24), Shading::gouraud);
    const Image alone = picture(content, view_of(content));
    const View view = view_of(content);
    mesh::Mesh faraway = facing_triangle();
    for (Vec3f& p : faraway.positions) p += Vec3f{2000, 0, 0};
    content.primitives.push_back({Shading::flat, 0, faraway});
    content.primitives[1].mesh.normals.clear();
    EXPECT_LT(rms_between(alone, picture(content, view)), 3.0);
}

TEST_F(RendererTest, ZeroNormalsAndFacesWithoutAreaStayFinite) {
    mesh::Mesh m = facing_triangle();
    m.normals.assign(3, Vec3f{0.0f});
    m.positions.push_back({3, 3, 0});
    m.normals.push_back({0, 0, 0});
    m.triangles.push_back({3, 3, 3});
    m.triangles.push_back({0, 1, 1});
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        const Image image = picture(content_of(m, shading), from_front);
        EXPECT_GE(pixel(image, 48, 48)[0] + 1.0, to_srgb(0.5 * 0.25));
        EXPECT_GT(covered(image), 100u);
    }
}

TEST_F(RendererTest, NonFiniteNormalsAndTextureCoordinatesCountAsZero) {
    mesh::Mesh m = square();
    m.normals[0] = Vec3f{NAN, 0, INFINITY};
    m.texture_coordinates[1] = Vec2f{INFINITY, NAN};
    const Image image = picture(content_of(m, Shading::gouraud), from_front);
    EXPECT_GE(pixel(image, 48, 48)[0] + 1.0, to_srgb(0.5 * 0.25));
}

TEST_F(RendererTest, CameraInsideSeesTheInnerSideAllAround) {
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        const View inside{{0, 0, 0}, {1, 0.2, 0.3}, 90.0, {0.3, 1, 0.5}};
        const Image image = picture(content_of(testing::sphere(16), shading), inside);
        EXPECT_EQ(covered(image), image.pixels());
    }
}

TEST_F(RendererTest, LooksStraightUpAndDown) {
    for (const double y : {4.0, -4.0}) {
        const Image image =
            picture(content_of(testing::sphere(16), Shading::gouraud), {{0, y, 0}, {0, 0, 0}, 45, {0, 1, 0}});
        EXPECT_GT(covered(image), 1000u);
    }
}

TEST_F(RendererTest, LevelOfOnePointDrawsNothingAndDoesNotDivideByZero) {
    mesh::Mesh m;
    m.positions.assign(3, Vec3f{1, 1, 1});
    m.triangles = {{0, 1, 2}};
    EXPECT_EQ(covered(picture(content_of(m, Shading::flat), from_front)), 0u);
}

TEST_F(RendererTest, BackgroundIsLinearAndTheCallers) {
    DrawOptions options = small;
    options.background = {0.5f, 0.0f, 1.0f};
    const Image image = picture(Decoded{}, from_front, options);
    EXPECT_NEAR(pixel(image, 0, 0)[0], to_srgb(0.5), 1.0);
    EXPECT_EQ(pixel(image, 0, 0)[1], 0);
    EXPECT_EQ(pixel(image, 0, 0)[2], 255);
}

TEST_F(RendererTest, VeryWidePictureIsDrawnOrRefusedWithAReason) {
    ASSERT_TRUE(renderer->upload(content_of(testing::sphere(8), Shading::gouraud)));
    const auto frame = renderer->draw(from_front, {.width = 16'384, .height = 16, .samples = 4});
    if (frame) {
        EXPECT_EQ(frame->image.width, 16'384u);
        EXPECT_GT(covered(frame->image), 50u);
    } else {
        EXPECT_EQ(frame.error().code, ErrorCode::limit_exceeded);
    }
}

TEST_F(RendererTest, MultisamplingSoftensTheOutlineAndKeepsTheInside) {
    const Decoded content = content_of(facing_triangle(), Shading::flat);
    DrawOptions options = small;
    const Image hard = picture(content, from_front, options);
    options.samples = 4;
    const Image soft = picture(content, from_front, options);
    std::set<std::uint8_t> levels_hard, levels_soft;
    for (std::size_t i = 0; i < hard.rgba.size(); i += 4) {
        levels_hard.insert(hard.rgba[i]);
        levels_soft.insert(soft.rgba[i]);
    }
    EXPECT_EQ(levels_hard.size(), 2u);
    EXPECT_GT(levels_soft.size(), 2u);
    EXPECT_EQ(pixel(hard, 48, 48)[0], pixel(soft, 48, 48)[0]);
}

TEST_F(RendererTest, SizesAndSamplesMayChangeBetweenFrames) {
    ASSERT_TRUE(renderer->upload(content_of(testing::sphere(8), Shading::gouraud)));
    for (const std::uint32_t side : {8u, 300u, 3u})
        for (const std::uint32_t samples : {4u, 1u}) {
            const auto frame =
                renderer->draw(from_front, {.width = side, .height = side, .samples = samples, .frames = 3});
            ASSERT_TRUE(frame);
            EXPECT_EQ(frame->image.rgba.size(), std::size_t{side} * side * 4);
            EXPECT_GT(covered(frame->image), 0u) << side << " px, " << samples << " samples";
        }
}

TEST_F(RendererTest, TextureIsUprightAndDecodedFromSrgb) {
    Image texture = solid(2, 2, 255, 255, 255);  // upper left red, upper right green, lower left blue, lower right grey
    const std::array<std::array<std::uint8_t, 3>, 4> colors{{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {128, 128, 128}}};
    for (std::size_t i = 0; i < 4; ++i)
        std::copy(colors[i].begin(), colors[i].end(), texture.rgba.begin() + static_cast<std::ptrdiff_t>(i * 4));
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        Decoded content = content_of(square(), shading, Vec4f{1.0f});
        content.images.push_back(png_of(texture));
        content.materials[0].base_color_texture = {0, mesh::Wrap::clamp_to_edge, mesh::Wrap::clamp_to_edge};
        DrawOptions options = small;
        options.phong = {.ambient = 1.0, .diffuse = 0.0, .specular = 0.0};
        const Image image = picture(content, from_front, options);
        const std::array<std::array<std::uint32_t, 2>, 4> corners{{{24, 24}, {72, 24}, {24, 72}, {72, 72}}};
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(pixel(image, corners[i][0], corners[i][1])[c], colors[i][c], 2) << i << " " << c;
    }
}

TEST_F(RendererTest, DamagedTextureIsDrawnWhiteAndWarnedOf) {
    Decoded content = content_of(square(), Shading::gouraud, Vec4f{1.0f});
    content.images.push_back({"image/png", std::vector<std::byte>(40, std::byte{7}), 8, 8});
    content.materials[0].base_color_texture.image = 0;
    const auto uploaded = renderer->upload(content);
    ASSERT_TRUE(uploaded);
    ASSERT_EQ(uploaded.warnings.size(), 1u);
    const auto frame = renderer->draw(from_front, {.width = 8, .height = 8, .samples = 1, .background = {0, 0, 0}});
    ASSERT_TRUE(frame);
    EXPECT_EQ(pixel(frame->image, 4, 4)[0], 255);
}

TEST_F(RendererTest, TextureReferenceToAMissingImageIsWhite) {
    Decoded content = content_of(square(), Shading::flat, Vec4f{1.0f});
    content.materials[0].base_color_texture.image = 5;
    EXPECT_EQ(pixel(picture(content, from_front), 48, 48)[0], 255);
}

TEST_F(RendererTest, VertexColoursMultiplyTheBaseColour) {
    for (const Shading shading : {Shading::flat, Shading::gouraud}) {
        mesh::Mesh m = square();
        m.colors.assign(4, Rgba8{51, 255, 0, 255});
        DrawOptions options = small;
        options.phong = {.ambient = 1.0, .diffuse = 0.0, .specular = 0.0};
        const Image image = picture(content_of(m, shading), from_front, options);
        EXPECT_NEAR(pixel(image, 48, 48)[0], to_srgb(0.1), 1.0);
        EXPECT_NEAR(pixel(image, 48, 48)[1], to_srgb(0.5), 1.0);
        EXPECT_EQ(pixel(image, 48, 48)[2], 0);
    }
}

TEST_F(RendererTest, EmissionShinesWithoutLight) {
    Decoded content = content_of(square(), Shading::flat, Vec4f{0, 0, 0, 1});
    content.materials[0].emissive = {0.2f, 0.0f, 0.0f};
    View view = from_front;
    view.light = {0, 0, -1};
    const Image image = picture(content, view);
    EXPECT_NEAR(pixel(image, 48, 48)[0], to_srgb(0.2), 1.0);
    EXPECT_EQ(pixel(image, 48, 48)[1], 0);
}

TEST_F(RendererTest, MaskCutsOutAndBlendMixesInLinearLight) {
    Decoded content = content_of(square(), Shading::flat, Vec4f{0, 0, 0, 0.4f});
    content.materials[0].alpha_mode = mesh::AlphaMode::mask;
    EXPECT_EQ(covered(picture(content, from_front)), 0u);
    content.materials[0].alpha_cutoff = 0.3f;
    EXPECT_GT(covered(picture(content, from_front)), 1000u);
    content.materials[0].alpha_mode = mesh::AlphaMode::blend;
    DrawOptions options = small;
    options.phong = {.ambient = 1.0, .diffuse = 0.0, .specular = 0.0};
    EXPECT_NEAR(pixel(picture(content, from_front, options), 48, 48)[0], to_srgb(0.6), 1.0);
}

TEST_F(RendererTest, BlendedSurfaceInFrontShowsTheOpaqueOneBehindWhateverTheOrder) {
    for (const std::uint32_t opaque : {0u, 1u}) {
        Decoded content;
        content.materials.resize(2);
        content.materials[opaque].base_color = {1, 0, 0, 1};
        content.materials[1 - opaque].base_color = {0, 0, 1, 0.5f};
        content.materials[1 - opaque].alpha_mode = mesh::AlphaMode::blend;
        for (const std::uint32_t material : {0u, 1u})
            content.primitives.push_back({Shading::gouraud, material, square(material == opaque ? -0.5f : 0.5f)});
        DrawOptions options = small;
        options.phong = {.ambient = 1.0, .diffuse = 0.0, .specular = 0.0};
        const Image image = picture(content, from_front, options);
        EXPECT_NEAR(pixel(image, 48, 48)[0], to_srgb(0.5), 1.0);
        EXPECT_NEAR(pixel(image, 48, 48)[2], to_srgb(0.5), 1.0);
    }
}

TEST(Drawable, MakesOnePrimitiveForEachMaterialAndShading) {
    mesh::Model model;
    model.materials.resize(2);
    model.origin = {1, 2, 3};
    model.mesh = testing::tetrahedron();
    model.mesh.normals.assign(4, Vec3f{0, 1, 0});
    model.mesh.triangle_materials = {0, 1, 1, 0};
    const Decoded content = drawable(model, model.mesh, std::vector<std::uint8_t>{1, 0, 1, 1});
    ASSERT_EQ(content.primitives.size(), 3u);
    std::size_t triangles = 0;
    for (const codec::Primitive& primitive : content.primitives) {
        triangles += primitive.mesh.triangles.size();
        EXPECT_EQ(primitive.mesh.normals.empty(), primitive.shading == Shading::flat);
    }
    EXPECT_EQ(triangles, 4u);
    EXPECT_EQ(content.origin, model.origin);
    EXPECT_EQ(world_bounds(content).min, (Vec3d{1, 2, 3}));
    EXPECT_EQ(world_bounds(content).max, (Vec3d{2, 3, 4}));
}

TEST(Drawable, MeshWithoutNormalsIsFlatEverywhere) {
    mesh::Model model;
    model.mesh = testing::tetrahedron();
    const Decoded content = drawable(model, model.mesh);
    ASSERT_EQ(content.primitives.size(), 1u);
    EXPECT_EQ(content.primitives[0].shading, Shading::flat);
    EXPECT_EQ(content.materials.size(), 1u);
}

}  // namespace
}  // namespace lodestream::render
