#include "common/metric/surface_distance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "common/mesh/operations.h"
#include "tests/support/meshes.h"

namespace lodestream::metric {
namespace {

using mesh::Mesh;
using testing::flat_grid;
using testing::single_triangle;
using testing::sphere;
using testing::tetrahedron;

SurfaceError between(const Mesh& original, const Mesh& level) {
    return measure(SurfaceIndex(original), original, level);
}

Mesh moved(Mesh m, const Vec3f& by) {
    for (Vec3f& p : m.positions) p += by;
    return m;
}

Mesh scaled(Mesh m, float factor) {
    for (Vec3f& p : m.positions) p *= factor;
    return m;
}

Mesh random_soup(std::uint32_t triangles, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> anywhere(-1, 1), nearby(-0.2f, 0.2f);
    Mesh m;
    for (std::uint32_t t = 0; t < triangles; ++t) {
        const Vec3f center{anywhere(random), anywhere(random), anywhere(random)};
        for (int k = 0; k < 3; ++k)
            m.positions.push_back(center + Vec3f{nearby(random), nearby(random), nearby(random)});
        m.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    return m;
}

// The distance by a search over the triangle's inside (projection) and its sides, written unlike the code under test.
double plain_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    double best = std::numeric_limits<double>::infinity();
    const Vec3d corners[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
        const Vec3d from = corners[k], side = corners[(k + 1) % 3] - from;
        const double t = glm::clamp(dot(p - from, side) / dot(side, side), 0.0, 1.0);
        best = std::min(best, length(p - (from + t * side)));
    }
    const Vec3d n = normalize(cross(b - a, c - a));
    const Vec3d foot = p - dot(p - a, n) * n;
    bool inside = true;
    for (int k = 0; k < 3; ++k)
        inside = inside && dot(cross(corners[(k + 1) % 3] - corners[k], foot - corners[k]), n) >= 0;
    return inside ? std::min(best, std::abs(dot(p - a, n))) : best;
}

double plain_distance(const Vec3d& p, const Mesh& m) {
    double best = std::numeric_limits<double>::infinity();
    for (const mesh::Triangle& t : m.triangles)
        best = std::min(
            best, plain_distance(p, Vec3d(m.positions[t[0]]), Vec3d(m.positions[t[1]]), Vec3d(m.positions[t[2]])));
    return best;
}

TEST(SurfaceIndex, AgreesWithTryingEveryTriangle) {
    const Mesh soup = random_soup(500, 7);
    const SurfaceIndex index(soup);
    std::mt19937 random(8);
    std::uniform_real_distribution<double> anywhere(-2, 2);
    for (int i = 0; i < 500; ++i) {
        const Vec3d p{anywhere(random), anywhere(random), anywhere(random)};
        const double expected = plain_distance(p, soup);
        EXPECT_NEAR(index.distance(p), expected, 1e-12);
        EXPECT_NEAR(index.distance(p, expected * 1.5 + 1e-9), expected, 1e-12);
    }
}

TEST(SurfaceIndex, NeverAnswersMoreThanTheHint) {
    const SurfaceIndex index(single_triangle());
    EXPECT_DOUBLE_EQ(index.distance({0, 0, 5}, 2.0), 2.0);
    EXPECT_DOUBLE_EQ(index.distance({0, 0, 5}, 7.0), 5.0);
}

TEST(SurfaceIndex, IsInfinitelyFarFromAnEmptyMesh) {
    EXPECT_EQ(SurfaceIndex(Mesh{}).distance({1, 2, 3}), std::numeric_limits<double>::infinity());
}

TEST(SurfaceIndex, KnowsTheNearestCornerSideAndInside) {
    const SurfaceIndex index(single_triangle());
    EXPECT_DOUBLE_EQ(index.distance({0.25, 0.25, -3}), 3.0);
    EXPECT_DOUBLE_EQ(index.distance({0.5, -2, 0}), 2.0);
    EXPECT_DOUBLE_EQ(index.distance({-3, -4, 0}), 5.0);
    EXPECT_DOUBLE_EQ(index.distance({1, 1, 0}), std::sqrt(0.5));
}

TEST(SurfaceIndex, TreatsDegenerateTrianglesAsSegmentsAndPoints) {
    Mesh segment;
    segment.positions = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}};
    segment.triangles = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}};
    const SurfaceIndex line(segment);
    EXPECT_DOUBLE_EQ(line.distance({2, 5, 0}), 5.0);
    EXPECT_DOUBLE_EQ(line.distance({6, 4, 0}), 5.0);

    Mesh point;
    point.positions = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
    point.triangles = {{0, 1, 2}};
    EXPECT_DOUBLE_EQ(SurfaceIndex(point).distance({1, 4, 5}), 5.0);
}

TEST(SurfaceIndex, IsExactEnoughOnNeedles) {
    Mesh needle;
    needle.positions = {{0, 0, 0}, {1, 0, 0}, {0.5f, 1e-8f, 0}};
    needle.triangles = {{0, 1, 2}};
    const SurfaceIndex index(needle);
    for (const double x : {0.0, 0.1, 0.5, 0.9, 1.0}) EXPECT_NEAR(index.distance({x, 0, 2}), 2.0, 1e-12);
    EXPECT_NEAR(index.distance({0.3, -1, 0}), 1.0, 1e-12);
    EXPECT_NEAR(index.distance({0.3, 1, 0}), 1.0, 2e-8);
}

TEST(SurfaceIndex, CanStackManyEqualTriangles) {
    Mesh m;
    for (std::uint32_t t = 0; t < 5000; ++t) {
        m.positions.insert(m.positions.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
        m.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    EXPECT_DOUBLE_EQ(SurfaceIndex(m).distance({0.1, 0.1, 1}), 1.0);
}

TEST(SurfaceIndex, SamplesLieOnTheSurfaceAndHoldEveryVertex) {
    const Mesh ball = sphere(12);
    const SurfaceIndex index(ball);
    EXPECT_EQ(index.samples().size(), ball.positions.size() + default_samples);
    for (std::size_t i = 0; i < index.samples().size(); i += 97)
        EXPECT_LT(index.distance(Vec3d(index.samples()[i])), 1e-6);
    for (const Vec3f& p : ball.positions)
        EXPECT_THAT(std::vector<Vec3f>(index.samples().begin(), index.samples().begin() + 134), ::testing::Contains(p));
}

TEST(SurfaceIndex, SamplesFollowTheArea) {
    Mesh m;  // two triangles, nine to one
    m.positions = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {10, 0, 0}, {11, 0, 0}, {10, 1, 0}};
    m.triangles = {{0, 1, 2}, {3, 4, 5}};
    const SurfaceIndex index(m);
    std::size_t small = 0;
    for (std::size_t i = 6; i < index.samples().size(); ++i) small += index.samples()[i].x > 5;
    EXPECT_NEAR(static_cast<double>(small), default_samples / 10.0, 2.0);
}

TEST(SurfaceIndex, TakesFewerVerticesOfLargeMeshes) {
    const SurfaceIndex index(flat_grid(400));
    EXPECT_EQ(index.samples().size(), 2 * default_samples);
}

TEST(Measure, IsZeroAgainstItself) {
    for (const Mesh& m : {sphere(20), tetrahedron(), flat_grid(5), random_soup(50, 3)}) {
        const SurfaceError error = between(m, m);
        EXPECT_LT(error.max, 2e-7);
        EXPECT_LE(error.rms, error.max);
    }
}

TEST(Measure, IsTheOffsetOfParallelPlanes) {
    const SurfaceError error = between(flat_grid(4), moved(flat_grid(4), {0, 0.25f, 0}));
    EXPECT_NEAR(error.rms, 0.25, 1e-9);
    EXPECT_NEAR(error.max, 0.25, 1e-9);
}

TEST(Measure, IsTheSagittaOfAnInscribedSphere) {
    const Mesh fine = sphere(128), coarse = sphere(12);
    const SurfaceError error = between(fine, coarse);
    double sagitta = 0;
    for (const mesh::Triangle& t : coarse.triangles) {
        const Vec3d a(coarse.positions[t[0]]), b(coarse.positions[t[1]]), c(coarse.positions[t[2]]);
        sagitta = std::max(sagitta, 1 - std::abs(dot(normalize(cross(b - a, c - a)), a)));
    }
    EXPECT_NEAR(error.max, sagitta, 0.1 * sagitta);
    EXPECT_LT(error.rms, error.max);
    EXPECT_GT(error.rms, 0.3 * error.max);
}

TEST(Measure, SeesWhatIsMissingInEitherDirection) {
    Mesh both = flat_grid(2);
    const Mesh far = moved(flat_grid(2), {0, 10, 0});
    for (const mesh::Triangle& t : far.triangles) both.triangles.push_back({t[0] + 9, t[1] + 9, t[2] + 9});
    both.positions.insert(both.positions.end(), far.positions.begin(), far.positions.end());
    const SurfaceError lost = between(both, flat_grid(2)), added = between(flat_grid(2), both);
    EXPECT_NEAR(lost.max, 10, 1e-6);
    EXPECT_NEAR(added.max, 10, 1e-6);
    EXPECT_NEAR(lost.rms, 10 / std::sqrt(2.0), 0.01);
    EXPECT_NEAR(lost.rms, added.rms, 0.01);
}

TEST(Measure, RmsIsAnAverageOverAreaNotOverVertices) {
    Mesh flat = flat_grid(1), spiked = flat_grid(1);  // a tiny tower of many vertices on a large square
    const float size = 1000;
    flat = scaled(flat, size);
    spiked = scaled(spiked, size);
    for (std::uint32_t k = 0; k < 1000; ++k) {
        const float y = 0.001f * static_cast<float>(k);
        const auto base = static_cast<std::uint32_t>(spiked.positions.size());
        spiked.positions.insert(spiked.positions.end(), {{500, y, 500}, {500.001f, y, 500}, {500, y, 500.001f}});
        spiked.triangles.push_back({base, base + 1, base + 2});
    }
    const SurfaceError error = between(flat, spiked);
    EXPECT_NEAR(error.max, 0.999, 1e-4);
    EXPECT_LT(error.rms, 0.01);
}

TEST(Measure, OfEmptyMeshesIsZeroOrTheDiagonal) {
    EXPECT_EQ(between({}, {}).max, 0);
    EXPECT_EQ(between({}, {}).rms, 0);
    const Mesh m = single_triangle();
    for (const SurfaceError error : {between(m, {}), between({}, m)}) {
        EXPECT_DOUBLE_EQ(error.rms, std::sqrt(2.0));
        EXPECT_DOUBLE_EQ(error.max, std::sqrt(2.0));
    }
}

TEST(Measure, ScalesWithTheModelFromAtomsToGalaxies) {
    const SurfaceError plain = between(sphere(16), sphere(8));
    for (const float factor : {0x1p-100f, 1e-20f, 1e20f, 0x1p+110f}) {
        const SurfaceError error = between(scaled(sphere(16), factor), scaled(sphere(8), factor));
        EXPECT_NEAR(error.rms / double{factor} / plain.rms, 1, 1e-3);
        EXPECT_NEAR(error.max / double{factor} / plain.max, 1, 1e-3);
    }
}

TEST(Measure, IsFiniteForTrianglesWithoutArea) {
    Mesh segment;
    segment.positions = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}};
    segment.triangles = {{0, 1, 2}};
    const SurfaceError error = between(segment, moved(segment, {0, 2, 0}));
    EXPECT_DOUBLE_EQ(error.rms, 2);
    EXPECT_DOUBLE_EQ(error.max, 2);
}

TEST(Measure, GivesTheSameAnswerAgain) {
    const SurfaceError first = between(sphere(20), sphere(9)), second = between(sphere(20), sphere(9));
    EXPECT_EQ(first.rms, second.rms);
    EXPECT_EQ(first.max, second.max);
}

// Normals of a plane, all tilted by so many degrees.
Mesh tilted(Mesh m, double degrees) {
    const double angle = glm::radians(degrees);
    m.normals.assign(m.positions.size(), Vec3f(Vec3d(std::sin(angle), std::cos(angle), 0.0)));
    return m;
}

TEST(SurfaceDistance, TellsWhatNormalsAreOff) {
    const Mesh upright = tilted(flat_grid(8), 0.0);
    EXPECT_NEAR(between(upright, upright).normal_degrees, 0.0, 1e-3);
    EXPECT_NEAR(between(upright, tilted(flat_grid(3), 10.0)).normal_degrees, 10.0, 1e-3);
    EXPECT_NEAR(between(upright, moved(tilted(flat_grid(3), 40.0), {0, 7, 0})).normal_degrees, 40.0, 1e-3);
}

TEST(SurfaceDistance, NormalsThatFaceApartOrAreMissingDoNotCount) {
    const Mesh upright = tilted(flat_grid(8), 0.0);
    EXPECT_EQ(between(upright, tilted(flat_grid(3), 120.0)).normal_degrees, 0.0);
    EXPECT_EQ(between(upright, flat_grid(3)).normal_degrees, 0.0);
    EXPECT_EQ(between(flat_grid(3), upright).normal_degrees, 0.0);
    Mesh zero = upright;
    zero.normals.assign(zero.positions.size(), Vec3f(0.0f));
    EXPECT_EQ(between(upright, zero).normal_degrees, 0.0);
}

}  // namespace
}  // namespace lodestream::metric
