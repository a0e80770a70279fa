#include "common/scene/surroundings.h"

#include <gtest/gtest.h>

#include <map>

#include "common/metric/surface_distance.h"
#include "tests/support/scenes.h"

namespace lodestream::scene {
namespace {

using testing::moved;

mesh::Mesh joined(const std::vector<mesh::Mesh>& parts) {
    mesh::Mesh all;
    for (const mesh::Mesh& part : parts) mesh::append(all, part);
    return all;
}

metric::SurfaceError error_of(const mesh::Mesh& source, const mesh::Mesh& wrapped) {
    return metric::measure(metric::SurfaceIndex(source, 10'000), source, wrapped);
}

double volume(const mesh::Mesh& mesh) {
    double six = 0.0;
    for (const auto& [a, b, c] : mesh.triangles)
        six += dot(Vec3d(mesh.positions[a]), cross(Vec3d(mesh.positions[b]), Vec3d(mesh.positions[c])));
    return six / 6.0;
}

TEST(Surroundings, WrapsASphereCloselyAndFacesOutwards) {
    const mesh::Mesh sphere = testing::sphere(40);
    const mesh::Mesh wrapped = Surroundings(sphere, 64).wrapped();
    EXPECT_LT(error_of(sphere, wrapped).max, 0.5 * 2.0 / 64);
    EXPECT_NEAR(volume(wrapped), volume(sphere), 0.02 * volume(sphere));
    for (std::size_t v = 0; v < wrapped.positions.size(); ++v)
        EXPECT_GT(dot(wrapped.normals[v], normalize(wrapped.positions[v])), 0.9f);
}

TEST(Surroundings, LeavesOutWhatIsInside) {
    const mesh::Mesh outer = testing::sphere(40), inner = moved(testing::sphere(20), {0, 0, 0}, 0.5f);
    const mesh::Mesh both = joined({inner, outer});
    const Surroundings around(both, 64);
    EXPECT_EQ(around.visible_triangles().size(), outer.triangles.size());
    EXPECT_LT(error_of(outer, around.wrapped()).max, 0.5 * 2.0 / 64);
}

TEST(Surroundings, JoinsPiecesThatAreLessThanACellApart) {
    const mesh::Mesh two = joined({testing::sphere(40), moved(testing::sphere(40), {2.01f, 0, 0})});
    const mesh::Mesh wrapped = Surroundings(two, 64).wrapped();
    std::vector<std::uint32_t> root(wrapped.positions.size());
    const std::vector<std::uint32_t> same = mesh::weld_positions(wrapped.positions);
    for (std::uint32_t v = 0; v < root.size(); ++v) root[v] = same[v];
    const auto find = [&](std::uint32_t v) {
        while (root[v] != v) v = root[v] = root[root[v]];
        return v;
    };
    for (const auto& [a, b, c] : wrapped.triangles) {
        root[find(b)] = find(a);
        root[find(c)] = find(a);
    }
    std::map<std::uint32_t, std::uint64_t> pieces;
    for (const mesh::Triangle& t : wrapped.triangles) ++pieces[find(t[0])];
    EXPECT_EQ(pieces.size(), 1u);
}

TEST(Surroundings, SheetIsSeenFromBothSides) {
    const mesh::Mesh sheet = mesh::with_normals(testing::flat_grid(8), 60);
    const mesh::Mesh wrapped = Surroundings(sheet, 32).wrapped();
    EXPECT_LT(error_of(sheet, wrapped).max, 8.0 / 32);
    EXPECT_NEAR(volume(wrapped), 0.0, 1e-3);
}

TEST(Surroundings, FacesCountWhatIsWrapped) {
    const mesh::Mesh sphere = testing::sphere(40);
    const Surroundings around(sphere, 32);
    EXPECT_LE(around.wrapped().triangles.size(), 2 * around.faces());
    EXPECT_GE(around.wrapped().triangles.size(), around.faces());
}

TEST(Surroundings, ExtremesAreFinite) {
    const mesh::Mesh triangle = mesh::with_normals(testing::single_triangle(), 60);
    mesh::Mesh sliver = triangle, line = triangle;
    sliver.positions = {{0, 0, 0}, {1e8f, 0, 0}, {5e7f, 1e-1f, 0}};
    line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    for (const mesh::Mesh& mesh : {triangle, sliver, line, moved(triangle, {1e30f, 0, 0}, 1e30f),
                                   moved(triangle, {0, 0, 0}, 1e-30f), moved(triangle, {1e7f, 0, 0})}) {
        for (const std::uint32_t cells : {0u, 8u, 100'000u}) {
            const Surroundings around(mesh, cells);
            EXPECT_EQ(around.visible_triangles().size(), 1u);
            for (const Vec3f& p : around.wrapped().positions) EXPECT_TRUE(all_finite(p));
        }
    }
}

}  // namespace
}  // namespace lodestream::scene
