#include "common/shading/paper_criterion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/common/shading/orders.h"
#include "tests/support/meshes.h"

namespace lodestream::shading {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float inf = std::numeric_limits<float>::infinity();

using testing::is_permutation_of_all;

const std::vector<mesh::Material> one_material(1);

View view_from_above() {
    View view;
    view.eye = Vec3d(0, 10, 0);
    view.light = Vec3d(0, 1, 0);
    return view;
}

std::vector<std::uint32_t> paper_order(const mesh::Mesh& mesh, const std::vector<mesh::Material>& materials,
                                       const View& view, const Vec3d& origin, const Phong& phong = {}) {
    return paper_criterion(mesh, materials, view, origin, phong).order;
}

TEST(PaperOrder, TrianglesWhoseIntensitiesDifferComeFirstAndLargeOnesBeforeSmall) {
    mesh::Mesh mesh;
    const auto add = [&](float size, const Vec3f& last_normal) {
        const auto v = static_cast<std::uint32_t>(mesh.positions.size());
        for (const Vec3f& p : {Vec3f(0), Vec3f(size, 0, 0), Vec3f(0, 0, size)}) mesh.positions.push_back(p);
        mesh.normals.insert(mesh.normals.end(), {Vec3f(0, 1, 0), Vec3f(0, 1, 0), last_normal});
        mesh.triangles.push_back({v, v + 1, v + 2});
    };
    const Vec3f same(0, 1, 0), other(1, 0, 0);
    add(5.0f, same);
    add(1.0f, other);
    add(9.0f, same);
    add(2.0f, other);
    add(9.0f, same);
    Phong matt;
    matt.specular = 0.0;
    EXPECT_EQ(paper_order(mesh, one_material, view_from_above(), Vec3d(0), matt),
              (std::vector<std::uint32_t>{3, 1, 2, 4, 0}));
}

TEST(PaperOrder, BlackMaterialHasNothingToDifferButItsHighlight) {
    mesh::Mesh mesh = testing::sphere(6);
    std::vector<mesh::Material> black(1);
    black[0].base_color = Vec4f(0, 0, 0, 1);
    Phong matt;
    matt.specular = 0.0;
    const auto order = paper_order(mesh, black, view_from_above(), Vec3d(0), matt);
    const auto perimeter = [&](std::uint32_t t) {
        double sum = 0;
        for (int i = 0; i < 3; ++i)
            sum += glm::distance(Vec3d(mesh.positions[mesh.triangles[t][i]]),
                                 Vec3d(mesh.positions[mesh.triangles[t][(i + 1) % 3]]));
        return sum;
    };
    for (std::size_t i = 1; i < order.size(); ++i) EXPECT_GE(perimeter(order[i - 1]), perimeter(order[i]));
    mesh.colors.assign(mesh.positions.size(), Rgba8(0, 0, 0, 255));
    EXPECT_EQ(paper_order(mesh, one_material, view_from_above(), Vec3d(0), matt), order);
    EXPECT_NE(paper_order(mesh, black, view_from_above(), Vec3d(0)), order);
}

TEST(PaperOrder, OriginMovesTheModelUnderTheEye) {
    const mesh::Mesh mesh = testing::sphere(12);
    std::vector<mesh::Material> black(1);
    black[0].base_color = Vec4f(0, 0, 0, 1);  // only the highlight is left, and it follows the eye
    View view = view_from_above();
    const auto here = paper_order(mesh, black, view, Vec3d(0));
    view.eye += Vec3d(1e6, 0, 0);
    EXPECT_EQ(paper_order(mesh, black, view, Vec3d(1e6, 0, 0)), here);
    EXPECT_NE(paper_order(mesh, black, view, Vec3d(0)), here);
}

TEST(PaperOrder, DegenerateInputStillGivesAPermutation) {
    mesh::Mesh mesh = testing::sphere(6);
    const std::size_t count = mesh.triangles.size();
    View strange = view_from_above();
    strange.light = Vec3d(0.0);
    strange.eye = Vec3d(mesh.positions[0]);
    EXPECT_TRUE(is_permutation_of_all(paper_order(mesh, one_material, strange, Vec3d(0)), count));
    strange.eye = Vec3d(nan);
    strange.light = Vec3d(inf);
    EXPECT_TRUE(is_permutation_of_all(paper_order(mesh, one_material, strange, Vec3d(nan)), count));
    mesh.normals[0] = Vec3f(nan);
    mesh.normals[1] = Vec3f(0.0f);
    mesh.normals[2] = Vec3f(inf);
    for (std::size_t v = 3; v < mesh.positions.size(); ++v) mesh.positions[v] *= v % 2 ? 1e-38f : 3e38f;
    EXPECT_TRUE(is_permutation_of_all(paper_order(mesh, one_material, view_from_above(), Vec3d(0)), count));
    std::vector<mesh::Material> materials(1);
    materials[0].base_color = Vec4f(nan);
    Phong phong;
    phong.shininess = nan;
    EXPECT_TRUE(is_permutation_of_all(paper_order(mesh, materials, view_from_above(), Vec3d(0), phong), count));
    EXPECT_TRUE(paper_order({}, {}, view_from_above(), Vec3d(0)).empty());
}

TEST(PaperOrder, NormalsWithoutLengthCountAsNoDifference) {
    mesh::Mesh mesh = testing::tetrahedron();
    mesh.normals = {Vec3f(nan), Vec3f(0.0f), Vec3f(inf), Vec3f(-inf)};
    mesh.positions[3] = Vec3f(0, 0, 5);  // the triangle without this vertex is the smallest
    EXPECT_EQ(paper_order(mesh, one_material, view_from_above(), Vec3d(0)).back(), 0u);
}

// The teapot's 6,400 polygons do not matter to the counts: any mesh of as many will do.
mesh::Mesh mesh_of_6400() {
    mesh::Mesh mesh = testing::grid(57, [](double x, double z) { return std::sin(x) * std::cos(z); });
    mesh.triangles.resize(6400);
    mesh.normals.assign(mesh.positions.size(), Vec3f(0, 1, 0));
    return mesh;
}

std::vector<std::uint8_t> gouraud_then_flat(std::size_t gouraud, std::size_t flat) {
    std::vector<std::uint8_t> labels(gouraud, 1);
    labels.resize(gouraud + flat, 0);
    return labels;
}

TEST(Table3, CriterionTakesNineOperationsAPolygonCountedWhereTheyAreDone) {
    const OperationCounts counts =
        paper_criterion(mesh_of_6400(), one_material, view_from_above(), Vec3d(0)).operations;
    EXPECT_EQ(counts.sizes, 6'400u);
    EXPECT_EQ(counts.ambient + counts.diffuse + counts.specular + counts.comparisons, 8u * 6'400u);
    EXPECT_EQ(counts.criterion(), 57'600u);
    EXPECT_EQ(counts.shading(), 0u);
    EXPECT_EQ(paper_criterion({}, {}, view_from_above(), Vec3d(0)).operations.total(), 0u);
}

TEST(Table3, FlatAndGouraudRowsAndBothReadingsOfTheHybridRow) {
    const mesh::Mesh mesh = mesh_of_6400();
    const std::uint64_t criterion =
        paper_criterion(mesh, one_material, view_from_above(), Vec3d(0)).operations.criterion();
    const auto total = [&](std::size_t gouraud, std::size_t flat) {
        return criterion + paper_normals(mesh, gouraud_then_flat(gouraud, flat)).operations.total();
    };
    EXPECT_EQ(total(0, 6400), 64'000u);
    EXPECT_EQ(total(6400, 0), 83'200u);
    EXPECT_EQ(total(179, 6221), 64'537u);  // the text's reading: 179 polygons are Gouraud
    EXPECT_EQ(total(4421, 179), 75'463u);  // as printed; 179 + 4421 is 1,800 short of 6400
}

TEST(PaperNormals, AverageOverTheGouraudPolygonsAtAVertex) {
    const mesh::Mesh mesh = testing::tetrahedron();
    const PaperNormals normals = paper_normals(mesh, std::vector<std::uint8_t>{1, 0, 0, 0});
    EXPECT_EQ(normals.vertices[0], Vec3f(0, 0, -1));  // of triangle 0 alone
    EXPECT_EQ(normals.vertices[3], Vec3f(0.0f));      // no Gouraud triangle touches it
    EXPECT_EQ(normals.faces[1], Vec3f(0, -1, 0));
    EXPECT_EQ(paper_normals(mesh, std::vector<std::uint8_t>(9, 1)).operations.shading(), 16u);
}

TEST(PaperCriterion, DifferingCountsTheTrianglesThatComeFirst) {
    const mesh::Mesh sphere = testing::sphere(12);
    const PaperCriterion round = paper_criterion(sphere, one_material, view_from_above(), Vec3d(0));
    EXPECT_GT(round.differing, sphere.triangles.size() / 4);
    EXPECT_LT(round.differing, sphere.triangles.size());  // the side away from the light is all ambient
    mesh::Mesh even = testing::flat_grid(4);
    even.normals.assign(even.positions.size(), Vec3f(0, 1, 0));
    EXPECT_EQ(paper_criterion(even, one_material, {{0, 1e9, 0}, {0, 0, 0}, 45, {0, 1, 0}}, Vec3d(0)).differing, 0u);
}

}  // namespace
}  // namespace lodestream::shading
