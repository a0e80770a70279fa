// Point clouds as the renderer draws them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "client/render/renderer.h"
#include "client/render/scene.h"
#include "common/points/order.h"
#include "common/points/resample.h"
#include "tests/client/render/with_renderer.h"
#include "tests/support/meshes.h"

namespace lodestream::render {
namespace {

using shading::View;

const View from_front{{0, 0, 4}, {0, 0, 0}, 45.0, {0, 0, 1}};

const Vec4f grey{0.5f, 0.5f, 0.5f, 1.0f};  // never as white as the background, however lit

DrawOptions canvas(std::uint32_t side, std::uint32_t samples = 1) {
    DrawOptions options;
    options.width = options.height = side;
    options.samples = samples;
    return options;
}

mesh::Model model_of(mesh::Mesh mesh) {
    mesh::Model model;
    model.mesh = std::move(mesh);
    model.materials.resize(1);
    model.materials[0].base_color = grey;
    return model;
}

codec::Points points_of(const mesh::Mesh& mesh, std::uint64_t count) {
    points::OrderedCloud ordered = points::order(points::resample(mesh, points::choose_parameters(mesh, count)), count);
    codec::Points content;
    content.levels = points::measured_levels(metric::SurfaceIndex(mesh), mesh, ordered);
    content.cloud = std::move(ordered.cloud);
    content.base_color = grey;
    return content;
}

std::size_t covered(const Image& image) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        count += image.rgba[i] != 255 || image.rgba[i + 1] != 255 || image.rgba[i + 2] != 255;
    return count;
}

class DiscsTest : public testing::WithRenderer {
  protected:
    template <class Content>
    Image picture(const Content& content, const View& view, const DrawOptions& options) {
        const auto uploaded = renderer->upload(content);
        EXPECT_TRUE(uploaded) << uploaded.error().message;
        const auto frame = renderer->draw(view, options);
        EXPECT_TRUE(frame) << frame.error().message;
        return frame ? frame->image : Image{};
    }
};

// Of the two silhouettes: what both cover over what either does.
double agreement(const Difference& difference) {
    return 1.0 - 0.01 * difference.silhouette_percent;
}

TEST_F(DiscsTest, ASphereOfPointsHasTheSpheresSilhouetteAndShading) {
    const mesh::Mesh sphere = testing::sphere(60);
    const Image full = picture(drawable(model_of(sphere), sphere), from_front, canvas(256));
    for (const std::uint64_t count : {500u, 2000u, 8000u}) {
        const Image points = picture(points_of(sphere, count), from_front, canvas(256));
        const auto difference = compare(full, points);
        ASSERT_TRUE(difference);
        EXPECT_GT(agreement(*difference), count < 1000 ? 0.93 : 0.97) << count;
        EXPECT_LT(difference->rms, count < 1000 ? 40.0 : 25.0) << count;
    }
}

TEST_F(DiscsTest, NoLevelOfAClosedSurfaceHasAHole) {
    const mesh::Mesh sphere = testing::sphere(60);
    const codec::Points cloud = points_of(sphere, 4000);
    ASSERT_TRUE(renderer->upload(cloud));
    DrawOptions options = canvas(200);
    for (const std::uint64_t count : {100u, 333u, 1000u, 4000u}) {
        options.instances = {{{}, count}};
        const auto frame = renderer->draw(from_front, options);
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->points, count);
        // The sphere of radius 1 at distance 4 covers 0.58 of the height; a little inside of it nothing may be free.
        const double radius = 100.0 / std::tan(radians(22.5)) / std::sqrt(15.0) * 0.9;
        for (std::uint32_t y = 0; y < 200; ++y)
            for (std::uint32_t x = 0; x < 200; ++x)
                if (std::hypot(x - 99.5, y - 99.5) < radius) {
                    ASSERT_NE(frame->image.rgba[4 * (200 * y + x)], 255) << count << " points at " << x << ", " << y;
                }
    }
}

std::uint32_t pixel_at(const Image& image, std::size_t pixel) {
    std::uint32_t rgba = 0;
    for (std::size_t k = 0; k < 4; ++k) rgba = rgba << 8 | image.rgba[4 * pixel + k];
    return rgba;
}

TEST_F(DiscsTest, ALevelThatFadesIntoAnotherShowsOneOfBothAtEveryPixel) {
    const codec::Points cloud = points_of(testing::sphere(60), 4000);
    ASSERT_TRUE(renderer->upload(cloud));
    // From far, as points, and from so near that the discs are quads.
    for (const View& view : {from_front, View{{0, 0, 1.2}, {0, 0, 0}, 45.0, {0, 0, 1}}}) {
        DrawOptions options = canvas(200);
        const auto shown = [&](std::vector<Instance> instances) {
            options.instances = std::move(instances);
            const auto frame = renderer->draw(view, options);
            EXPECT_TRUE(frame) << frame.error().message;
            return frame->image;
        };
        const Image coarse = shown({{{}, 100}}), fine = shown({{{}, 4000}});
        for (const double progress : {0.0, 0.3, 0.5, 0.9, 1.0}) {
            const Image faded = shown({{{}, 4000, {0.0, progress}}, {{}, 100, {progress, 1.0}}});
            std::size_t different = 0, gone_over = 0;
            for (std::size_t p = 0; p < faded.pixels(); ++p) {
                const std::uint32_t pixel = pixel_at(faded, p), from = pixel_at(coarse, p), to = pixel_at(fine, p);
                ASSERT_TRUE(pixel == from || pixel == to) << "neither at pixel " << p << ", " << progress;
                different += from != to;
                gone_over += from != to && pixel == to;
            }
            ASSERT_GT(different, 1000u);
            EXPECT_NEAR(static_cast<double>(gone_over) / static_cast<double>(different), progress, 0.05);
        }
    }
}

TEST_F(DiscsTest, WithSamplesNoPixelOfAFadeIsAHole) {
    const codec::Points cloud = points_of(testing::sphere(60), 4000);
    ASSERT_TRUE(renderer->upload(cloud));
    DrawOptions options = canvas(200, 4);
    options.phong = {0.0, 0.0, 0.0, 1.0};
    for (const double progress : {0.1, 0.25, 0.5, 0.8}) {
        options.instances = {{{}, 4000, {0.0, progress}}, {{}, 300, {progress, 1.0}}};
        const auto frame = renderer->draw(from_front, options);
        ASSERT_TRUE(frame) << frame.error().message;
        const double radius = 100.0 / std::tan(radians(22.5)) / std::sqrt(15.0) * 0.9;
        for (std::uint32_t y = 0; y < 200; ++y)
            for (std::uint32_t x = 0; x < 200; ++x)
                if (std::hypot(x - 99.5, y - 99.5) < radius) {
                    ASSERT_EQ(frame->image.rgba[4 * (200 * y + x)], 0) << progress << " at " << x << ", " << y;
                }
    }
}

TEST_F(DiscsTest, AnInstancesShareMustLieInZeroToOne) {
    ASSERT_TRUE(renderer->upload(points_of(testing::sphere(8), 100)));
    DrawOptions options = canvas(20);
    for (const Share share : {Share{-0.1, 1.0}, Share{0.0, 1.5}, Share{std::nan(""), 1.0}}) {
        options.instances = {{{}, 100, share}};
        const auto refused = renderer->draw(from_front, options);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, ErrorCode::invalid_input);
    }
    options.instances = {{{}, 100, {0.4, 0.4}}};
    EXPECT_EQ(renderer->draw(from_front, options)->points, 0u);
}

TEST_F(DiscsTest, LargeCloudsAreDrawnWhole) {
    codec::Points cloud;
    for (int i = 0; i < 400'000; ++i) {
        const double height = 1.0 - 2.0 * (i + 0.5) / 400'000.0, around = std::sqrt(1.0 - height * height);
        cloud.cloud.positions.emplace_back(around * std::cos(2.4 * i), height, around * std::sin(2.4 * i));
    }
    cloud.cloud.normals = cloud.cloud.positions;
    cloud.levels = {{400'000, {}, 0.01}};
    cloud.base_color = grey;
    const double radius = 64.0 / std::tan(radians(22.5)) / std::sqrt(15.0);
    const Image image = picture(cloud, from_front, canvas(128));
    EXPECT_NEAR(static_cast<double>(covered(image)), pi * radius * radius, 0.03 * pi * radius * radius);
}

TEST_F(DiscsTest, FarAwayPointsCoverWhatTheMeshCovers) {
    const mesh::Mesh sphere = testing::sphere(60);
    const codec::Points cloud = points_of(sphere, 4000);
    for (const double distance : {20.0, 60.0, 150.0}) {  // 29, 10 and 4 px
        const View view{{0.3 * distance, 0, distance}, {0, 0, 0}, 45.0, {0, 0, 1}};
        const Image full = picture(drawable(model_of(sphere), sphere), view, canvas(256));
        const Image points = picture(cloud, view, canvas(256));
        EXPECT_NEAR(static_cast<double>(covered(points)), static_cast<double>(covered(full)),
                    std::max(1.0, 0.05 * static_cast<double>(covered(full))))
            << distance;
    }
}

TEST_F(DiscsTest, NoMorePointsAreDrawnThanThePictureNeeds) {
    constexpr std::uint64_t all = 16'000;
    codec::Points cloud = points_of(testing::sphere(90), all);
    ASSERT_TRUE(renderer->upload(cloud));
    const auto drawn_from = [&](double distance) {
        const auto frame = renderer->draw({{0, 0, distance}, {0, 0, 0}, 45.0, {0, 0, 1}}, canvas(1024));
        EXPECT_TRUE(frame);
        return frame->points;
    };
    EXPECT_EQ(drawn_from(10.0), all);
    const double sphere = world_bounds(cloud).radius();
    std::uint64_t before = all;
    for (const double distance : {40.0, 50.0, 60.0, 200.0}) {
        const double px_per_unit = 512.0 / std::tan(radians(22.5)) / (distance - sphere);
        const std::uint64_t points = drawn_from(distance);
        EXPECT_LT(points, before) << distance;
        EXPECT_NEAR(points::level_of(cloud.levels, points).radius,
                    std::min(points::least_disc_px / px_per_unit, sphere * points::least_disc_share), 1e-3)
            << distance;
        before = points;
    }
    cloud.levels.resize(1);  // such as a lean level's, of whose order nothing is told
    ASSERT_TRUE(renderer->upload(cloud));
    EXPECT_EQ(drawn_from(200.0), all);
}

// Sprites of about a pixel are drawn as whole pixels; what reaches into the next one must not be lost.
TEST_F(DiscsTest, DiscsSmallerThanAPixelLeaveNoHolesBetweenSamples) {
    const mesh::Mesh sphere = testing::sphere(60);
    codec::Points cloud = points_of(sphere, 8000);
    cloud.levels.resize(1);
    const View view{{0.0, 0, 20.0}, {0, 0, 0}, 45.0, {0, 0, 1}};  // discs of half a pixel
    const Image full = picture(drawable(model_of(sphere), sphere), view, canvas(256, 4));
    const Image points = picture(cloud, view, canvas(256, 4));
    const double radius = 128.0 / std::tan(radians(22.5)) / 20.0 - 2.0;
    for (std::uint32_t y = 0; y < 256; ++y)
        for (std::uint32_t x = 0; x < 256; ++x)
            if (std::hypot(x - 127.5, y - 127.5) < radius) {
                const std::size_t at = 4 * (256 * y + x);
                ASSERT_NEAR(points.rgba[at], full.rgba[at], 30) << x << ", " << y;
            }
}

TEST_F(DiscsTest, SamplesSmoothTheOutlineAsTheyDoForTriangles) {
    const mesh::Mesh sphere = testing::sphere(60);
    const Image full = picture(drawable(model_of(sphere), sphere), from_front, canvas(128, 4));
    const Image points = picture(points_of(sphere, 8000), from_front, canvas(128, 4));
    const auto difference = compare(full, points);
    ASSERT_TRUE(difference);
    EXPECT_LT(difference->rms, 25.0);
    EXPECT_GT(agreement(*difference), 0.96);
}

TEST_F(DiscsTest, APlaneSeenEdgeOnShowsNothingOfItsDiscs) {
    codec::Points plane = points_of(testing::flat_grid(8), 2000);
    const View along{{4, 0, 30}, {4, 0, 4}, 45.0, {0, 1, 0}};
    EXPECT_LT(covered(picture(plane, along, canvas(128))), 128u);  // at most a line
    const View above{{4, 20, 4.001}, {4, 0, 4}, 45.0, {0, 1, 0}};
    EXPECT_GT(covered(picture(plane, above, canvas(128))), 2500u);  // 8 of 16.6 units, squared
}

TEST_F(DiscsTest, DiscsWithoutNormalsFaceTheEye) {
    codec::Points cloud = points_of(testing::sphere(30), 1000);
    cloud.cloud.normals.clear();
    for (const Vec3d eye : {Vec3d(0, 0, 4), Vec3d(4, 0, 0), Vec3d(0, 4, 0)})
        EXPECT_GT(covered(picture(cloud, {eye, {0, 0, 0}, 45.0, {0, 0, 1}}, canvas(128))), 4000u);
}

TEST_F(DiscsTest, OnePointIsADiscOfItsOwn) {
    codec::Points cloud;
    cloud.cloud.positions = {{0, 0, 0}};
    cloud.cloud.normals = {{0, 0, 1}};
    cloud.levels = {{1, {}, 0.5}};
    cloud.base_color = grey;
    // Radius 0.5 at distance 4: 0.5 * 128 / 2 / tan(22.5°) / 4 = 19.3 px.
    const std::size_t pixels = covered(picture(cloud, from_front, canvas(128)));
    EXPECT_NEAR(static_cast<double>(pixels), pi * 19.3 * 19.3, 40.0);
}

TEST_F(DiscsTest, ModelsOfAnySizeDrawAlike) {
    const std::size_t usual = covered(picture(points_of(testing::sphere(30), 1000), from_front, canvas(128)));
    for (const double scale : {1e-9, 1e9}) {
        mesh::Mesh sphere = testing::sphere(30);
        for (Vec3f& p : sphere.positions) p *= static_cast<float>(scale);
        const View view{from_front.eye * scale, {0, 0, 0}, 45.0, {0, 0, 1}};
        EXPECT_NEAR(static_cast<double>(covered(picture(points_of(sphere, 1000), view, canvas(128)))),
                    static_cast<double>(usual), 0.005 * static_cast<double>(usual))  // other points: rounding differs
            << scale;
    }
}

TEST_F(DiscsTest, AnEyeInsideTheCloudDrawsSomethingFinite) {
    const codec::Points cloud = points_of(testing::sphere(30), 3000);
    for (const Vec3d eye : {Vec3d(0, 0, 0), Vec3d(0, 0, 0.999), Vec3d(1e-9, 0, 0), Vec3d(0, 0, 1)})
        picture(cloud, {eye, {3, 0, 0}, 45.0, {0, 0, 1}}, canvas(64));
}

// One disc around (0,0,0), and the same of triangles.
codec::Points one_disc(const Vec3d& normal, double radius) {
    codec::Points cloud;
    cloud.cloud.positions = {{0, 0, 0}};
    cloud.cloud.normals = {Vec3f(normal)};
    cloud.levels = {{1, {}, radius}};
    cloud.base_color = grey;
    return cloud;
}

mesh::Mesh round_fan(const Vec3d& normal, double radius) {
    constexpr std::uint32_t corners = 512;
    const Vec3d aside = normalize(cross(normal, Vec3d{0.3, 1, 0.2})), up = cross(normal, aside);
    mesh::Mesh fan;
    fan.positions.emplace_back(0.0f);
    for (std::uint32_t i = 0; i < corners; ++i) {
        const double around = 2.0 * pi * i / corners;
        fan.positions.emplace_back(radius * (std::cos(around) * aside + std::sin(around) * up));
        fan.triangles.push_back({0, i + 1, (i + 1) % corners + 1});
    }
    fan.normals.assign(fan.positions.size(), Vec3f(normal));
    return fan;
}

// Of the pixels that either covers, the share that both do. Not compare()'s: a picture's corner may be covered.
double overlap(const Image& a, const Image& b) {
    std::size_t both = 0, either = 0;
    for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
        const bool in_a = a.rgba[i] != 255, in_b = b.rgba[i] != 255;
        both += in_a && in_b ? 1 : 0;
        either += in_a || in_b ? 1 : 0;
    }
    EXPECT_GT(either, 300u);
    return static_cast<double>(both) / static_cast<double>(either);
}

TEST_F(DiscsTest, ADiscIsRoundHoweverLargeAndWhereverItsCentreIs) {
    struct Case {
        const char* what;
        View view;
        double radius = 1.0;
    };
    const std::vector<Case> cases{
        {"larger than the largest point", {{0, 0, 4}, {0, 0, 0}, 45.0, {0, 0, 1}}},
        {"larger than the picture", {{0, 0, 1.6}, {0, 0, 0}, 45.0, {0, 0, 1}}},
        {"small, centre beside the picture", {{3.6, 0, 6}, {3.6, 0, 0}, 45.0, {0, 0, 1}}, 0.3},
        {"small, centre above the picture", {{0, -2.6, 6}, {0, -2.6, 0}, 45.0, {0, 0, 1}}, 0.3},
        {"large, centre beside the picture", {{1.4, 0, 1.5}, {1.4, 0, 0}, 40.0, {0, 0, 1}}},
        {"larger than the cloud, which is beside the picture", {{7, 1, 6}, {7, 1, 0}, 45.0, {0, 0, 1}}, 5.0},
        {"drawn out by a wide angle", {{0, 0, 3}, {4, 0, 0.3}, 140.0, {0, 0, 1}}, 1.2},
    };
    DrawOptions options = canvas(400);
    options.width = 560;
    for (const Case& at : cases)
        for (const Vec3d& turned : {Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0.5, -1, 0}}) {
            const Vec3d normal = normalize(normalize(at.view.eye) + turned);
            const Image disc = picture(one_disc(normal, at.radius), at.view, options);
            const mesh::Mesh fan = round_fan(normal, at.radius);
            const Image full = picture(drawable(model_of(fan), fan), at.view, options);
            EXPECT_GT(overlap(disc, full), 0.99) << at.what << ", turned " << turned.x;
        }
}

TEST_F(DiscsTest, ALargeDiscSeenAlmostEdgeOnIsAsThinAsItIs) {
    const View view{{1.1, 0.7, 1.6}, {0, 0, 0}, 45.0, {0, 0, 1}};
    const Vec3d sight = normalize(view.eye), aside = normalize(cross(sight, Vec3d{0.2, 1, 0}));
    for (const double share : {0.1, 0.03, 0.01}) {
        const Vec3d normal = normalize(aside + share * sight);
        const Image disc = picture(one_disc(normal, 1.0), view, canvas(800));
        const mesh::Mesh fan = round_fan(normal, 1.0);
        EXPECT_GT(overlap(disc, picture(drawable(model_of(fan), fan), view, canvas(800))), 0.97) << share;
    }
}

TEST_F(DiscsTest, PointsAndQuadsOfOneCloudAgree) {
    codec::Points cloud = points_of(testing::sphere(60), 800);
    const Image points = picture(cloud, from_front, canvas(256));
    DrawOptions options = canvas(256);
    options.instances = {{{0, 0, 0}}};
    // The same again with one point in the eye, beside which a disc may be of any size.
    cloud.cloud.positions.emplace_back(0, 0, 4);
    cloud.cloud.normals.emplace_back(0, 0, 1);
    cloud.levels.insert(cloud.levels.begin(), {801, {}, cloud.levels.front().radius});
    options.instances[0].points = 800;
    ASSERT_TRUE(renderer->upload(cloud));
    const auto quads = renderer->draw(from_front, options);
    ASSERT_TRUE(quads);
    EXPECT_EQ(quads->points, 800u);
    const auto difference = compare(points, quads->image);
    ASSERT_TRUE(difference);
    EXPECT_LT(difference->silhouette_percent, 0.5);
    EXPECT_LT(difference->rms, 3.0);
}

TEST_F(DiscsTest, NoDiscInThePictureIsLargerThanWhatIsSaidOfIt) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    double closest = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const double fov_y_deg = 60.0 + 50.0 * share(random), radius = 0.2 * (1.0 + share(random)) + 1e-3;
        const View view{{0, 0, 4.0 + 2.5 * share(random)}, {share(random), share(random), 0}, fov_y_deg, {0, 0, 1}};
        const Camera camera = make_camera(view, Vec3d{0.0}, {}, 1.5);
        const Vec3d center = normalize(Vec3d{share(random), share(random), share(random)}) * share(random);
        const auto at = [&](const Vec3d& place) {  // px, of a picture of 100 px
            const Vec4d clip = Mat4d(camera.clip_from_scene) * Vec4d(place, 1.0);
            return clip.w > 0.0 ? 50.0 * Vec3d(clip.x * 1.5, clip.y, 0.0) / clip.w : Vec3d{1e9};
        };
        const Vec3d seen = at(center);
        if (std::abs(seen.x) > 75.0 || std::abs(seen.y) > 50.0) continue;
        const double said = largest_disc_px(camera, {}, radius, 100.0);
        for (int k = 0; k < 50; ++k) {
            const Vec3d edge = center + radius * normalize(Vec3d{share(random), share(random), share(random)});
            const double size = 2.0 * length(at(edge) - seen);
            EXPECT_LE(size, said * 1.0001);
            closest = std::max(closest, size / said);
        }
    }
    EXPECT_GT(closest, 0.5);
}

TEST_F(DiscsTest, InstancesStandWhereTheyAreToldAndHideEachOther) {
    const mesh::Mesh sphere = testing::sphere(30);
    const codec::Points cloud = points_of(sphere, 3000);
    const View far{{0, 0, 16}, {0, 0, 0}, 45.0, {0, 0, 1}};
    for (const bool as_points : {false, true}) {
        const auto uploaded =
            as_points ? renderer->upload(cloud) : renderer->upload(drawable(model_of(sphere), sphere));
        ASSERT_TRUE(uploaded);
        DrawOptions options = canvas(256);
        const std::size_t one = covered(renderer->draw(far, options)->image);
        options.instances = {{{-3, 0, 0}}, {{0, 0, 0}}, {{3, 0, 0}}};
        const auto three = renderer->draw(far, options);
        ASSERT_TRUE(three);
        EXPECT_NEAR(static_cast<double>(covered(three->image)), 3.0 * static_cast<double>(one),
                    0.1 * static_cast<double>(one));
        EXPECT_EQ(three->draw_calls, 3u);
        options.instances = {{{0, 0, -5}}, {{0, 0, 0}}};  // one behind the other
        EXPECT_NEAR(static_cast<double>(covered(renderer->draw(far, options)->image)), static_cast<double>(one), 2.0);
        options.instances = {{{0, 0, 30}}, {{500, 0, 0}}};  // behind the eye, beside the picture
        const auto none = renderer->draw(far, options);
        ASSERT_TRUE(none);
        EXPECT_EQ(none->draw_calls, 0u);
        EXPECT_EQ(covered(none->image), 0u);
        options.instances = {{{std::numeric_limits<double>::infinity(), 0, 0}}};
        EXPECT_FALSE(renderer->draw(far, options));
        options.instances = {{{1e300, 0, 0}}, {{0, 0, 0}}};
        EXPECT_TRUE(renderer->draw(far, options));
    }
}

}  // namespace
}  // namespace lodestream::render
