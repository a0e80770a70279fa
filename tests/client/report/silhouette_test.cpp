#include "client/report/silhouette.h"

#include <gtest/gtest.h>

#include <optional>

#include "client/render/gl_context.h"
#include "client/render/renderer.h"
#include "common/base/directions.h"
#include "tests/support/meshes.h"

namespace lodestream::report {
namespace {

codec::Decoded content_of(mesh::Mesh mesh, const Vec3d& origin = Vec3d(0.0)) {
    mesh::Model model;
    model.mesh = std::move(mesh);
    model.materials.resize(1);
    model.origin = origin;
    return render::drawable(model, model.mesh);
}

mesh::Mesh triangle(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    mesh::Mesh mesh;
    mesh.positions = {a, b, c};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

TEST(Mask, HoldsARectangleAcrossWordsOnlyWhenAllOfItIsSet) {
    Mask mask(200, 3);
    for (std::uint32_t x = 60; x < 140; ++x) mask.set(x, 1);
    EXPECT_TRUE(mask.holds({60, 140}, {1, 2}));
    EXPECT_TRUE(mask.holds({63, 65}, {1, 2}));
    EXPECT_FALSE(mask.holds({59, 140}, {1, 2}));
    EXPECT_FALSE(mask.holds({60, 141}, {1, 2}));
    EXPECT_FALSE(mask.holds({60, 140}, {1, 3}));
    EXPECT_TRUE(mask.holds({10, 10}, {0, 3}));
    EXPECT_EQ(mask.count(), 80u);
}

TEST(Mask, CountsWhatTwoShare) {
    Mask a(70, 2), b(70, 2);
    a.set(3, 0), a.set(69, 1);
    b.set(69, 1), b.set(68, 1);
    EXPECT_EQ(a.count_shared(b), 1u);
    a.join(b);
    EXPECT_EQ(a.count(), 3u);
    EXPECT_TRUE(a.at(68, 1));
    EXPECT_FALSE(a.at(68, 0));
}

// '#': covered
Mask drawn_as(std::initializer_list<std::string_view> rows) {
    Mask mask(static_cast<std::uint32_t>(rows.begin()->size()), static_cast<std::uint32_t>(rows.size()));
    std::uint32_t y = 0;
    for (const std::string_view row : rows) {
        for (std::uint32_t x = 0; x < row.size(); ++x)
            if (row[x] == '#') mask.set(x, y);
        ++y;
    }
    return mask;
}

TEST(Holes, AreWhatIsMissingInsideAndNotAtTheOutline) {
    const Mask full = drawn_as({".......",  //
                                ".#####.",  //
                                ".#####.",  //
                                ".#####.",  //
                                "......."});
    const Mask drawn = drawn_as({".......",  //
                                 ".####..",  //
                                 ".#..##.",  //
                                 "..####.",  //
                                 "......#"});
    const Holes holes = holes_in(drawn, full);
    EXPECT_EQ(holes.count, 1u);
    EXPECT_EQ(holes.pixels, 2u);
}

TEST(Holes, ThatReachThePicturesEdgeOrTheOutlineAreNone) {
    const Mask full = drawn_as({"####", "####", "####"});
    EXPECT_EQ(holes_in(drawn_as({"####", "#..#", "####"}), full).count, 1u);
    EXPECT_EQ(holes_in(drawn_as({"####", "#...", "####"}), full).count, 0u);
    EXPECT_EQ(holes_in(full, full).count, 0u);
    EXPECT_EQ(holes_in(drawn_as({"####", "#.##", "##.#"}), full).count, 1u);  // a corner joins nothing
}

TEST(SilhouetteTree, CoversThePixelsWhoseCentresATriangleHolds) {
    shading::View view;
    view.eye = {0, 0, 1};
    view.fov_y_deg = 90.0;  // a unit at distance 1 is half of the picture
    Mask mask(8, 8);
    SilhouetteTree(content_of(triangle({-1, -1, 0}, {1, -1, 0}, {-1, 1, 0})))
        .cover(render::pixels_from_world(view, 8, 8), Vec3d(0.0), mask);
    for (std::uint32_t y = 0; y < 8; ++y)
        for (std::uint32_t x = 0; x < 8; ++x) EXPECT_EQ(mask.at(x, y), x <= y) << x << " " << y;
}

TEST(SilhouetteTree, BetweenPixelCentresNothingIsCovered) {
    shading::View view;
    view.eye = {0, 0, 1};
    view.fov_y_deg = 90.0;
    Mask mask(2, 2);
    SilhouetteTree(content_of(triangle({-0.1f, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0})))
        .cover(render::pixels_from_world(view, 2, 2), Vec3d(0.0), mask);
    EXPECT_EQ(mask.count(), 0u);
}

TEST(SilhouetteTree, OfNoTrianglesCoversNothing) {
    Mask mask(4, 4);
    shading::View view;
    view.eye = {0, 0, 5};
    SilhouetteTree(codec::Decoded{}).cover(render::pixels_from_world(view, 4, 4), Vec3d(0.0), mask);
    EXPECT_EQ(mask.count(), 0u);
}

TEST(SilhouetteTree, IsWhatTheRendererDraws) {
    const auto context = render::create_headless_context();
    ASSERT_TRUE(context) << context.error().message;
    Result<render::Renderer> renderer = render::Renderer::create();
    ASSERT_TRUE(renderer) << renderer.error().message;
    const codec::Decoded content = content_of(testing::sphere(24), {100.0, -20.0, 3.0});
    ASSERT_TRUE(renderer->upload(content));
    const SilhouetteTree tree(content);
    const Box bounds = render::world_bounds(content);
    render::DrawOptions options;
    options.width = 300;
    options.height = 200;
    options.samples = 1;
    options.phong = {0.0, 0.0, 0.0, 1.0};
    options.instances = {{{0, 0, 0}}, {{2, 1, -2}}, {{-3, -1, 2}}};
    for (std::size_t i = 0; i < 12; ++i) {
        shading::View view;
        view.target = bounds.center();
        view.eye = view.target + spread_direction(i, 12) * 12.0;
        const Result<render::Frame> frame = renderer->draw(view, options);
        ASSERT_TRUE(frame) << frame.error().message;
        const Mask drawn = silhouette(frame->image);
        Mask covered(options.width, options.height);
        for (const render::Instance& instance : options.instances)
            tree.cover(render::pixels_from_world(view, 300, 200), instance.offset, covered);
        const std::uint64_t both = covered.count_shared(drawn);
        EXPECT_GT(both, 1000u);
        // Drivers round corners to 1/16 px or finer.
        EXPECT_LE(covered.count() - both, 6u) << i;
        EXPECT_LE(drawn.count() - both, 6u) << i;
    }
}

}  // namespace
}  // namespace lodestream::report
