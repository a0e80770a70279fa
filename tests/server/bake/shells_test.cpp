#include "server/bake/shells.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/mesh/operations.h"
#include "server/bake/bake.h"
#include "server/bake/scene_colors.h"
#include "tests/server/bake/red_and_blue.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::bake {
namespace {

using testing::add_object;
using testing::empty_scene;
using testing::moved;

mesh::Mesh cut(const Shell& shell, std::uint64_t triangles) {
    return cut_shell(shell, triangles);
}

bool goes_on(double) {
    return true;
}

// What a bake gives make_shells().
struct Scene {
    BakedModel baked;
    mesh::Mesh finest;

    explicit Scene(const mesh::Model& model) : baked(describe_model(model)) {
        set_history(baked, *simplify::record_history(mesh::compact(model.mesh)));
        finest = cut(model.mesh.triangles.size());
        const metric::SurfaceIndex original(finest);
        for (std::uint64_t count = finest.triangles.size(); count > 0; count /= 2)
            baked.errors.push_back({count, metric::measure(original, finest, cut(count))});
        baked.errors = in_order(std::move(baked.errors));
    }
    mesh::Mesh cut(std::uint64_t count) const { return simplify::cut(baked.history, count); }
    std::vector<Shell> shells() const { return *make_shells(baked, finest, goes_on); }
};

TEST(Shells, SpendNoTriangleOnWhatIsHidden) {
    const Scene scene(testing::hull_with_cargo(32));
    const std::vector<Shell> shells = scene.shells();
    for (const std::uint64_t count : {1'000u, 500u, 100u}) {
        const Shell* shell = shell_for(shells, count);
        ASSERT_TRUE(shell) << count;
        const mesh::Mesh level = cut(*shell, count);
        EXPECT_LE(level.triangles.size(), count);
        EXPECT_GE(level.triangles.size(), count - 1);
        for (const Vec3f& p : level.positions) EXPECT_GT(length(p), 4.0f) << count;
    }
}

TEST(Shells, StatedErrorsBoundWhatIsMeasured) {
    const Scene scene(testing::hull_with_cargo(32));
    const mesh::Mesh hull = moved(testing::sphere(32), {0, 0, 0}, 5.0f);
    const metric::SurfaceIndex outside(hull), everything(scene.finest);
    const std::vector<Shell> shells = scene.shells();
    for (const std::uint64_t count : {1'000u, 640u, 480u, 100u}) {
        const Shell* shell = shell_for(shells, count);
        ASSERT_TRUE(shell) << count;
        const mesh::Mesh level = cut(*shell, count);
        EXPECT_LE(metric::measure(outside, hull, level).rms, 1.05 * error_of(shell->seen_errors, count).rms) << count;
        EXPECT_LE(metric::measure(everything, scene.finest, level).rms, 1.05 * error_of(shell->baked.errors, count).rms)
            << count;
        EXPECT_LT(error_of(shell->seen_errors, count).rms, error_of(shell->baked.errors, count).rms) << count;
    }
}

TEST(Shells, GiveTheirLevelsNormalsNearThoseOfTheTriangles) {
    const Scene scene(testing::hull_with_cargo(32));
    const std::vector<Shell> shells = scene.shells();
    ASSERT_FALSE(shells.empty());
    for (const Shell& shell : shells) {
        const mesh::Mesh level = cut_shell(shell, 200);
        ASSERT_EQ(level.normals.size(), shell.colored_by.empty() ? level.positions.size() : 0u);
        if (level.normals.empty()) continue;
        for (const auto& [a, b, c] : level.triangles) {
            const Vec3d origin(level.positions[a]);
            const Vec3d across = cross(Vec3d(level.positions[b]) - origin, Vec3d(level.positions[c]) - origin);
            for (const std::uint32_t corner : {a, b, c})
                EXPECT_GE(dot(Vec3d(level.normals[corner]), across), 0.49 * length(across));
        }
    }
}

TEST(Shells, ACoarserOneIsNeverSaidToBeBetterThanTheScenesOwnFinerLevels) {
    const Scene scene(testing::hull_with_cargo(32));
    for (const Shell& shell : scene.shells()) {
        const std::uint64_t most = shell.seen_errors.front().triangles;
        EXPECT_TRUE(validate_errors(shell.seen_errors).ok());
        EXPECT_TRUE(validate_errors(shell.baked.errors).ok());
        EXPECT_LE(most, scene.finest.triangles.size() / 2);
        EXPECT_EQ(shell.baked.errors.front().triangles, most);
        for (const ErrorSample& finer : scene.baked.errors) {
            if (finer.triangles <= most) continue;
            EXPECT_LE(finer.error.rms, shell.baked.errors.front().error.rms);
        }
    }
}

TEST(Shells, JoinPiecesThatTheSceneCannot) {
    const Scene scene(testing::layer_of_cubes(12));
    const std::vector<Shell> shells = scene.shells();
    const Shell* shell = shell_for(shells, 200);
    ASSERT_TRUE(shell);
    mesh::Mesh block = moved(testing::layer_of_cubes(1).mesh, {0, 0, 0}, 1.0f);
    for (Vec3f& p : block.positions) p = p / 0.48f * Vec3f(5.98f, 0.48f, 5.98f) + Vec3f(5.5f, 0, 5.5f);
    const metric::SurfaceIndex original(block);
    EXPECT_LT(metric::measure(original, block, cut(*shell, 200)).rms,
              0.5 * metric::measure(original, block, scene.cut(200)).rms);
}

TEST(Shells, AreBareAndNameWhatColoursThem) {
    const Scene scene(testing::layer_of_cubes(12));
    const std::vector<Shell> shells = scene.shells();
    const Shell* shell = shell_for(shells, 200);
    ASSERT_TRUE(shell);
    ASSERT_FALSE(shell->colored_by.empty());
    EXPECT_TRUE(shell->baked.history.normals.empty());
    EXPECT_TRUE(shell->baked.model.images.empty());
    const SceneColors colors(scene.baked.model, mesh::part(scene.finest, shell->colored_by));
    const Result<mesh::Model> painted = colors.paint(cut(*shell, 200));
    ASSERT_TRUE(painted.ok()) << painted.error().message;
    testing::expect_red_and_blue(*painted, painted->mesh, 12);
}

TEST(Shells, NothingIsPaintedOverMasks) {
    mesh::Model model = testing::spheres(4, 12);
    model.materials[0].alpha_mode = mesh::AlphaMode::mask;
    for (const Shell& shell : Scene(model).shells()) {
        EXPECT_TRUE(shell.colored_by.empty());
        EXPECT_EQ(shell.baked.model.materials.size(), 1u);
    }
}

TEST(Shells, OfFlatAndOfScatteredScenes) {
    mesh::Model sheet = empty_scene();
    for (int i = 0; i < 3; ++i)
        add_object(sheet, moved(mesh::with_normals(testing::flat_grid(20), 60), {20.0f * i, 0, 0}));
    mesh::Model far_apart = empty_scene();
    add_object(far_apart, testing::sphere(12));
    add_object(far_apart, moved(testing::sphere(12), {1e7f, 0, 0}));
    mesh::Model two = empty_scene();
    add_object(two, mesh::with_normals(testing::single_triangle(), 60));
    add_object(two, mesh::with_normals(testing::single_triangle(), 60));
    for (const mesh::Model* model : {&sheet, &far_apart, &two}) {
        const std::vector<Shell> shells = Scene(*model).shells();
        for (const std::uint64_t count : {1u, 2u, 50u, 7'680u})
            if (const Shell* shell = shell_for(shells, count)) {
                const mesh::Mesh level = cut(*shell, count);
                EXPECT_GE(level.triangles.size(), 1u);
                EXPECT_LE(level.triangles.size(), count);
                for (const Vec3f& p : level.positions) EXPECT_TRUE(all_finite(Vec3d(p)));
            }
    }
}

TEST(Shells, AreCancelled) {
    const Scene scene(testing::spheres(4, 24));
    const auto shells = make_shells(scene.baked, scene.finest, [](double share) { return share < 0.3; });
    ASSERT_FALSE(shells.ok());
    EXPECT_EQ(shells.error().code, ErrorCode::unavailable);
}

TEST(ShellFor, IsTheCoarsestThatReaches) {
    std::vector<Shell> shells(2);
    shells[0].seen_errors = {{100, {}}, {50, {}}};
    shells[1].seen_errors = {{400, {}}};
    EXPECT_EQ(shell_for(shells, 1), &shells[0]);
    EXPECT_EQ(shell_for(shells, 100), &shells[0]);
    EXPECT_EQ(shell_for(shells, 101), &shells[1]);
    EXPECT_EQ(shell_for(shells, 401), nullptr);
}

TEST(StoredShell, ComesBackAsItWentAndRefusesDamage) {
    const std::vector<Shell> shells = Scene(testing::layer_of_cubes(4)).shells();
    ASSERT_FALSE(shells.empty());
    const Shell& shell = shells.front();
    const std::vector<std::byte> bytes = serialize(shell);
    const Result<ShellView> back = open_shell(bytes);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->colored_by, shell.colored_by);
    EXPECT_EQ(back->seen_errors.size(), shell.seen_errors.size());
    const mesh::Mesh before = cut(shell, 40), after = simplify::cut(back->baked.history, 40);
    EXPECT_EQ(after.positions, before.positions);

    for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 64)
        EXPECT_FALSE(open_shell(std::span(bytes).first(size)).ok()) << size;
    for (std::size_t i = 0; i < bytes.size(); i += 1 + i / 500) {
        std::vector<std::byte> damaged = bytes;
        damaged[i] ^= std::byte{0xff};
        const Result<ShellView> opened = open_shell(damaged);
        if (!opened) continue;
        for (const std::uint64_t n : {1u, 17u, 60u})
            EXPECT_LE(simplify::cut(opened->baked.history, n).triangles.size(), n);
    }
}

TEST(ShellsOfABake, AreInTheStoreForAScene) {
    testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());
    proto::Asset asset;
    asset.id = asset.name = "scene";
    ASSERT_TRUE(bake(store, asset, testing::hull_with_cargo(32)).ok());
    EXPECT_TRUE(store.content("scene", shell_key(0)).ok());
}

}  // namespace
}  // namespace lodestream::bake
