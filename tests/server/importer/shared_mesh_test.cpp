// Meshes that several nodes show.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "common/mesh/instances.h"
#include "common/mesh/operations.h"
#include "tests/server/importer/gltf_builder.h"
#include "tests/server/importer/sane.h"

namespace lodestream::importer {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using namespace lodestream::testing;

constexpr std::uint16_t side = 65;  // vertices of the wave: 8,192 triangles
constexpr std::uint64_t wave_triangles = 2ull * (side - 1) * (side - 1);
static_assert(wave_triangles >= least_saved_triangles);

// A wave around (2, 0, 0) as accessors 0 (positions) and 1 (indices), the triangle of triangle_builder() as 2.
GltfBuilder wave_builder() {
    BinaryWriter positions, indices;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
            positions.put_all<float>({1.0f + static_cast<float>(x) / 32.0f,
                                      0.25f * std::sin(0.25f * static_cast<float>(x)),
                                      static_cast<float>(y) / 32.0f - 1.0f});
    for (std::uint16_t y = 0; y + 1 < side; ++y)
        for (std::uint16_t x = 0; x + 1 < side; ++x) {
            const auto a = static_cast<std::uint16_t>(y * side + x), b = static_cast<std::uint16_t>(a + side);
            const auto c = static_cast<std::uint16_t>(a + 1), d = static_cast<std::uint16_t>(b + 1);
            indices.put_all<std::uint16_t>({a, b, c, c, b, d});
        }
    GltfBuilder builder;
    builder.accessor(builder.view(positions.data()), gl_float, side * side, "VEC3");
    builder.accessor(builder.view(indices.data()), gl_unsigned_short, 3 * wave_triangles, "SCALAR");
    builder.accessor(builder.view(floats({0, 0, 0, 1, 0, 0, 0, 1, 0})), gl_float, 3, "VEC3");
    return builder;
}

const std::string wave = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}";
const std::string small = "{\"primitives\":[{\"attributes\":{\"POSITION\":2}}]}";
const std::string meshes = "\"meshes\":[" + wave + "," + wave + "," + wave + "," + small + "]";

Result<mesh::Model> import_nodes(const std::string& nodes, const Limits& limits = {}) {
    return import_glb(wave_builder().glb(meshes + ",\"nodes\":[" + nodes + "]"), no_side_files(), limits);
}

// Corners of all that is shown in the world, in an order of their own.
std::vector<std::array<double, 3>> shown(const mesh::Model& model) {
    const mesh::Mesh all = mesh::flattened(model, model.shapes);
    std::vector<std::array<double, 3>> corners;
    for (const mesh::Triangle& t : all.triangles)
        for (const std::uint32_t v : t) {
            const Vec3d p = Vec3d(all.positions[v]) + model.origin;
            corners.push_back({std::round(1e4 * p.x), std::round(1e4 * p.y), std::round(1e4 * p.z)});
        }
    std::ranges::sort(corners);
    return corners;
}

double area_of(const mesh::Mesh& mesh) {
    double area = 0.0;
    for (const auto& [a, b, c] : mesh.triangles)
        area += 0.5 * length(cross(Vec3d(mesh.positions[b]) - Vec3d(mesh.positions[a]),
                                   Vec3d(mesh.positions[c]) - Vec3d(mesh.positions[a])));
    return area;
}

TEST(ImportSharedMeshes, AreKeptOnceAndShowWhatCopiesDo) {
    const std::string places[] = {"\"translation\":[5,0,0]", "\"rotation\":[0,0.6,0,0.8],\"scale\":[1,3,0.5]",
                                  "\"matrix\":[0,2,0,0, -2,0,0,0, 0,0,2,0, 1,2,3,1]"};
    std::string shared, copies;
    for (int i = 0; i < 3; ++i) {
        shared += std::string(i > 0 ? "," : "") + "{\"mesh\":0," + places[i] + "}";
        copies += std::string(i > 0 ? "," : "") + "{\"mesh\":" + std::to_string(i) + "," + places[i] + "}";
    }
    const auto once = import_nodes(shared), thrice = import_nodes(copies);
    ASSERT_TRUE(once.ok() && thrice.ok()) << once.error().message;
    expect_sane(*once, "shared");
    EXPECT_THAT(once->shapes, SizeIs(1));
    EXPECT_THAT(once->instances, SizeIs(3));
    EXPECT_THAT(once->mesh.triangles, IsEmpty());
    EXPECT_THAT(thrice->shapes, IsEmpty());
    EXPECT_EQ(once->objects, 3u);
    EXPECT_EQ(once->kind, mesh::Kind::scene);
    EXPECT_EQ(once->graph.object_nodes, thrice->graph.object_nodes);
    EXPECT_EQ(mesh::triangle_count(*once), 3 * wave_triangles);
    EXPECT_EQ(shown(*once), shown(*thrice));
}

TEST(ImportSharedMeshes, FewTrianglesStayInTheMeshBesideInstances) {
    const auto model = import_nodes("{\"mesh\":3},{\"mesh\":0},{\"mesh\":3,\"translation\":[0,9,0]},{\"mesh\":0}");
    ASSERT_TRUE(model.ok()) << model.error().message;
    expect_sane(*model, "both");
    EXPECT_THAT(model->mesh.triangles, SizeIs(2));
    EXPECT_THAT(model->shapes, SizeIs(1));
    EXPECT_THAT(model->instances, SizeIs(2));
    for (const mesh::Instance& instance : model->instances)
        EXPECT_THAT(model->mesh.triangle_objects, ::testing::Not(::testing::Contains(instance.object)));
}

TEST(ImportSharedMeshes, OneThatIsShownOnceStaysInTheMesh) {
    const auto model = import_nodes("{\"mesh\":0},{\"mesh\":3}");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_THAT(model->shapes, IsEmpty());
    EXPECT_THAT(model->mesh.triangles, SizeIs(wave_triangles + 1));
}

TEST(ImportSharedMeshes, WhatSavesLittleStaysInTheMesh) {
    GltfBuilder b = wave_builder();  // a strip of it, which two of do not save enough
    const std::uint64_t strip = least_shared_triangles, enough = least_saved_triangles / strip + 1;
    b.accessor(1, gl_unsigned_short, 3 * strip, "SCALAR");
    for (const std::uint64_t count : {std::uint64_t{2}, enough - 1, enough}) {
        std::string nodes = "{\"mesh\":0}";
        for (std::uint64_t i = 1; i < count; ++i) nodes += ",{\"mesh\":0}";
        const auto model =
            import_glb(b.glb(mesh_of("\"attributes\":{\"POSITION\":0},\"indices\":3") + ",\"nodes\":[" + nodes + "]"));
        ASSERT_TRUE(model.ok()) << model.error().message;
        EXPECT_THAT(model->instances, SizeIs(count == enough ? count : 0)) << count;
        EXPECT_EQ(mesh::triangle_count(*model), count * strip);
    }
}

TEST(ImportSharedMeshes, MirroredNodesShowAShapeOfTheirOwn) {
    const std::string nodes =
        "{\"mesh\":0},{\"mesh\":0,\"translation\":[9,0,0]},{\"mesh\":0,\"scale\":[-1,1,1]},"
        "{\"mesh\":0,\"scale\":[1,1,-2]}";
    const auto model = import_nodes(nodes);
    ASSERT_TRUE(model.ok()) << model.error().message;
    expect_sane(*model, "mirrored");  // no matrix mirrors
    EXPECT_THAT(model->shapes, SizeIs(2));
    EXPECT_THAT(model->instances, SizeIs(4));
    // The wave faces up wherever it is, as its normals do.
    const mesh::Mesh all = mesh::flattened(*model, model->shapes);
    for (const mesh::Triangle& t : all.triangles) {
        const auto corner = [&](std::size_t k) { return Vec3d(all.positions[t[k]]); };
        const Vec3d facing = cross(corner(1) - corner(0), corner(2) - corner(0));
        ASSERT_GT(dot(facing, Vec3d(all.normals[t[0]])), 0.0);
        ASSERT_GT(facing.y, 0.0);
    }
}

TEST(ImportSharedMeshes, AMirroredOneAloneStaysInTheMesh) {
    const auto model = import_nodes("{\"mesh\":0},{\"mesh\":0},{\"mesh\":0,\"scale\":[-1,1,1]}");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_THAT(model->instances, SizeIs(2));
    EXPECT_THAT(model->mesh.triangles, SizeIs(wave_triangles));
}

TEST(ImportSharedMeshes, ScaledToNothingTheyAreDropped) {
    const auto model = import_nodes("{\"mesh\":0},{\"mesh\":0,\"scale\":[0,0,0]},{\"mesh\":0,\"translation\":[9,0,0]}");
    ASSERT_TRUE(model.ok()) << model.error().message;
    expect_sane(*model, "nothing");
    EXPECT_THAT(model->instances, SizeIs(2));
    EXPECT_EQ(mesh::triangle_count(*model), 2 * wave_triangles);
    EXPECT_TRUE(mentions(model.warnings, "dropped"));
}

TEST(ImportSharedMeshes, FlattenedOnesAreInTheMesh) {
    const auto model = import_nodes("{\"mesh\":0},{\"mesh\":0,\"scale\":[1,0,1]},{\"mesh\":0}");
    ASSERT_TRUE(model.ok()) << model.error().message;
    expect_sane(*model, "flat");
    EXPECT_THAT(model->instances, SizeIs(2));
    EXPECT_NEAR(area_of(model->mesh), 4.0, 1e-3);
}

TEST(ImportSharedMeshes, PlacesBeyondWhatTilesHaveAreInTheMesh) {
    for (const char* place : {"\"scale\":[1e9,1e9,1e9]", "\"scale\":[1e-9,1,1]", "\"translation\":[1e13,0,0]",
                              "\"matrix\":[1,0,0,0.5, 0,1,0,0, 0,0,1,0, 0,0,0,1]"}) {
        const auto model = import_nodes(std::string("{\"mesh\":0},{\"mesh\":0},{\"mesh\":0,") + place + "}");
        ASSERT_TRUE(model.ok()) << place << ": " << model.error().message;
        expect_sane(*model, place);
        EXPECT_THAT(model->instances, SizeIs(2)) << place;
    }
}

TEST(ImportSharedMeshes, FarAwayTheyKeepMillimetres) {
    const auto model = import_nodes(
        "{\"mesh\":0,\"translation\":[10000000.001,0,-5000000.002]},{\"mesh\":0,\"translation\":[10000005,0,-5000000]"
        "}");
    ASSERT_TRUE(model.ok()) << model.error().message;
    ASSERT_THAT(model->instances, SizeIs(2));
    EXPECT_GT(length(model->origin), 1e6);
    const Vec3d first(mesh::placed(model->shapes[0], model->instances[0]).positions[0]);
    const Vec3d own(model->shapes[0].positions[0]);
    EXPECT_LT(distance(first + model->origin, own + Vec3d(10000000.001, 0, -5000000.002)), 1e-5);
}

TEST(ImportSharedMeshes, GpuInstancesAreInstances) {
    GltfBuilder b = wave_builder();
    b.accessor(b.view(floats({0, 0, 0, 5, 0, 0, 0, 7, 0})), gl_float, 3, "VEC3");
    const auto model = import_glb(b.glb("\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"]," + meshes +
                                        ",\"nodes\":[{\"mesh\":0,\"translation\":[1,0,0],\"extensions\":{"
                                        "\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":3}}}}]"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    ASSERT_THAT(model->instances, SizeIs(3));
    EXPECT_THAT(model->shapes, SizeIs(1));
    EXPECT_EQ(Vec3d(model->instances[1].matrix[3]), Vec3d(6, 0, 0));
}

TEST(ImportSharedMeshes, NodesWithASkinHaveTrianglesOfTheirOwn) {
    GltfBuilder b = wave_builder();
    std::string joints, weights;
    for (int i = 0; i < side * side; ++i) {
        joints += std::string(4, '\0');
        weights += floats({1, 0, 0, 0});
    }
    b.accessor(b.view(joints), gl_unsigned_byte, side * side, "VEC4");
    b.accessor(b.view(weights), gl_float, side * side, "VEC4");
    const auto model = import_glb(
        b.glb("\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":3,\"WEIGHTS_0\":4},"
              "\"indices\":1}]}],\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"skin\":0},{\"mesh\":0,\"skin\":0},{\"mesh\":0},"
              "{\"translation\":[0,50,0]}],\"skins\":[{\"joints\":[4]}]"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_THAT(model->instances, SizeIs(2));
    EXPECT_THAT(model->mesh.triangles, SizeIs(2 * wave_triangles));
    EXPECT_GT(mesh::bounds(model->mesh).min.y + model->origin.y, 49.0);
}

TEST(ImportSharedMeshes, BringTheirMaterialsAndLeaveOutTheRest) {
    const std::string primitive = "{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":";
    const auto model = import_glb(wave_builder().glb(
        "\"materials\":[{\"name\":\"unused\"},{\"name\":\"red\"},{\"name\":\"blue\"}],\"meshes\":[{\"primitives\":[" +
        primitive + "2}," + primitive + "1}]}],\"nodes\":[{\"mesh\":0},{\"mesh\":0}]"));
    ASSERT_TRUE(model.ok()) << model.error().message;
    expect_sane(*model, "materials");
    ASSERT_THAT(model->shapes, SizeIs(1));
    ASSERT_THAT(model->materials, SizeIs(2));
    const std::vector<std::uint32_t>& used = model->shapes[0].triangle_materials;
    ASSERT_THAT(used, SizeIs(2 * wave_triangles));
    EXPECT_EQ(model->materials[used.front()].name, "blue");
    EXPECT_EQ(model->materials[used.back()].name, "red");
}

TEST(ImportSharedMeshes, CountOnceAgainstTheLimitsButAreShownWithinTheirs) {
    std::string nodes = "{\"mesh\":0}";
    for (int i = 0; i < 99; ++i) nodes += ",{\"mesh\":0}";
    Limits limits;
    limits.triangles = wave_triangles;
    EXPECT_TRUE(import_nodes(nodes, limits).ok());
    limits.shown_triangles = 100 * wave_triangles;
    EXPECT_TRUE(import_nodes(nodes, limits).ok());
    --limits.shown_triangles;
    const auto refused = import_nodes(nodes, limits);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::limit_exceeded);
    EXPECT_THAT(refused.error().message, HasSubstr("more than the limit of"));
}

}  // namespace
}  // namespace lodestream::importer
