#include "common/metric/triangle_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace lodestream::metric {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Triangles of all sizes, large ones across many small ones, around `center`; all lengths times `scale`.
mesh::Mesh soup(std::size_t triangles, double scale, const Vec3d& center) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    const auto any = [&] { return Vec3d(normal(random), normal(random), normal(random)); };
    mesh::Mesh mesh;
    for (std::uint32_t t = 0; t < triangles; ++t) {
        const Vec3d place = center + any();
        const double size = std::pow(10.0, -static_cast<double>(t % 4));
        for (int k = 0; k < 3; ++k) mesh.positions.emplace_back(scale * (place + size * any()));
        mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    return mesh;
}

double nearest_of_all(const TriangleTree& tree, const Vec3d& point) {
    double nearest = infinity;
    for (const TriangleTree::Corners& t : tree.triangles()) nearest = std::min(nearest, squared_distance(t, point));
    return nearest;
}

struct Place {
    double scale;
    Vec3d center;
};
class TriangleTreeTest : public ::testing::TestWithParam<Place> {};

TEST_P(TriangleTreeTest, FindsTheSameAsLookingAtEveryTriangle) {
    const auto [scale, center] = GetParam();
    const mesh::Mesh mesh = soup(600, scale, center);
    const TriangleTree tree(mesh);
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 300; ++i) {
        const double away = i % 3 == 0 ? 1.0 : i % 3 == 1 ? 1e-3 : 1e4;
        const Vec3d point = scale * (center + away * Vec3d(normal(random), normal(random), normal(random)));
        const double nearest = nearest_of_all(tree, point);
        EXPECT_EQ(tree.squared_distance(point, infinity), nearest);
        EXPECT_EQ(tree.squared_distance(point, nearest), nearest) << "none is nearer than the bound";
        EXPECT_EQ(tree.nearest(point, nearest * (1.0 + 1e-9)).squared_distance, nearest) << "one is, by little";
    }
    for (const Vec3f& corner : mesh.positions) EXPECT_EQ(tree.squared_distance(Vec3d(corner), infinity), 0.0);
}

// Looks at every triangle by itself: each as a tree of its own.
double first_of_all(const mesh::Mesh& mesh, const Vec3d& origin, const Vec3d& direction, double from) {
    double first = infinity;
    for (const mesh::Triangle& t : mesh.triangles) {
        mesh::Mesh one;
        for (const std::uint32_t v : t) one.positions.push_back(mesh.positions[v]);
        one.triangles.push_back({0, 1, 2});
        first = std::min(first, TriangleTree(one).first_along(origin, direction, from, infinity).distance);
    }
    return first;
}

TEST_P(TriangleTreeTest, ARayMeetsFirstWhatItMeetsFirstOfAll) {
    const auto [scale, center] = GetParam();
    const mesh::Mesh mesh = soup(300, scale, center);
    const TriangleTree tree(mesh);
    std::mt19937 random(13);
    std::normal_distribution<double> normal;
    int met = 0;
    for (int i = 0; i < 200; ++i) {
        const Vec3d origin = scale * (center + Vec3d(normal(random), normal(random), normal(random)));
        Vec3d direction(normal(random), normal(random), i % 4 == 0 ? 0.0 : normal(random));
        if (i % 8 == 0) direction.y = 0.0;
        direction = normalize(direction);
        const double from = i % 2 == 0 ? 0.0 : 0.5 * scale;
        const TriangleTree::Crossing first = tree.first_along(origin, direction, from, infinity);
        EXPECT_EQ(first.distance, first_of_all(mesh, origin, direction, from));
        if (first.triangle == TriangleTree::no_triangle) continue;
        ++met;
        const TriangleTree::Corners& t = tree.triangles()[first.triangle];
        const Vec3d there =
            first.weights.x * Vec3d(t[0]) + first.weights.y * Vec3d(t[1]) + first.weights.z * Vec3d(t[2]);
        EXPECT_LE(distance(there, origin + first.distance * direction), 1e-9 * scale * (1.0 + length(center)));
        EXPECT_EQ(tree.first_along(origin, direction, from, first.distance).triangle, TriangleTree::no_triangle)
            << "nothing is met before it";
    }
    EXPECT_GT(met, 50);
}

TEST(TriangleTree, ARayAlongATriangleOrWithoutAnyMeetsNothing) {
    mesh::Mesh flat;
    EXPECT_EQ(TriangleTree(flat).first_along(Vec3d(0.0), {1, 0, 0}, 0.0, infinity).triangle, TriangleTree::no_triangle);
    flat.positions = {{1, 0, 0}, {2, 0, 0}, {1, 1, 0}};
    flat.triangles = {{0, 1, 2}, {0, 1, 1}};
    EXPECT_EQ(TriangleTree(flat).first_along(Vec3d(0.0), {1, 0, 0}, 0.0, infinity).triangle, TriangleTree::no_triangle);
    EXPECT_EQ(TriangleTree(flat).first_along({1.1, 0.1, 3.0}, {0, 0, -1}, 0.0, infinity).distance, 3.0);
}

INSTANTIATE_TEST_SUITE_P(AnyScale, TriangleTreeTest,
                         ::testing::Values(Place{1.0, Vec3d(0.0)}, Place{1.0, Vec3d(5000.0, -300.0, 0.0)},
                                           Place{1e-30, Vec3d(0.0)}, Place{1e30, Vec3d(0.0)},
                                           Place{1e33, Vec3d(40.0)}));

TEST(TriangleTreeTest, AnswersFromAsFarAsNumbersGo) {
    const mesh::Mesh mesh = soup(100, 1e-9, Vec3d(0.0));
    const TriangleTree tree(mesh);
    for (const double far : {1e12, 1e38, 1e100}) {
        const Vec3d point(far, -far, far);
        EXPECT_EQ(tree.squared_distance(point, infinity), nearest_of_all(tree, point));
    }
}

TEST(TriangleTreeTest, HoldsManyTrianglesInOnePlace) {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}};
    mesh.triangles.assign(10'000, {0, 1, 2});
    mesh.triangles.push_back({3, 3, 3});
    const TriangleTree tree(mesh);
    EXPECT_EQ(tree.squared_distance({0.25, 0.25, 2.0}, infinity), 4.0);
    EXPECT_EQ(tree.squared_distance({5.0, 5.0, 6.0}, infinity), 1.0);
    EXPECT_EQ(tree.triangles().size(), mesh.triangles.size());
}

TEST(TriangleTreeTest, StaysExactWhereCentresGrowByPowers) {
    mesh::Mesh mesh;
    for (std::uint32_t t = 0; t < 200; ++t) {
        const auto x = static_cast<float>(std::exp2(0.5 * t - 60.0));
        mesh.positions.insert(mesh.positions.end(), {{x, 0, 0}, {x, x, 0}, {x, 0, x}});
        mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    const TriangleTree tree(mesh);
    for (const double x : {1e3, 1.0, 1e-3, 1e-5}) {
        const Vec3d point(x, 0.1 * x, 0.1 * x);
        EXPECT_EQ(tree.squared_distance(point, infinity), nearest_of_all(tree, point)) << x;
    }
}

TEST(TriangleTreeTest, FindsNothingInAnEmptyMesh) {
    const TriangleTree::Hit hit = TriangleTree(mesh::Mesh{}).nearest({1.0, 2.0, 3.0}, 9.0);
    EXPECT_EQ(hit.triangle, TriangleTree::no_triangle);
    EXPECT_EQ(hit.squared_distance, 9.0);
}

}  // namespace
}  // namespace lodestream::metric
