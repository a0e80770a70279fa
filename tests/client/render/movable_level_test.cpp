#include "client/render/movable_level.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "client/render/renderer.h"
#include "client/render/vertex_order.h"
#include "common/mesh/operations.h"
#include "common/shading/importance.h"
#include "common/shading/split_control.h"
#include "tests/client/render/with_renderer.h"
#include "tests/support/meshes.h"

namespace lodestream::render {
namespace {

using codec::Decoded;
using codec::Shading;
using shading::View;

mesh::Model model_of(mesh::Mesh mesh) {
    mesh::Model model;
    model.mesh = std::move(mesh);
    model.materials.emplace_back();
    return model;
}

// Smooth hills with a sharp fold through the middle.
mesh::Mesh hills(std::uint32_t n) {
    return testing::grid(n, [n](double x, double z) {
        const double scale = 12.0 / n;
        return (1.5 * std::sin(x * scale) * std::cos(z * scale * 0.7) + 0.2 * std::abs(x * scale - 6.0)) / scale;
    });
}

mesh::Mesh smooth_hills(std::uint32_t n) {
    return mesh::with_normals(hills(n), crease_degrees);
}

std::vector<std::uint8_t> alternating(std::size_t triangles, std::size_t run) {
    std::vector<std::uint8_t> labels(triangles);
    for (std::size_t t = 0; t < triangles; ++t) labels[t] = static_cast<std::uint8_t>(t / run % 2);
    return labels;
}

MovableLevel movable(const Decoded& content) {
    auto level = movable_level(content);
    EXPECT_TRUE(level) << level.error().message;
    return level ? *std::move(level) : MovableLevel{};
}

TEST(MovableLevel, KeepsEveryTriangleOnceInOneOrder) {
    mesh::Model model = model_of(smooth_hills(20));
    model.materials.resize(3);
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t)
        model.mesh.triangle_materials.push_back(t % 2 ? 2u : 0u);
    const MovableLevel level = movable(drawable(model, model.mesh, alternating(800, 7)));
    EXPECT_EQ(level.triangles(), 800u);
    ASSERT_EQ(level.content.primitives.size(), 2u);
    ASSERT_EQ(level.places.size(), 2u);
    std::vector<std::uint32_t> all;
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(level.content.primitives[i].shading, Shading::gouraud);
        EXPECT_EQ(level.content.primitives[i].mesh.triangles.size(), level.places[i].size());
        EXPECT_TRUE(std::is_sorted(level.places[i].begin(), level.places[i].end()));
        all.insert(all.end(), level.places[i].begin(), level.places[i].end());
    }
    std::sort(all.begin(), all.end());
    std::vector<std::uint32_t> expected(800);
    std::iota(expected.begin(), expected.end(), 0u);
    EXPECT_EQ(all, expected);
    EXPECT_TRUE(std::is_sorted(level.difference_left.rbegin(), level.difference_left.rend()));
}

TEST(MovableLevel, FlatRegionsTakeTheBordersNormalsAndAverageInside) {
    mesh::Mesh sphere = testing::sphere(40);
    const Decoded all = drawable(model_of(sphere), sphere);
    for (const std::size_t run : {sphere.triangles.size() / 2, std::size_t{1}, sphere.triangles.size()}) {
        std::vector<std::uint8_t> labels = alternating(sphere.triangles.size(), run);
        const MovableLevel level = movable(drawable(model_of(sphere), sphere, labels));
        for (const codec::Primitive& primitive : level.content.primitives)
            for (std::size_t v = 0; v < primitive.mesh.positions.size(); ++v) {
                const double along = dot(primitive.mesh.positions[v], primitive.mesh.normals[v]);
                EXPECT_GT(along, run == 1 ? 0.9999 : 0.995);  // where every position is a border, the very normal
            }
    }
    EXPECT_EQ(movable(all).content.primitives[0].mesh.positions.size(), sphere.positions.size());
}

TEST(MovableLevel, SharpEdgesOfFlatRegionsStaySharp) {
    mesh::Mesh roof;
    roof.positions = {{0, 1, -1}, {0, 1, 1}, {-1, 0, -1}, {-1, 0, 1}, {1, 0, -1}, {1, 0, 1}};
    roof.triangles = {{0, 2, 1}, {1, 2, 3}, {0, 1, 4}, {1, 5, 4}};
    const MovableLevel level = movable(drawable(model_of(roof), roof));
    const mesh::Mesh& mesh = level.content.primitives[0].mesh;
    EXPECT_EQ(mesh.positions.size(), 8u);  // the ridge's two positions twice
    for (const Vec3f& normal : mesh.normals) EXPECT_NEAR(std::abs(normal.x), std::sqrt(0.5), 1e-6);
}

TEST(MovableLevel, DegenerateFacesAndMissingNormalsStayFinite) {
    mesh::Mesh broken = testing::sphere(8);
    broken.normals.assign(broken.normals.size(), Vec3f(0.0f));
    broken.triangles.push_back({1, 1, 2});
    broken.positions.push_back(broken.positions[1] * 0.5f + broken.positions[2] * 0.5f);
    broken.normals.emplace_back(0.0f);
    broken.triangles.push_back({1, static_cast<std::uint32_t>(broken.positions.size() - 1), 2});  // no area
    for (const std::uint8_t label : {0, 1}) {
        const std::vector<std::uint8_t> labels(broken.triangles.size(), label);
        const MovableLevel level = movable(drawable(model_of(broken), broken, labels));
        EXPECT_EQ(level.triangles(), broken.triangles.size() - 1);
        for (const double left : level.difference_left) EXPECT_TRUE(std::isfinite(left));
        for (const Vec3f& normal : level.content.primitives[0].mesh.normals) EXPECT_TRUE(all_finite(normal));
    }
    EXPECT_EQ(movable(Decoded{}).triangles(), 0u);
    EXPECT_FALSE(movable_level(Decoded{{{Shading::gouraud, 3, broken}}, {}, {}, Vec3d(0), {}}));
}

TEST(VertexOrder, IsAPermutationAlsoOfEqualTriangles) {
    std::vector<mesh::Triangle> triangles = testing::sphere(10).triangles;
    for (int i = 0; i < 5; ++i) triangles.push_back(triangles[3]);
    triangles.push_back({triangles[3][1], triangles[3][2], triangles[3][0]});
    std::vector<std::uint32_t> order = cache_order(triangles);
    std::sort(order.begin(), order.end());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) EXPECT_EQ(order[t], t);
    EXPECT_TRUE(cache_order({}).empty());
}

TEST(VertexOrder, TransformsFewerVerticesThanTheOrderOfImportanceAlone) {
    const mesh::Mesh mesh = smooth_hills(100);
    mesh::Mesh by_importance = mesh;
    by_importance.triangles.clear();
    for (const std::uint32_t t : shading::order_by_gain(shading::importance(mesh, {}).gain))
        by_importance.triangles.push_back(mesh.triangles[t]);
    const MovableLevel level = movable(drawable(model_of(mesh), mesh));
    const double arranged = transforms_per_triangle(level.content.primitives[0].mesh);
    EXPECT_LT(arranged, 0.9 * transforms_per_triangle(by_importance));
    EXPECT_GE(arranged, 0.5);
    EXPECT_EQ(transforms_per_triangle({}), 0.0);
}

class MovableRendererTest : public testing::WithRenderer {
  protected:
    Image picture(const View& view) {
        const auto frame = renderer->draw(view, options);
        EXPECT_TRUE(frame) << frame.error().message;
        return frame ? frame->image : Image{};
    }

    // Of the two pictures, summed over all pixels: the squared difference, mean over R, G and B, in display units.
    static double squared_difference(const Image& a, const Image& b) {
        const auto difference = compare(a, b);
        EXPECT_TRUE(difference);
        if (!difference) return 1e9;
        return difference->rms * difference->rms / (255.0 * 255.0) * static_cast<double>(difference->compared_pixels);
    }

    DrawOptions options{.width = 320, .height = 240, .samples = 1};
};

TEST_F(MovableRendererTest, ASplitShowsWhatTheSameTrianglesWouldUploadedSo) {
    const mesh::Mesh mesh = smooth_hills(24);
    const MovableLevel level = movable(drawable(model_of(mesh), mesh));
    const View view = shading::framing_view(world_bounds(level.content));
    const mesh::Mesh& ordered = level.content.primitives[0].mesh;
    for (const std::uint64_t gouraud : {std::uint64_t{0}, std::uint64_t{301}, level.triangles()}) {
        ASSERT_TRUE(renderer->upload(level));
        renderer->move_split(gouraud);
        const Image moved = picture(view);
        std::vector<std::uint8_t> labels(level.triangles(), 0);
        std::fill_n(labels.begin(), gouraud, std::uint8_t{1});
        ASSERT_TRUE(renderer->upload(drawable(model_of(ordered), ordered, labels)));
        EXPECT_LT(squared_difference(moved, picture(view)), 1e-6) << gouraud;
    }
}

TEST_F(MovableRendererTest, MovingTheSplitOfAHundredThousandTrianglesTakesUnderAMillisecond) {
    const mesh::Mesh mesh = smooth_hills(224);
    const MovableLevel level = movable(drawable(model_of(mesh), mesh));
    ASSERT_GT(level.triangles(), 100'000u);
    ASSERT_TRUE(renderer->upload(level));
    const shading::SplitCurve curve{level.difference_left, level.radius};
    shading::SplitState state = shading::settled_split(0.0, 16, level.triangles());
    std::vector<double> times_ms;
    for (int frame = 0; frame < 101; ++frame) {
        const auto start = std::chrono::steady_clock::now();
        state = shading::move_split(state, frame % 2 ? 0.1 : 0.9, 16, curve, {.max_change = 1.0}).state;
        renderer->move_split(state.gouraud);
        times_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    std::sort(times_ms.begin(), times_ms.end());
    RecordProperty("median_ms", std::to_string(times_ms[50]));
    RecordProperty("max_ms", std::to_string(times_ms[100]));
    EXPECT_LT(times_ms[50], 1.0);
}

// A full circle around the model, near and far in turn. In every frame the view is drawn with the border before and
// after its move: what the move alone changes stays below the bound that was stated for it.
TEST_F(MovableRendererTest, OrbitWithSplitChangesKeepsEveryFrameWithinTheStatedBound) {
    const mesh::Mesh mesh = smooth_hills(64);
    const MovableLevel level = movable(drawable(model_of(mesh), mesh));
    ASSERT_TRUE(renderer->upload(level));
    const Box bounds = world_bounds(level.content);
    const budget::Display display{options.width, options.height};
    const shading::SplitCurve curve{level.difference_left, level.radius};
    constexpr std::uint32_t steps = 8;
    constexpr int frames = 72;
    const shading::SplitControlOptions control{.max_change = 2.0 / 255.0};
    std::optional<shading::SplitState> state;
    int moves = 0;
    double closest = 0.0;
    for (int frame = 0; frame < frames; ++frame) {
        const double turn = 2.0 * pi * frame / frames;
        View view = shading::framing_view(bounds);
        const double away = 2.0 * level.radius * std::exp2(1.5 - 1.5 * std::cos(turn));
        view.eye = view.target + away * normalize(Vec3d{std::sin(turn), 0.5, std::cos(turn)});
        const double distance = shading::continuous_distance(view, bounds, display);
        if (!state) state = shading::settled_split(distance, steps, level.triangles());
        renderer->move_split(state->gouraud);
        const Image before = picture(view);
        const shading::SplitMove move = shading::move_split(*state, distance, steps, curve, control);
        moves += move.state.gouraud != state->gouraud ? 1 : 0;
        renderer->move_split(move.state.gouraud);
        const double pixels = shading::pixels_per_unit(view, bounds, display);
        const double changed = squared_difference(before, picture(view));
        const double bound = move.squared_change * pixels * pixels;
        EXPECT_LE(changed, bound + 1e-9) << "frame " << frame;
        EXPECT_LE(bound, control.max_change * control.max_change * pi * std::pow(level.radius * pixels, 2.0) * 1.0001);
        if (bound > 0.0) closest = std::max(closest, changed / bound);
        state = move.state;
    }
    EXPECT_GT(moves, 10);
    EXPECT_GT(closest, 0.0);  // the border did move in view
    RecordProperty("moves", moves);
    RecordProperty("largest_share_of_the_bound", std::to_string(closest));
}

}  // namespace
}  // namespace lodestream::render
