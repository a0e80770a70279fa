#include "common/shading/importance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "common/mesh/operations.h"
#include "tests/common/shading/orders.h"
#include "tests/support/meshes.h"

namespace lodestream::shading {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float inf = std::numeric_limits<float>::infinity();

const std::vector<mesh::Material> white(1);

double displayed(double x) {
    x = std::clamp(x, 0.0, 1.0);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
}

// Phong's light on a white surface, without the step at the horizon.
double lit(const Vec3d& normal, const Vec3d& light, const Vec3d& to_eye, const Phong& phong) {
    const double incidence = dot(normal, light);
    const double highlight = std::max(0.0, dot(2.0 * incidence * normal - light, to_eye));
    return displayed(phong.ambient + phong.diffuse * std::max(0.0, incidence) +
                     phong.specular * std::pow(highlight, phong.shininess));
}

Vec3d random_unit(std::mt19937& random) {
    std::normal_distribution<double> normal;
    for (;;) {
        const Vec3d v(normal(random), normal(random), normal(random));
        if (length(v) > 1e-3) return normalize(v);
    }
}

void expect_sound(const Importance& importance, std::size_t triangles) {
    ASSERT_EQ(importance.difference.size(), triangles);
    ASSERT_EQ(importance.gain.size(), triangles);
    for (std::size_t t = 0; t < triangles; ++t) {
        EXPECT_TRUE(std::isfinite(importance.difference[t]));
        EXPECT_GE(importance.difference[t], 0.0);
        EXPECT_LE(std::abs(importance.gain[t]), importance.difference[t] * (1.0 + 1e-9));
    }
    EXPECT_TRUE(testing::is_permutation_of_all(order_by_gain(importance.gain), triangles));
    EXPECT_LE(worth_gouraud(importance), triangles);
}

TEST(GreatestDifference, BoundsEveryLightAndViewer) {
    std::mt19937 random(7);
    const Phong phong;
    for (const double degrees : {1.0, 10.0, 45.0, 89.0, 120.0}) {
        const Vec3d face(0, 0, 1);
        const Vec3d corner(std::sin(radians(degrees)), 0, std::cos(radians(degrees)));
        const double bound = greatest_difference(degrees, 1.0, phong);
        double seen = 0.0;
        for (int i = 0; i < 20'000; ++i) {
            const Vec3d light = random_unit(random), eye = random_unit(random);
            seen = std::max(seen, std::abs(lit(face, light, eye, phong) - lit(corner, light, eye, phong)));
        }
        EXPECT_LE(seen, bound + 1e-12) << degrees;
        EXPECT_GE(seen, 0.4 * bound) << degrees;  // and is not far above what happens
    }
}

TEST(GreatestDifference, GrowsWithTheAngleAndIsNothingWithoutOne) {
    for (const double color : {0.0, 0.2, 1.0}) {
        double last = greatest_difference(0.0, color, {});
        EXPECT_EQ(last, 0.0);
        for (double degrees = 1.0; degrees <= 180.0; degrees += 1.0) {
            const double next = greatest_difference(degrees, color, {});
            EXPECT_GE(next, last);
            EXPECT_LE(next, 1.0);
            last = next;
        }
    }
    EXPECT_EQ(greatest_difference(90.0, 0.0, {.specular = 0.0}), 0.0);  // black and matt
}

TEST(Importance, TakesNineOperationsATriangleAsThePapersCriterionDoes) {
    const OperationCounts counts = importance(testing::sphere(12), white).operations;
    EXPECT_EQ(counts.criterion(), 9u * testing::sphere(12).triangles.size());
    EXPECT_EQ(counts.sizes, testing::sphere(12).triangles.size());
    EXPECT_EQ(counts.shading(), 0u);
}

TEST(Importance, DoesNotChangeWithTheLight) {
    const mesh::Mesh mesh = testing::sphere(10);
    View view{{0, 0, 5}, {0, 0, 0}, 45.0, {0, 1, 0}};
    const auto one = importance(mesh, white, {.view = view}).gain;
    view.light = {1, -2, 3};
    EXPECT_EQ(importance(mesh, white, {.view = view}).gain, one);
}

TEST(Importance, FlatTrianglesWithEqualNormalsCostNothingToDrawFlat) {
    mesh::Mesh mesh = testing::flat_grid(3);
    mesh.normals.assign(mesh.positions.size(), Vec3f(0, 1, 0));
    for (const double difference : importance(mesh, white).difference) EXPECT_LT(difference, 1e-20);
    mesh.normals[0] = normalize(Vec3f(1, 1, 0));
    const std::vector<double> difference = importance(mesh, white).difference;
    EXPECT_EQ(std::max_element(difference.begin(), difference.end()), difference.begin());  // the one at vertex 0
}

TEST(Importance, IsInProportionToTheAreaWithoutAView) {
    mesh::Mesh mesh = testing::sphere(8);
    const auto unit = importance(mesh, white).difference;
    for (Vec3f& p : mesh.positions) p *= 4.0f;
    const auto large = importance(mesh, white).difference;
    for (std::size_t t = 0; t < unit.size(); ++t) EXPECT_NEAR(large[t], 16.0 * unit[t], 1e-4 * large[t]);
}

TEST(Importance, FacesTheViewerBeforeTheBackAndNothingBehindTheEye) {
    const mesh::Mesh mesh = testing::sphere(16);
    const View view{{0, 0, 5}, {0, 0, 0}, 45.0, {0, 1, 0}};
    const auto order = order_by_gain(importance(mesh, white, {.view = view}).gain);
    for (std::size_t i = 0; i < order.size() / 4; ++i) {
        const mesh::Triangle& t = mesh.triangles[order[i]];
        EXPECT_GT(mesh.positions[t[0]].z + mesh.positions[t[1]].z + mesh.positions[t[2]].z, 0.0f);
    }
    const auto away = importance(mesh, white, {.view = View{{0, 0, 5}, {0, 0, 9}, 45.0, {0, 1, 0}}}).gain;
    for (const double gain : away) EXPECT_EQ(gain, 0.0);
}

TEST(Importance, FollowsTheOriginAsTheEyeDoes) {
    const mesh::Mesh mesh = testing::sphere(8);
    const View view{{0, 1, 5}, {0, 0, 0}, 45.0, {0, 1, 0}};
    View moved = view;
    moved.eye += Vec3d(1e6, 0, 0);
    moved.target += Vec3d(1e6, 0, 0);
    EXPECT_EQ(order_by_gain(importance(mesh, white, {.view = view}).gain),
              order_by_gain(importance(mesh, white, {.view = moved, .origin = Vec3d(1e6, 0, 0)}).gain));
}

TEST(Importance, EverySplitIsAPrefixThatGainsMostOfItsCount) {
    const mesh::Mesh mesh = testing::grid(9, [](double x, double z) { return std::sin(x * x) + 0.3 * z; });
    const Importance importance = shading::importance(mesh::with_normals(mesh, 180.0), white);
    const auto order = order_by_gain(importance.gain);
    for (std::size_t i = 1; i < order.size(); ++i) EXPECT_GE(importance.gain[order[i - 1]], importance.gain[order[i]]);
    const auto left = difference_left(importance.difference, order);
    ASSERT_EQ(left.size(), order.size() + 1);
    EXPECT_EQ(left.back(), 0.0);
    for (std::size_t k = order.size(); k-- > 0;)
        EXPECT_DOUBLE_EQ(left[k], left[k + 1] + importance.difference[order[k]]);
}

TEST(Importance, OnARoundSurfaceNearlyAllOfTheDifferenceIsGained) {
    const mesh::Mesh mesh = testing::sphere(24);
    const Importance importance = shading::importance(mesh, white);
    double gain = 0.0, difference = 0.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        gain += importance.gain[t];
        difference += importance.difference[t];
    }
    EXPECT_GT(gain, 0.99 * difference);
}

// A face whose far side bends down: normals halfway around that crease would shade all of it.
TEST(Importance, BesideACreaseTheFaceIsNearerThanTheBlend) {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
    mesh.triangles = {{0, 2, 1}};
    mesh.normals = {{0, 1, 0}, normalize(Vec3f(1, 1, 0)), normalize(Vec3f(1, 1, 0))};
    const Importance importance = shading::importance(mesh, white);
    EXPECT_GT(importance.difference[0], 0.0);
    EXPECT_LT(importance.gain[0], 0.0);
    EXPECT_EQ(worth_gouraud(importance), 0u);
}

TEST(WorthGouraud, TakesWhatGainsNineMeanErrors) {
    Importance importance;
    importance.gain = {1.0, 1.0, -1.0, 5.0, 36.1};
    importance.facet_error = 20.0;
    EXPECT_EQ(worth_gouraud(importance), 1u);
    importance.gain[3] = 36.01;
    EXPECT_EQ(worth_gouraud(importance), 2u);
    EXPECT_EQ(worth_gouraud({}), 0u);
}

// A coarse sphere beside one of several times the triangles, and one whose normals all point up.
TEST(MeasuredImportance, GainsWhereTheBlendIsNearerAndLosesWhereTheFaceIs) {
    const ReferenceSurface fine(testing::sphere(64));
    mesh::Mesh mesh = testing::sphere(12);
    NormalErrors errors = normal_errors(mesh, fine);
    const Importance round = importance(mesh, white, {.errors = &errors});
    double gain = 0.0;
    for (const double g : round.gain) gain += g;
    EXPECT_GT(gain, 0.95 * round.facet_error);
    for (const double g : round.gain) EXPECT_GE(g, 0.0);

    mesh.normals.assign(mesh.normals.size(), Vec3f(0, 1, 0));
    errors = normal_errors(mesh, fine);
    const Importance wrong = importance(mesh, white, {.errors = &errors});
    EXPECT_LT(*std::min_element(wrong.gain.begin(), wrong.gain.end()), 0.0);
    EXPECT_LT(*std::max_element(wrong.gain.begin(), wrong.gain.end()),
              *std::max_element(round.gain.begin(), round.gain.end()));
}

TEST(MeasuredImportance, DarkTrianglesCountLessAndBlackOnesForTheirHighlight) {
    const mesh::Mesh mesh = testing::sphere(12);
    const NormalErrors errors = normal_errors(mesh, ReferenceSurface(testing::sphere(48)));
    std::vector<mesh::Material> dark(1), black(1);
    dark[0].base_color = glm::vec4(0.05f, 0.05f, 0.05f, 1.0f);
    black[0].base_color = glm::vec4(0.0f, 0.0f, 0.0f, 1.0f);
    const auto error = [&](const std::vector<mesh::Material>& materials, const Phong& phong) {
        return importance(mesh, materials, {.phong = phong, .errors = &errors}).facet_error;
    };
    Phong dull;
    dull.specular = 0.0;
    EXPECT_GT(error(white, dull), error(dark, dull));
    EXPECT_EQ(error(black, dull), 0.0);
    EXPECT_GT(error(black, Phong{}), 0.0);
}

TEST(Importance, ZeroNormalsAreTheWorstThatCanHappenAndFinite) {
    mesh::Mesh mesh = testing::sphere(6);
    const auto known = importance(mesh, white).difference;
    mesh.normals.assign(mesh.normals.size(), Vec3f(0.0f));
    const Importance unknown = importance(mesh, white);
    expect_sound(unknown, mesh.triangles.size());
    for (std::size_t t = 0; t < known.size(); ++t) EXPECT_GE(unknown.difference[t], known[t]);
    mesh.normals.clear();
    expect_sound(importance(mesh, white), mesh.triangles.size());
}

TEST(Importance, ZeroAreaFacesCountForNothing) {
    mesh::Mesh mesh = testing::sphere(6);
    for (Vec3f& p : mesh.positions) p = Vec3f(1, 2, 3);
    const Importance points = importance(mesh, white, {.view = View{{1, 2, 3}, {0, 0, 0}, 45, {0, 1, 0}}});
    expect_sound(points, mesh.triangles.size());
    for (const double difference : points.difference) EXPECT_EQ(difference, 0.0);
}

TEST(Importance, CameraOnAVertexInsideTheModelAndInAFacesPlaneIsFinite) {
    const mesh::Mesh mesh = testing::sphere(12);
    for (const Vec3d eye : {Vec3d(mesh.positions[7]), Vec3d(0.0), Vec3d(0.99, 0, 0), Vec3d(1e300, 0, 0)})
        expect_sound(importance(mesh, white, {.view = View{eye, {0, 0, 9}, 45.0, {0, 1, 0}}}), mesh.triangles.size());
}

TEST(Importance, NumbersThatAreNoneStayOutOfTheResult) {
    mesh::Mesh mesh = testing::sphere(6);
    mesh.normals[0] = Vec3f(nan);
    mesh.normals[1] = Vec3f(inf);
    mesh.positions[2] = Vec3f(nan);
    mesh.positions[3] = Vec3f(3e38f);
    std::vector<mesh::Material> broken(1);
    broken[0].base_color = Vec4f(nan);
    for (const double shininess : {static_cast<double>(nan), 0.0, 1.0, 1e300})
        expect_sound(importance(mesh, broken, {.phong = {.shininess = shininess}}), mesh.triangles.size());
    expect_sound(importance({}, {}), 0);
}

}  // namespace
}  // namespace lodestream::shading
