#include "server/bake/hlod.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "common/base/transform.h"
#include "common/codec/level_codec.h"
#include "common/mesh/instances.h"
#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "server/bake/bake.h"
#include "server/bake/scene_source.h"
#include "tests/server/bake/red_and_blue.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::bake {
namespace {

using testing::add_object;
using testing::empty_scene;
using testing::moved;
using testing::spheres;

bool goes_on(double) {
    return true;
}

struct HlodTest : ::testing::Test {
    testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());

    TileTree make(const mesh::Model& model) {
        proto::Asset asset;
        asset.id = asset.name = "scene";
        EXPECT_TRUE(store.put_asset(asset).ok());
        const auto shapes = make_shape_levels(model, [] { return true; });
        EXPECT_TRUE(shapes.ok());
        const mesh::Mesh whole = mesh::flattened(model, model.shapes);
        Result<TileTree> tree = make_tiles(store, asset.id, {model, *shapes, whole}, {}, goes_on);
        EXPECT_TRUE(tree.ok()) << tree.error().message;
        return tree.ok() ? *tree : TileTree{};
    }

    codec::Decoded decoded(const TileTree& tree, std::size_t tile) {
        const store::StoredFile file = *store.file(tree.hashes[tile], "glb");
        return *codec::decode_level(*store::read_file(file.path, file.bytes));
    }

    // Without its origin, which is the asset's.
    mesh::Mesh local_content(const TileTree& tree, std::size_t tile) {
        mesh::Mesh all;
        for (const codec::Primitive& primitive : decoded(tree, tile).primitives) mesh::append(all, primitive.mesh);
        return all;
    }

    mesh::Mesh content(const TileTree& tree, std::size_t tile) {
        const Vec3d origin = decoded(tree, tile).origin;
        mesh::Mesh all = local_content(tree, tile);
        for (Vec3f& p : all.positions) p = Vec3f(Vec3d(p) + origin);
        return tree.matrices.empty() ? all : mesh::placed(std::move(all), Vec3d(0.0), tree.matrices[tile]);
    }

    // What the leaves below a tile show together.
    mesh::Mesh finest_below(const TileTree& tree, std::uint32_t tile) {
        const scene::LodNode& node = tree.nodes[tile];
        if (node.child_count == 0) return content(tree, tile);
        mesh::Mesh all;
        for (std::uint32_t i = 0; i < node.child_count; ++i)
            mesh::append(all, finest_below(tree, node.first_child + i));
        return all;
    }
};

std::uint64_t leaf_triangles(const TileTree& tree) {
    std::uint64_t triangles = 0;
    for (const scene::LodNode& node : tree.nodes) triangles += node.child_count == 0 ? node.triangles : 0;
    return triangles;
}

TEST_F(HlodTest, LeavesAreTheObjectsAndEveryTileAboveIsCoarser) {
    const mesh::Model model = spheres(6, 24);
    const TileTree tree = make(model);
    ASSERT_TRUE(scene::validate(tree.nodes).ok());
    EXPECT_EQ(leaf_triangles(tree), model.mesh.triangles.size());
    EXPECT_LE(tree.nodes.front().triangles, coarsest_tile);
    for (const scene::LodNode& node : tree.nodes) {
        if (node.child_count == 0) {
            EXPECT_EQ(node.error, 0.0);
            continue;
        }
        std::uint64_t below = 0;
        for (std::uint32_t i = 0; i < node.child_count; ++i) below += tree.nodes[node.first_child + i].triangles;
        EXPECT_LE(node.triangles, tile_triangles);
        EXPECT_LE(2 * node.triangles, below);
        EXPECT_GT(node.error, 0.0);
    }
}

// Every triangle goes to the object of the cell of `cell` units that its middle lies in.
mesh::Model split(const mesh::Mesh& mesh, double cell) {
    std::map<std::array<long, 3>, mesh::Mesh> pieces;
    for (const mesh::Triangle& t : mesh.triangles) {
        const Vec3d middle =
            (Vec3d(mesh.positions[t[0]]) + Vec3d(mesh.positions[t[1]]) + Vec3d(mesh.positions[t[2]])) / (3.0 * cell);
        mesh::Mesh& piece = pieces[{std::lround(middle.x), std::lround(middle.y), std::lround(middle.z)}];
        if (piece.positions.empty()) {
            piece.positions = mesh.positions;
            piece.normals = mesh.normals;
        }
        piece.triangles.push_back(t);
    }
    mesh::Model model = empty_scene();
    for (const auto& [where, piece] : pieces) add_object(model, mesh::compact(piece));
    return model;
}

using Edge = std::array<std::array<float, 3>, 2>;

// Edges of one triangle, where positions are the same whose bits are.
std::size_t open_edges(const mesh::Mesh& mesh) {
    std::map<Edge, int> triangles;
    for (const mesh::Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto corner = [&](std::size_t i) {
                const Vec3f& p = mesh.positions[t[i % 3]];
                return std::array<float, 3>{p.x, p.y, p.z};
            };
            const auto [low, high] = std::minmax({corner(k), corner(k + 1)});
            ++triangles[{low, high}];
        }
    return static_cast<std::size_t>(
        std::count_if(triangles.begin(), triangles.end(), [](const auto& edge) { return edge.second == 1; }));
}

// Any two tiles that share a border in the model share it in what is decoded: none of its edges is left alone.
TEST_F(HlodTest, BordersBetweenAllTilesOfATerrainAndOfASplitMeshDecodeToTheSameBits) {
    const auto height = [](double x, double z) { return std::sin(0.3 * x) * std::cos(0.2 * z); };
    struct Case {
        mesh::Mesh whole;
        double cell;
        Vec3d origin;
    };
    for (const Case& each : {Case{mesh::with_normals(testing::grid(128, height), 60), 32.0, {5e6, -3e5, 1e6}},
                             Case{testing::sphere(128), 0.6, {0, 0, 0}}}) {
        mesh::Model model = split(each.whole, each.cell);
        model.origin = each.origin;
        const TileTree tree = make(model);
        mesh::Mesh leaves;
        std::size_t count = 0, open_alone = 0;
        for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
            if (tree.nodes[i].child_count > 0) continue;
            const mesh::Mesh leaf = local_content(tree, i);
            ++count;
            open_alone += open_edges(leaf);
            mesh::append(leaves, leaf);
        }
        EXPECT_GE(count, 4u);
        EXPECT_GT(open_alone, open_edges(each.whole) + 500);
        EXPECT_EQ(leaves.triangles.size(), each.whole.triangles.size());
        EXPECT_EQ(open_edges(leaves), open_edges(each.whole));
    }
}

TEST_F(HlodTest, StatedErrorBoundsWhatIsMeasuredAgainstTheObjects) {
    const TileTree tree = make(spheres(6, 24));
    for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
        if (tree.nodes[i].child_count == 0) continue;
        const mesh::Mesh finest = finest_below(tree, i);
        const double measured = metric::measure(metric::SurfaceIndex(finest), finest, content(tree, i)).max;
        const double leaf_steps = 0.05 / codec::finest_steps_per_edge;  // the leaves are quantized too
        EXPECT_LE(measured, 1.05 * tree.nodes[i].error + leaf_steps) << i;
    }
}

TEST_F(HlodTest, BoxesHoldWhatIsDrawn) {
    for (mesh::Model model : {spheres(5, 20), testing::instanced_spheres(5, 20)}) {
        model.origin = {5e6, -3e5, 1e6};
        const TileTree tree = make(model);
        for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
            const Box& box = tree.nodes[i].box;
            const double slack = 1.0;  // single precision so far from the world's origin
            for (const Vec3f& p : content(tree, i).positions) {
                EXPECT_TRUE(glm::all(glm::lessThanEqual(box.min - slack, Vec3d(p)))) << i;
                EXPECT_TRUE(glm::all(glm::lessThanEqual(Vec3d(p), box.max + slack))) << i;
            }
        }
    }
}

TEST_F(HlodTest, InstancesShareOneContentAndShowWhatTheirObjectsWould) {
    const mesh::Model model = testing::instanced_spheres(6, 24);
    const TileTree tree = make(model);
    ASSERT_TRUE(scene::validate(tree.nodes).ok());
    EXPECT_EQ(leaf_triangles(tree), mesh::triangle_count(model));
    std::map<std::string, std::size_t> uses;
    for (const std::string& hash : tree.hashes) ++uses[hash];
    std::size_t shared = 0, others = 0;
    for (const auto& [hash, count] : uses) (count > 1 ? shared : others) += count;
    EXPECT_EQ(shared, model.instances.size());
    EXPECT_EQ(uses.size(), others + 1);

    const mesh::Mesh shown = finest_below(tree, 0), meant = mesh::flattened(model, model.shapes);
    const double leaf_steps = 0.13 / codec::finest_steps_per_edge;
    EXPECT_LE(metric::measure(metric::SurfaceIndex(meant), meant, shown).max, leaf_steps);
}

TEST_F(HlodTest, StatedErrorBoundsWhatIsMeasuredAgainstTheInstances) {
    mesh::Model model = testing::instanced_spheres(5, 24);
    for (mesh::Instance& instance : model.instances)
        instance.matrix = instance.matrix * matrix_of({0, 0, 0}, {0, 0, 0, 1}, {1.4, 1.4, 1.4});
    const TileTree tree = make(model);
    for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
        if (tree.nodes[i].child_count == 0) continue;
        const mesh::Mesh finest = finest_below(tree, i);
        const double measured = metric::measure(metric::SurfaceIndex(finest), finest, content(tree, i)).max;
        const double leaf_steps = 0.05 / codec::finest_steps_per_edge;
        EXPECT_LE(measured, 1.05 * tree.nodes[i].error + leaf_steps) << i;
    }
}

// Of a shape with more triangles than a tile has.
TEST_F(HlodTest, InstancesOfALargeShapeShareItsLevels) {
    mesh::Model model = testing::instanced_spheres(2, 90);
    const TileTree tree = make(model);
    ASSERT_TRUE(scene::validate(tree.nodes).ok());
    std::map<std::string, std::size_t> uses;
    for (const std::string& hash : tree.hashes) ++uses[hash];
    std::size_t shared = 0;
    for (const auto& [hash, count] : uses) shared += count >= model.instances.size() ? 1 : 0;
    EXPECT_EQ(shared, 3u);  // 16,020 triangles and two halvings; the object at 0 may share them too
    const SceneSource source = *SceneSource::open(store, "scene");
    for (const mesh::Instance& instance : model.instances)
        EXPECT_EQ(tree.nodes[source.tile(instance.object)].child_count, 0u);
}

TEST_F(HlodTest, AnInstanceIsKeptAsItsShapeAndComesBackAtItsPlace) {
    mesh::Model model = testing::instanced_spheres(3, 12);
    model.origin = {100, 0, -50};
    make(model);
    const SceneSource source = *SceneSource::open(store, "scene");
    ASSERT_EQ(source.objects(), model.objects);
    for (const mesh::Instance& instance : model.instances) {
        const Result<mesh::Mesh> mesh = source.mesh(instance.object);
        ASSERT_TRUE(mesh.ok());
        EXPECT_EQ(mesh->positions, mesh::placed(model.shapes[0], instance).positions);
        const Box box = mesh::bounds(*mesh);
        EXPECT_EQ(source.box(instance.object).min, box.min + model.origin);
        EXPECT_EQ(source.box(instance.object).max, box.max + model.origin);
    }
    const std::uint64_t bytes = store.content("scene", objects_key)->file.bytes;
    model.mesh = mesh::flattened(model, model.shapes);
    model.instances.clear();
    make(model);
    EXPECT_LT(2 * bytes, store.content("scene", objects_key)->file.bytes);
}

TEST_F(HlodTest, SameSceneMakesTheSameBytes) {
    const mesh::Model model = spheres(5, 20);
    const TileTree first = make(model), second = make(model);
    EXPECT_EQ(first.hashes, second.hashes);
    EXPECT_EQ(serialize(first), serialize(second));
}

TEST_F(HlodTest, LargeObjectGetsAChainOfItsOwn) {
    mesh::Model model = empty_scene();
    add_object(model, testing::sphere(200));  // 79,600 triangles
    add_object(model, moved(testing::sphere(8), {5, 0, 0}));
    const TileTree tree = make(model);
    EXPECT_EQ(leaf_triangles(tree), model.mesh.triangles.size());
    std::vector<std::uint64_t> chain;
    for (const scene::LodNode& node : tree.nodes)
        if (node.box.max.x < 2.0) chain.push_back(node.triangles);
    std::sort(chain.begin(), chain.end());
    EXPECT_EQ(chain, (std::vector<std::uint64_t>{7'680, 9'950, 19'900, 39'800, 79'600}));
}

TEST_F(HlodTest, GraphOfTenThousandNodesInOneChain) {
    mesh::Model model = empty_scene();
    for (std::uint32_t i = 1; i < 10'000; ++i) model.graph.parents.push_back(i - 1);
    for (std::uint32_t i = 0; i < 10'000; ++i)
        add_object(model, moved(mesh::with_normals(testing::tetrahedron(), 60), {2.0f * static_cast<float>(i), 0, 0}),
                   i);
    const TileTree tree = make(model);
    EXPECT_EQ(leaf_triangles(tree), 40'000u);
    EXPECT_LE(scene::depth(tree.nodes), 12u);
}

TEST_F(HlodTest, ObjectsInOnePlaceAndObjectsWithoutTriangles) {
    mesh::Model model = empty_scene();
    for (int i = 0; i < 40; ++i) add_object(model, testing::sphere(12));
    model.graph.object_nodes.resize(90, 0);
    const TileTree tree = make(model);
    EXPECT_EQ(leaf_triangles(tree), model.mesh.triangles.size());
}

TEST_F(HlodTest, TilesAboveTheLeavesShowNothingThatIsInside) {
    const mesh::Model model = testing::hull_with_cargo(60);
    const TileTree tree = make(model);
    EXPECT_EQ(leaf_triangles(tree), model.mesh.triangles.size());
    for (const Vec3f& p : content(tree, 0).positions) EXPECT_GT(length(p), 4.0f);
}

TEST_F(HlodTest, MaterialsBecomeOneImageWhereObjectsAreJoined) {
    const TileTree tree = make(testing::layer_of_cubes(30));
    const store::StoredFile file = *store.file(tree.hashes[0], "glb");
    codec::Decoded root = *codec::decode_level(*store::read_file(file.path, file.bytes));
    ASSERT_EQ(root.primitives.size(), 1u);
    ASSERT_EQ(root.materials.size(), 1u);
    ASSERT_EQ(root.images.size(), 1u);
    mesh::Model model;
    model.materials = root.materials;
    model.images = root.images;
    testing::expect_red_and_blue(model, root.primitives[0].mesh, 30);
}

TEST_F(HlodTest, TexturesAndMasksAreKept) {
    mesh::Model model = spheres(6, 24);
    model.mesh.texture_coordinates.assign(model.mesh.positions.size(), Vec2f(0.5f));
    model.materials[0].alpha_mode = mesh::AlphaMode::mask;
    const TileTree tree = make(model);
    const store::StoredFile file = *store.file(tree.hashes[0], "glb");
    const codec::Decoded root = *codec::decode_level(*store::read_file(file.path, file.bytes));
    EXPECT_EQ(root.materials[0].alpha_mode, mesh::AlphaMode::mask);
}

TEST_F(HlodTest, SceneOfTwoTrianglesIsOneTile) {
    mesh::Model model = empty_scene();
    const mesh::Mesh triangle = mesh::with_normals(testing::single_triangle(), 60);
    add_object(model, triangle);
    add_object(model, moved(triangle, {1e7f, 0, 0}));
    const TileTree tree = make(model);
    EXPECT_EQ(tree.nodes.size(), 1u);
    EXPECT_EQ(tree.nodes.front().triangles, 2u);
}

TEST_F(HlodTest, CancelledBakeSaysSo) {
    proto::Asset asset;
    asset.id = asset.name = "scene";
    ASSERT_TRUE(store.put_asset(asset).ok());
    const mesh::Model model = spheres(4, 24);
    const auto tree = make_tiles(store, "scene", {model, {}, model.mesh}, {}, [](double share) { return share < 0.3; });
    ASSERT_FALSE(tree.ok());
    EXPECT_EQ(tree.error().code, ErrorCode::unavailable);
}

TEST_F(HlodTest, BakedSceneTellsOfItsTilesAndOneObjectHasAChain) {
    proto::Asset asset;
    asset.id = asset.name = "scene";
    const Result<proto::Asset> scene = bake(store, asset, spheres(4, 24));
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    ASSERT_TRUE(scene->hierarchy);
    const Result<TileTree> tiles = load_tiles(store, *scene);
    ASSERT_TRUE(tiles.ok()) << tiles.error().message;
    EXPECT_EQ(scene->hierarchy->tiles, tiles->nodes.size());
    EXPECT_EQ(scene->hierarchy->max_error, tiles->nodes.front().error);

    asset.id = asset.name = "single";
    mesh::Model single = empty_scene();
    single.graph = {};
    single.mesh = testing::sphere(24);
    const Result<proto::Asset> one = bake(store, asset, single);
    ASSERT_TRUE(one.ok()) << one.error().message;
    EXPECT_FALSE(one->hierarchy);
    EXPECT_EQ(load_tiles(store, *one)->nodes.size(), one->levels.size());
}

}  // namespace
}  // namespace lodestream::bake
