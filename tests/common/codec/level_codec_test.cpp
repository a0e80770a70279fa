#include "common/codec/level_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <tuple>

#include "common/codec/glb.h"
#include "common/codec/lean_shading.h"
#include "common/mesh/operations.h"
#include "tests/support/meshes.h"

namespace lodestream::codec {
namespace {

using mesh::Mesh;
using mesh::Model;

constexpr double normal_tolerance = 0.02;  // radians, of 8-bit octahedral normals
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

std::vector<std::uint8_t> shaded(const Mesh& mesh, std::uint8_t gouraud) {
    return std::vector<std::uint8_t>(mesh.triangles.size(), gouraud);
}

std::vector<std::uint8_t> first_half_gouraud(const Mesh& mesh) {
    std::vector<std::uint8_t> result = shaded(mesh, 0);
    std::fill(result.begin(), result.begin() + static_cast<std::ptrdiff_t>(result.size() / 2), std::uint8_t{1});
    return result;
}

Model model_of_one_material() {
    Model model;
    model.materials.resize(1);
    return model;
}

mesh::Image png_image() {
    mesh::Image image;
    image.media_type = "image/png";
    for (const int byte : {0x89,     int{'P'}, int{'N'}, int{'G'}, 0x0d, 0x0a, 0x1a, 0x0a, 0, 0, 0, 13,
                           int{'I'}, int{'H'}, int{'D'}, int{'R'}, 0,    0,    0,    2,    0, 0, 0, 3})
        image.bytes.push_back(static_cast<std::byte>(byte));
    return image;
}

EncodeOptions options_for(const Mesh& mesh) {
    EncodeOptions options;
    options.grid = choose_grid(mesh::bounds(mesh), 0.0, 0.1);
    options.rounding = Rounding::nearest;
    return options;
}

struct Coded {
    Encoded encoded;
    Decoded decoded;
};

Coded round_trip(const Model& model, const Mesh& level, std::span<const std::uint8_t> gouraud,
                 const EncodeOptions& options) {
    Result<Encoded> encoded = encode_level(model, level, gouraud, options);
    EXPECT_TRUE(encoded.ok()) << encoded.error().message;
    if (!encoded) return {};
    Result<Decoded> decoded = decode_level(encoded->glb);
    EXPECT_TRUE(decoded.ok()) << decoded.error().message;
    if (!decoded) return {std::move(*encoded), {}};
    return {std::move(*encoded), std::move(*decoded)};
}

Coded round_trip(const Mesh& level, std::span<const std::uint8_t> gouraud) {
    return round_trip(model_of_one_material(), level, gouraud, options_for(level));
}

using GridPoint = std::array<std::int64_t, 3>;
using GridTriangle = std::array<GridPoint, 3>;

GridPoint on_grid(const Vec3f& p, const QuantizationGrid& grid) {
    GridPoint result;
    for (int axis = 0; axis < 3; ++axis)
        result[axis] = static_cast<std::int64_t>(
            std::floor((static_cast<double>(p[axis]) - grid.origin[axis]) / grid.step() + 0.5));
    return result;
}

GridTriangle least_rotation(const GridTriangle& t) {
    return std::min({t, GridTriangle{t[1], t[2], t[0]}, GridTriangle{t[2], t[0], t[1]}});
}

template <class Use>
std::vector<GridTriangle> triangle_set(const Mesh& mesh, const QuantizationGrid& grid, Use use) {
    std::vector<GridTriangle> result;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!use(t)) continue;
        const auto& [a, b, c] = mesh.triangles[t];
        result.push_back(least_rotation(
            {on_grid(mesh.positions[a], grid), on_grid(mesh.positions[b], grid), on_grid(mesh.positions[c], grid)}));
    }
    std::sort(result.begin(), result.end());
    return result;
}

// Gouraud and flat triangles each arrive as the same set, rotated at most.
void expect_same_triangles(const Mesh& level, std::span<const std::uint8_t> gouraud, const Decoded& decoded,
                           const QuantizationGrid& grid) {
    for (const Shading shading : {Shading::gouraud, Shading::flat}) {
        std::vector<GridTriangle> arrived;
        for (const Primitive& primitive : decoded.primitives) {
            if (primitive.shading != shading) continue;
            const auto triangles = triangle_set(primitive.mesh, grid, [](std::size_t) { return true; });
            arrived.insert(arrived.end(), triangles.begin(), triangles.end());
        }
        std::sort(arrived.begin(), arrived.end());
        EXPECT_EQ(arrived, triangle_set(level, grid, [&](std::size_t t) {
                      return (gouraud[t] != 0) == (shading == Shading::gouraud);
                  }));
    }
}

Mesh sphere_with_everything() {
    Mesh mesh = testing::sphere(10);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        mesh.texture_coordinates.emplace_back(mesh.positions[v].x * 0.5f + 0.5f, mesh.positions[v].y * 0.5f + 0.5f);
        mesh.colors.emplace_back(static_cast<std::uint8_t>(v), 10, static_cast<std::uint8_t>(255 - v), 255);
    }
    return mesh;
}

TEST(LevelCodec, RoundTripsEveryCombinationOfAttributes) {
    for (int combination = 0; combination < 32; ++combination) {
        SCOPED_TRACE(combination);
        Mesh level = sphere_with_everything();
        Model model = model_of_one_material();
        const bool normals = combination & 1, texture = combination & 2, colors = combination & 4,
                   split = combination & 8;
        if (!normals) level.normals.clear();
        if (!colors) level.colors.clear();
        if (texture) {
            model.images.push_back(png_image());
            model.materials[0].base_color_texture.image = 0;
        }
        const auto gouraud = !normals ? shaded(level, 0) : split ? first_half_gouraud(level) : shaded(level, 1);
        EncodeOptions options = options_for(level);
        options.lean = combination & 16;
        const Coded coded = round_trip(model, level, gouraud, options);
        EXPECT_EQ(coded.encoded.triangles, level.triangles.size());
        EXPECT_EQ(coded.decoded.primitives.size(), normals && split ? 2u : 1u);
        expect_same_triangles(level, gouraud, coded.decoded, options.grid);
        for (const Primitive& primitive : coded.decoded.primitives) {
            EXPECT_EQ(primitive.mesh.normals.empty(), primitive.shading == Shading::flat);
            EXPECT_EQ(primitive.mesh.texture_coordinates.empty(), !texture);
            EXPECT_EQ(primitive.mesh.colors.empty(), !colors);
        }
    }
}

TEST(LevelCodec, AttributesStayWithinTheirBounds) {
    const Mesh level = sphere_with_everything();
    Model model = model_of_one_material();
    model.images.push_back(png_image());
    model.materials[0].emissive_texture.image = 0;
    const EncodeOptions options = options_for(level);
    const Coded coded = round_trip(model, level, shaded(level, 1), options);
    std::map<GridPoint, std::size_t> source;
    for (std::size_t v = 0; v < level.positions.size(); ++v) source[on_grid(level.positions[v], options.grid)] = v;
    ASSERT_EQ(coded.decoded.primitives.size(), 1u);
    const Mesh& mesh = coded.decoded.primitives[0].mesh;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const auto found = source.find(on_grid(mesh.positions[v], options.grid));
        ASSERT_NE(found, source.end());
        const std::size_t s = found->second;
        EXPECT_LT(glm::length(Vec3d(mesh.normals[v]) - Vec3d(level.normals[s])), normal_tolerance);
        EXPECT_LT(glm::length(mesh.texture_coordinates[v] - level.texture_coordinates[s]), 1.0f / 4095.0f);
        EXPECT_EQ(mesh.colors[v], level.colors[s]);
    }
}

TEST(LevelCodec, PositionsMoveByHalfAStepAtMostOnAnyGrid) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (int bits = min_position_bits; bits <= max_position_bits; bits += 2)
        for (const double size : {1e-30, 1e-6, 1.0, 3.14159e4, 1e30}) {
            SCOPED_TRACE(std::to_string(bits) + " bits, size " + std::to_string(size));
            Mesh level = testing::sphere(6);
            for (Vec3f& p : level.positions)
                p = Vec3f((Vec3d(p) + 0.1 * Vec3d(unit(random), unit(random), unit(random))) * size);
            EncodeOptions options = options_for(level);
            options.grid.bits = bits;
            const Coded coded = round_trip(model_of_one_material(), level, shaded(level, 0), options);
            expect_same_triangles(level, shaded(level, 0), coded.decoded, options.grid);
            const double bound = options.grid.step() * 0.5 + options.grid.range * 1e-6;
            ASSERT_EQ(coded.decoded.primitives.size(), 1u);
            for (const Vec3f& p : coded.decoded.primitives[0].mesh.positions) {
                const bool near = std::any_of(level.positions.begin(), level.positions.end(), [&](const Vec3f& s) {
                    const Vec3d d = glm::abs(Vec3d(s) - Vec3d(p));
                    return std::max({d.x, d.y, d.z}) <= bound;
                });
                EXPECT_TRUE(near);
            }
        }
}

TEST(LevelCodec, BorderBetweenGouraudAndFlatIsIdenticalBitForBit) {
    Mesh level =
        testing::grid(12, [](std::uint32_t x, std::uint32_t z) { return std::sin(0.7 * x) + std::cos(1.3 * z); });
    level = mesh::with_normals(level, 180.0);
    std::vector<std::uint8_t> gouraud;
    for (std::size_t t = 0; t < level.triangles.size(); ++t) gouraud.push_back(t % 3 == 0);
    const EncodeOptions options = options_for(level);
    const Coded coded = round_trip(model_of_one_material(), level, gouraud, options);
    ASSERT_EQ(coded.decoded.primitives.size(), 2u);
    std::map<GridPoint, Vec3f> seen;
    for (const Primitive& primitive : coded.decoded.primitives)
        for (const Vec3f& p : primitive.mesh.positions)
            EXPECT_EQ(seen.try_emplace(on_grid(p, options.grid), p).first->second, p);
    std::vector<GridPoint> expected;
    for (const Vec3f& p : level.positions) expected.push_back(on_grid(p, options.grid));
    std::sort(expected.begin(), expected.end());
    expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
    EXPECT_EQ(seen.size(), expected.size());
}

TEST(LevelCodec, NormalSeamsDoNotCutTheMesh) {
    const Mesh creased = mesh::with_normals(testing::sphere(12), 1.0);  // every edge is a seam
    ASSERT_GT(creased.positions.size(), 2 * testing::sphere(12).positions.size());
    const Coded flat = round_trip(creased, shaded(creased, 0)), gouraud = round_trip(creased, shaded(creased, 1));
    EXPECT_EQ(flat.encoded.vertices, testing::sphere(12).positions.size());
    expect_same_triangles(creased, shaded(creased, 1), gouraud.decoded, options_for(creased).grid);
}

TEST(LevelCodec, NormalsWithinTheToleranceCostNextToNothing) {
    Mesh level = mesh::with_normals(testing::sphere(40), 180.0);
    level.triangle_materials.clear();
    for (const mesh::Triangle& t : level.triangles)
        level.triangle_materials.push_back(level.positions[t[0]].y > 0.0f ? 1 : 0);
    Model model = model_of_one_material();
    model.materials.push_back(model.materials[0]);
    model.materials[1].name = "upper";
    std::vector<std::uint8_t> gouraud;
    for (const mesh::Triangle& t : level.triangles) gouraud.push_back(level.positions[t[0]].x > -0.2f);
    EncodeOptions options = options_for(level);
    const Coded exact = round_trip(model, level, gouraud, options);
    const Coded flat = round_trip(model, level, shaded(level, 0), options);
    options.normal_tolerance_degrees = 4.0;
    options.normal_bits = 10;
    const Coded cheap = round_trip(model, level, gouraud, options);
    expect_same_triangles(level, gouraud, cheap.decoded, options.grid);
    EXPECT_LT(cheap.encoded.geometry_bytes, exact.encoded.geometry_bytes);
    const std::uint64_t smooth = round_trip(model, level, shaded(level, 1), options).encoded.geometry_bytes;
    EXPECT_LT(smooth, flat.encoded.geometry_bytes * 1.25);
    for (const Primitive& primitive : cheap.decoded.primitives)
        for (std::size_t v = 0; v < primitive.mesh.normals.size(); ++v)  // a sphere's normals are its positions
            EXPECT_GT(dot(primitive.mesh.normals[v], normalize(primitive.mesh.positions[v])), std::cos(radians(12.0)));
}

TEST(LevelCodec, NormalsFarFromTheFacesArriveWithinTheTolerance) {
    Mesh level = mesh::with_normals(testing::sphere(16), 180.0);
    for (std::size_t v = 0; v < level.normals.size(); ++v)
        level.normals[v] = normalize(level.normals[v] + Vec3f(v % 3, v % 5 * 0.3f, 0.0f));
    EncodeOptions options = options_for(level);
    options.normal_tolerance_degrees = 2.0;
    options.normal_bits = 10;
    for (const bool lean : {false, true}) {
        options.lean = lean;
        const Coded coded = round_trip(model_of_one_material(), level, shaded(level, 1), options);
        std::map<GridPoint, std::size_t> source;
        for (std::size_t v = 0; v < level.positions.size(); ++v) source[on_grid(level.positions[v], options.grid)] = v;
        const Mesh& mesh = coded.decoded.primitives.at(0).mesh;
        for (std::size_t v = 0; v < mesh.positions.size(); ++v)
            EXPECT_GT(dot(mesh.normals[v], level.normals[source.at(on_grid(mesh.positions[v], options.grid))]),
                      std::cos(radians(3 * 2.0 + 0.5)));
    }
}

TEST(LevelCodec, NormalsThatHaveToBeToldGoToTheNearestStep) {
    Mesh level = mesh::with_normals(testing::sphere(16), 180.0);
    std::map<std::tuple<float, float, float>, Vec3f> wanted;
    for (std::size_t v = 0; v < level.normals.size(); ++v) {
        const Vec3f& p = level.positions[v];
        level.normals[v] = normalize(level.normals[v] + Vec3f(0.4f, 0.0f, 0.0f));
        wanted[{p.x, p.y, p.z}] = level.normals[v];
    }
    EncodeOptions options = options_for(level);
    options.grid = choose_grid(mesh::bounds(level), 0.0, 0.0);
    options.rounding = Rounding::nearest;
    options.normal_tolerance_degrees = 0.35;
    options.normal_bits = 8;
    const Coded coded = round_trip(model_of_one_material(), level, shaded(level, 1), options);
    const Mesh& mesh = coded.decoded.primitives.at(0).mesh;
    double squares = 0.0;
    for (std::size_t v = 0; v < mesh.normals.size(); ++v) {
        const auto nearest = std::min_element(wanted.begin(), wanted.end(), [&](const auto& a, const auto& b) {
            const auto off = [&](const auto& key) {
                return length(mesh.positions[v] - Vec3f(std::get<0>(key), std::get<1>(key), std::get<2>(key)));
            };
            return off(a.first) < off(b.first);
        });
        const double chord = length(Vec3d(mesh.normals[v]) - Vec3d(nearest->second));
        squares += chord * chord;
    }
    // A step is 0.7 degrees or less: rounded to the nearest 0.27 off in the mean, towards zero 0.75.
    EXPECT_LT(std::sqrt(squares / static_cast<double>(mesh.normals.size())), radians(0.4));
}

TEST(LevelCodec, LeanKeepsTheSplitAndComesNearTheNormalsWithFewerBytes) {
    const Mesh level = mesh::with_normals(testing::sphere(24), 180.0);
    std::vector<std::uint8_t> gouraud;
    for (const mesh::Triangle& t : level.triangles) gouraud.push_back(level.positions[t[0]].x > 0.2f);
    EncodeOptions options = options_for(level);
    const Coded plain = round_trip(model_of_one_material(), level, gouraud, options);
    options.lean = true;
    const Coded lean = round_trip(model_of_one_material(), level, gouraud, options);
    expect_same_triangles(level, gouraud, lean.decoded, options.grid);
    EXPECT_LT(lean.encoded.glb.size(), plain.encoded.glb.size());
    ASSERT_EQ(lean.decoded.primitives.size(), 2u);
    const Mesh& smooth = lean.decoded.primitives[0].mesh;
    for (std::size_t v = 0; v < smooth.positions.size(); ++v)  // a sphere's normals are its positions
        EXPECT_GT(dot(smooth.normals[v], normalize(smooth.positions[v])), std::cos(radians(9.0)));
}

TEST(LevelCodec, LeanGouraudNormalsOfAFanWithoutEndAreReadInLinearTime) {
    constexpr std::uint32_t spokes = 20'000;  // every corner at the hub has a normal of its own
    Mesh fan;
    for (std::uint32_t i = 0; i < spokes; ++i) {
        const double angle = 2 * pi * i / spokes, next = 2 * pi * (i + 1) / spokes;
        const std::uint32_t first = 3 * i;
        fan.positions.insert(fan.positions.end(), {Vec3f(0.0f), Vec3f(std::cos(angle), 0, std::sin(angle)),
                                                   Vec3f(std::cos(next), 0, std::sin(next))});
        for (int k = 0; k < 3; ++k) fan.normals.push_back(normalize(Vec3f(std::cos(angle), 0.1f, std::sin(angle))));
        fan.triangles.push_back({first, first + 2, first + 1});
    }
    EncodeOptions options = options_for(fan);
    options.lean = true;
    const Coded coded = round_trip(model_of_one_material(), fan, shaded(fan, 1), options);
    EXPECT_EQ(coded.decoded.primitives.at(0).mesh.triangles.size(), spokes);
}

TEST(LevelCodec, KeepsTrianglesThatCollapseOnTheGrid) {
    const Mesh level = testing::flat_grid(20);
    EncodeOptions options = options_for(level);
    options.grid.bits = min_position_bits;
    options.grid.range = 2000.0f;  // a step is wider than the mesh
    const Coded coded = round_trip(model_of_one_material(), level, shaded(level, 0), options);
    EXPECT_EQ(coded.encoded.triangles, level.triangles.size());
    EXPECT_GT(coded.encoded.geometry_bytes, 0u);
}

TEST(LevelCodec, KeepsNonManifoldDuplicateAndOpposedTriangles) {
    Mesh level;
    level.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {-1, -1, -1}, {2, 2, 2}, {3, 2, 2}};
    level.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {0, 1, 2}, {1, 0, 2}, {0, 5, 6}, {0, 7, 6}, {5, 6, 7}};
    level = mesh::with_normals(level, 30.0);
    for (const auto& gouraud : {shaded(level, 0), shaded(level, 1), first_half_gouraud(level)}) {
        const EncodeOptions options = options_for(level);
        const Coded coded = round_trip(model_of_one_material(), level, gouraud, options);
        expect_same_triangles(level, gouraud, coded.decoded, options.grid);
    }
}

TEST(LevelCodec, RandomSoupsKeepEveryTriangle) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    for (int round = 0; round < 60; ++round) {
        SCOPED_TRACE(round);
        Mesh level;
        const std::uint32_t vertices = 4 + random() % 20;
        for (std::uint32_t v = 0; v < vertices; ++v)
            level.positions.emplace_back(unit(random), unit(random), unit(random));
        for (int t = 0; t < 60; ++t) {
            const std::uint32_t a = random() % vertices, b = random() % vertices, c = random() % vertices;
            const auto &pa = level.positions[a], &pb = level.positions[b], &pc = level.positions[c];
            if (pa != pb && pb != pc && pa != pc) level.triangles.push_back({a, b, c});
        }
        if (level.triangles.empty()) continue;
        level = mesh::with_normals(level, 40.0);
        const auto gouraud = first_half_gouraud(level);
        const EncodeOptions options = options_for(level);
        const Coded coded = round_trip(model_of_one_material(), level, gouraud, options);
        expect_same_triangles(level, gouraud, coded.decoded, options.grid);
    }
}

TEST(LevelCodec, StoresPlainlyWhatDracoWouldDrop) {
    Mesh level = sphere_with_everything();
    level.triangles.push_back({0, 0, 1});
    Model model = model_of_one_material();
    model.images.push_back(png_image());
    model.materials[0].base_color_texture.image = 0;
    const auto gouraud = first_half_gouraud(level);  // the degenerate triangle is flat
    const EncodeOptions options = options_for(level);
    const Coded coded = round_trip(model, level, gouraud, options);
    ASSERT_EQ(coded.decoded.primitives.size(), 2u);
    expect_same_triangles(level, gouraud, coded.decoded, options.grid);
    EXPECT_EQ(coded.decoded.primitives[1].mesh.colors.size(), coded.decoded.primitives[1].mesh.positions.size());
}

TEST(LevelCodec, EncodesASingleTriangle) {
    const Coded coded = round_trip(testing::single_triangle(), shaded(testing::single_triangle(), 0));
    EXPECT_EQ(coded.encoded.triangles, 1u);
    EXPECT_EQ(coded.encoded.vertices, 3u);
}

TEST(LevelCodec, EmptyLevelIsAValidGlbThatDrawsNothing) {
    const Coded coded = round_trip(Model{}, Mesh{}, {}, EncodeOptions{});
    EXPECT_FALSE(coded.encoded.glb.empty());
    EXPECT_TRUE(coded.decoded.primitives.empty());
}

TEST(LevelCodec, NormalsThatAreNotUnitVectorsArriveAsUnitVectors) {
    Mesh level = testing::sphere(4);
    level.normals[0] = Vec3f(nan);
    level.normals[1] = Vec3f(0.0f);
    level.normals[2] = Vec3f(std::numeric_limits<float>::infinity(), 0.0f, 0.0f);
    level.normals[3] = Vec3f(1e-30f, 0.0f, 0.0f);
    level.normals[4] = Vec3f(0.0f, 3e38f, 0.0f);
    const Coded coded = round_trip(level, shaded(level, 1));
    ASSERT_EQ(coded.decoded.primitives.size(), 1u);
    for (const Vec3f& normal : coded.decoded.primitives[0].mesh.normals) EXPECT_NEAR(glm::length(normal), 1.0f, 1e-5f);
}

TEST(LevelCodec, ConstantColorMovesIntoTheMaterial) {
    Mesh level = testing::tetrahedron();
    level.colors.assign(level.positions.size(), Rgba8(51, 255, 0, 255));
    Model model = model_of_one_material();
    model.materials[0].base_color = Vec4f(0.5f, 0.5f, 0.5f, 1.0f);
    const Coded coded = round_trip(model, level, shaded(level, 0), options_for(level));
    ASSERT_EQ(coded.decoded.primitives.size(), 1u);
    EXPECT_TRUE(coded.decoded.primitives[0].mesh.colors.empty());
    const Vec4f color = coded.decoded.materials[0].base_color;
    EXPECT_FLOAT_EQ(color.r, 0.1f);
    EXPECT_FLOAT_EQ(color.g, 0.5f);
    EXPECT_FLOAT_EQ(color.b, 0.0f);
}

std::uint64_t saved_by(const Encoded& encoded, const std::string& what) {
    for (const auto& [name, bytes] : encoded.left_out)
        if (name == what) return bytes;
    return 0;
}

TEST(LevelCodec, NormalsOfFlatTrianglesAreCountedByWhatTheyWouldCost) {
    const Mesh level = testing::sphere(16);
    const Coded flat = round_trip(level, shaded(level, 0)), gouraud = round_trip(level, shaded(level, 1));
    EXPECT_EQ(saved_by(flat.encoded, "normals of flat triangles"),
              gouraud.encoded.geometry_bytes - flat.encoded.geometry_bytes);
    EXPECT_EQ(saved_by(gouraud.encoded, "normals of flat triangles"), 0u);
}

TEST(LevelCodec, LeavesOutWhatNoTriangleUses) {
    const Mesh level = sphere_with_everything();
    Model model = model_of_one_material();
    model.materials.resize(3);
    model.images.push_back(png_image());
    model.materials[2].base_color_texture.image = 0;
    const Coded coded = round_trip(model, level, shaded(level, 1), options_for(level));
    EXPECT_EQ(coded.decoded.materials.size(), 1u);
    EXPECT_TRUE(coded.decoded.images.empty());
    EXPECT_EQ(saved_by(coded.encoded, "unused images"), model.images[0].bytes.size());
    EXPECT_GT(saved_by(coded.encoded, "unused materials"), 0u);
    EXPECT_GT(saved_by(coded.encoded, "texture coordinates without a texture"), 0u);
}

TEST(LevelCodec, SmallerImagesGoInPlaceOfTheModelsAndAreListed) {
    Model model = model_of_one_material();
    model.mesh = testing::sphere(6);
    model.mesh.texture_coordinates.assign(model.mesh.positions.size(), Vec2f(0.5f, 0.25f));
    model.images.push_back(png_image());
    model.images[0].bytes.resize(1000);
    model.materials[0].base_color_texture.image = 0;
    const mesh::Image smaller = png_image();
    EncodeOptions options = options_for(model.mesh);
    options.images = {{&smaller, 600}};
    const Result<Encoded> encoded = encode_level(model, model.mesh, shaded(model.mesh, 1), options);
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    EXPECT_EQ(encoded->texture_bytes, smaller.bytes.size());
    EXPECT_EQ(saved_by(*encoded, "texels below a pixel"), 600u);
    EXPECT_EQ(saved_by(*encoded, "texels beyond the network"), 1000 - smaller.bytes.size() - 600);
    EXPECT_EQ(decode_level(encoded->glb)->images[0].bytes, smaller.bytes);

    options.images.resize(2);
    EXPECT_EQ(encode_level(model, model.mesh, shaded(model.mesh, 1), options).error().code, ErrorCode::invalid_input);
    const mesh::Image no_image{"image/png", std::vector<std::byte>(9), 1, 1};
    options.images = {{&no_image, 0}};
    EXPECT_EQ(encode_level(model, model.mesh, shaded(model.mesh, 1), options).error().code, ErrorCode::invalid_input);
}

TEST(LevelCodec, MaterialsImagesOriginAndExtrasArriveUnchanged) {
    Mesh level = testing::sphere(6);
    level.texture_coordinates.assign(level.positions.size(), Vec2f(0.25f, 0.75f));
    for (std::size_t t = 0; t < level.triangles.size(); ++t) level.triangle_materials.push_back(t % 2 ? 2 : 0);
    Model model;
    model.origin = Vec3d(84800.125, -447500.5, 1.0 / 3.0);
    model.images.push_back(png_image());
    model.materials.resize(3);
    mesh::Material& glass = model.materials[2];
    glass.name = "glass \"\xff\"";  // not UTF-8
    glass.base_color = Vec4f(0.1f, 0.2f, 0.3f, 0.4f);
    glass.metallic = 0.7f;
    glass.roughness = 0.9f;
    glass.emissive = Vec3f(0.0f, 0.5f, 1.0f);
    glass.alpha_mode = mesh::AlphaMode::mask;
    glass.alpha_cutoff = 0.3f;
    glass.double_sided = true;
    glass.base_color_texture = {0, mesh::Wrap::clamp_to_edge, mesh::Wrap::mirrored_repeat};
    glass.occlusion_texture = {0, mesh::Wrap::repeat, mesh::Wrap::repeat};
    EncodeOptions options = options_for(level);
    options.extras_json = R"({"error":0.5,"levels":[1,2,{"deep":null}]})";
    const Coded coded = round_trip(model, level, first_half_gouraud(level), options);
    EXPECT_EQ(coded.decoded.origin, model.origin);
    EXPECT_EQ(coded.decoded.extras_json, options.extras_json);
    ASSERT_EQ(coded.decoded.images.size(), 1u);
    EXPECT_EQ(coded.decoded.images[0].bytes, model.images[0].bytes);
    EXPECT_EQ(coded.decoded.images[0].width, 2u);
    EXPECT_EQ(coded.decoded.images[0].height, 3u);
    EXPECT_EQ(coded.decoded.primitives.size(), 4u);
    ASSERT_EQ(coded.decoded.materials.size(), 2u);
    const mesh::Material& arrived = coded.decoded.materials[1];
    EXPECT_EQ(arrived.base_color, glass.base_color);
    EXPECT_EQ(arrived.metallic, glass.metallic);
    EXPECT_EQ(arrived.roughness, glass.roughness);
    EXPECT_EQ(arrived.emissive, glass.emissive);
    EXPECT_EQ(arrived.alpha_mode, glass.alpha_mode);
    EXPECT_EQ(arrived.alpha_cutoff, glass.alpha_cutoff);
    EXPECT_TRUE(arrived.double_sided);
    EXPECT_EQ(arrived.base_color_texture.wrap_s, mesh::Wrap::clamp_to_edge);
    EXPECT_EQ(arrived.base_color_texture.wrap_t, mesh::Wrap::mirrored_repeat);
    EXPECT_EQ(arrived.occlusion_texture.wrap_s, mesh::Wrap::repeat);
    EXPECT_EQ(arrived.occlusion_texture.image, 0);
    EXPECT_EQ(arrived.emissive_texture.image, -1);
}

TEST(LevelCodec, TextureCoordinatesAreNoFinerThanAQuarterOfATexel) {
    Mesh level = testing::flat_grid(16);
    for (const Vec3f& p : level.positions)
        level.texture_coordinates.emplace_back(0.5f + 0.31f * p.x + 0.011f * p.z * p.z, 0.5f + 0.37f * p.z);
    Model model = model_of_one_material();
    model.images.push_back(png_image());
    model.materials[0].base_color_texture.image = 0;
    const EncodeOptions options = options_for(level);
    std::size_t last_bytes = 0;
    for (const std::uint32_t texels : {16u, 256u, 8192u}) {
        model.images[0].width = model.images[0].height = texels;
        const Coded coded = round_trip(model, level, shaded(level, 0), options);
        EXPECT_GT(coded.encoded.geometry_bytes, last_bytes);
        last_bytes = coded.encoded.geometry_bytes;
        std::map<GridPoint, std::size_t> source;
        for (std::size_t v = 0; v < level.positions.size(); ++v) source[on_grid(level.positions[v], options.grid)] = v;
        const Mesh& mesh = coded.decoded.primitives.at(0).mesh;
        const float off = std::max(0.25f / static_cast<float>(texels), 2.0f / 4095.0f);
        for (std::size_t v = 0; v < mesh.positions.size(); ++v)
            EXPECT_LT(glm::length(mesh.texture_coordinates[v] -
                                  level.texture_coordinates[source.at(on_grid(mesh.positions[v], options.grid))]),
                      off);
    }
}

TEST(LevelCodec, TextureThatRepeatsOftenKeepsItsTexels) {
    Mesh level = testing::flat_grid(8);
    for (const Vec3f& p : level.positions) level.texture_coordinates.emplace_back(p.x * 37.3f, p.z * 12.1f);
    Model model = model_of_one_material();
    model.images.push_back(png_image());
    model.materials[0].base_color_texture.image = 0;
    const EncodeOptions options = options_for(level);
    const Coded coded = round_trip(model, level, shaded(level, 0), options);
    ASSERT_EQ(coded.decoded.primitives.size(), 1u);
    const Mesh& mesh = coded.decoded.primitives[0].mesh;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        EXPECT_NEAR(mesh.texture_coordinates[v].x, mesh.positions[v].x * 37.3f, 0.05f);
        EXPECT_NEAR(mesh.texture_coordinates[v].y, mesh.positions[v].z * 12.1f, 0.05f);
    }
}

TEST(LevelCodec, RefusesWhatItCannotEncode) {
    const Mesh good = testing::sphere(4);
    const Model model = model_of_one_material();
    const auto code = [&](const Mesh& level, const Model& of, std::span<const std::uint8_t> gouraud,
                          const EncodeOptions& options) {
        const Result<Encoded> encoded = encode_level(of, level, gouraud, options);
        EXPECT_FALSE(encoded.ok());
        return encoded.ok() ? ErrorCode::internal : encoded.error().code;
    };
    const EncodeOptions options = options_for(good);
    EXPECT_EQ(code(good, model, {}, options), ErrorCode::invalid_input);
    EXPECT_EQ(code(good, Model{}, shaded(good, 0), options), ErrorCode::invalid_input);
    Mesh bad = good;
    bad.positions[0].y = nan;
    EXPECT_EQ(code(bad, model, shaded(bad, 0), options), ErrorCode::invalid_input);
    bad = good;
    bad.triangles[0][1] = 10'000;
    EXPECT_EQ(code(bad, model, shaded(bad, 0), options), ErrorCode::invalid_input);
    bad = good;
    bad.normals.clear();
    EXPECT_EQ(code(bad, model, shaded(bad, 1), options), ErrorCode::invalid_input);
    bad = good;
    bad.positions[0] = Vec3f(1e9f);
    EXPECT_EQ(code(bad, model, shaded(bad, 0), options), ErrorCode::invalid_input);
    EncodeOptions odd = options;
    odd.grid.range = 0.0f;
    EXPECT_EQ(code(good, model, shaded(good, 0), odd), ErrorCode::invalid_input);
    odd = options;
    odd.extras_json = "[1]";
    EXPECT_EQ(code(good, model, shaded(good, 0), odd), ErrorCode::invalid_input);
    odd.extras_json = std::string(100'000, '[');
    EXPECT_EQ(code(good, model, shaded(good, 0), odd), ErrorCode::invalid_input);
}

TEST(LevelCodec, IsDeterministic) {
    const Mesh level = sphere_with_everything();
    const Model model = model_of_one_material();
    const Result<Encoded> a = encode_level(model, level, first_half_gouraud(level), options_for(level));
    const Result<Encoded> b = encode_level(model, level, first_half_gouraud(level), options_for(level));
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_EQ(a->glb, b->glb);
}

enum class Form { draco, accessors, lean, lean_draco };
constexpr std::array<Form, 4> all_forms{Form::draco, Form::accessors, Form::lean, Form::lean_draco};

// As lean levels were before they had a stream of their own: flat, Draco, and the lean shading beside it.
std::vector<std::byte> as_lean_draco(const std::vector<std::byte>& flat, const WantedShading& wanted) {
    const Result<Decoded> decoded = decode_level(flat);
    const Mesh& mesh = decoded->primitives.at(0).mesh;
    const std::vector<std::byte> shading = encode_lean_shading(mesh.positions, mesh.triangles, wanted, 1.0);
    Result<Glb> glb = split_glb(flat);
    auto json = glb->json;
    std::vector<std::byte> binary(glb->binary.begin(), glb->binary.end());
    json["meshes"][0]["primitives"][0]["extras"]["lodestream"]["shading"] = json["bufferViews"].size();
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", shading.size()}});
    binary.insert(binary.end(), shading.begin(), shading.end());
    binary.resize((binary.size() + 3) / 4 * 4);
    json["buffers"][0]["byteLength"] = binary.size();
    return *join_glb(json, std::move(binary));
}

// Of a mesh whose normals are all the same.
WantedShading all_up(std::size_t triangles, std::size_t gouraud) {
    WantedShading wanted{
        std::vector<std::uint8_t>(triangles, 0), {Vec3f(0, 1, 0)}, std::vector<std::uint32_t>(3 * triangles, 0)};
    std::fill_n(wanted.gouraud.begin(), gouraud, std::uint8_t{1});
    return wanted;
}

std::vector<std::byte> small_glb(Form form) {
    Mesh level = testing::tetrahedron();
    if (form == Form::accessors) level.triangles.push_back({0, 0, 1});
    level.normals.assign(level.positions.size(), Vec3f(0, 1, 0));
    level.texture_coordinates = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    level.colors = {Rgba8(1), Rgba8(2), Rgba8(3), Rgba8(4)};
    Model model = model_of_one_material();
    model.images.push_back(png_image());
    model.materials[0].base_color_texture.image = 0;
    EncodeOptions options = options_for(level);
    options.lean = form == Form::lean;
    Result<Encoded> encoded =
        encode_level(model, level, form == Form::lean_draco ? shaded(level, 0) : first_half_gouraud(level), options);
    EXPECT_TRUE(encoded.ok());
    if (form == Form::lean_draco)
        return as_lean_draco(encoded->glb, all_up(level.triangles.size(), level.triangles.size() / 2));
    return encoded.ok() ? std::move(encoded->glb) : std::vector<std::byte>{};
}

void expect_sound(const Decoded& decoded) {
    for (const Primitive& primitive : decoded.primitives) {
        ASSERT_LT(primitive.material, decoded.materials.size());
        for (const mesh::Triangle& t : primitive.mesh.triangles)
            for (const std::uint32_t v : t) ASSERT_LT(v, primitive.mesh.positions.size());
        for (const Vec3f& p : primitive.mesh.positions) ASSERT_TRUE(all_finite(p));
        for (const Vec3f& n : primitive.mesh.normals) ASSERT_TRUE(all_finite(n));
    }
    for (const mesh::Material& material : decoded.materials)
        ASSERT_LT(material.base_color_texture.image, static_cast<int>(decoded.images.size()));
}

TEST(LevelDecoder, ReadsLeanLevelsOfBefore) {
    const Mesh level = testing::grid(9, [](double x, double z) { return 0.5 * std::sin(x + z); });
    const Result<Encoded> flat = encode_level(model_of_one_material(), level, shaded(level, 0), options_for(level));
    ASSERT_TRUE(flat.ok());
    const std::size_t triangles = level.triangles.size();
    const Result<Decoded> decoded = decode_level(as_lean_draco(flat->glb, all_up(triangles, triangles / 3)));
    ASSERT_TRUE(decoded.ok()) << decoded.error().message;
    ASSERT_EQ(decoded->primitives.size(), 2u);
    EXPECT_EQ(decoded->primitives[0].mesh.triangles.size(), triangles / 3);
    EXPECT_EQ(decoded->primitives[1].mesh.triangles.size(), triangles - triangles / 3);
    for (const Vec3f& n : decoded->primitives[0].mesh.normals) EXPECT_GT(n.y, std::cos(radians(3.0)));
}

TEST(LevelDecoder, EveryTruncationIsAnError) {
    for (const Form form : all_forms) {
        const std::vector<std::byte> glb = small_glb(form);
        for (std::size_t length = 0; length < glb.size(); ++length)
            ASSERT_FALSE(decode_level(std::span(glb).first(length)).ok()) << length;
    }
}

TEST(LevelDecoder, EveryFlippedByteIsAnErrorOrASoundLevel) {
    for (const Form form : all_forms) {
        const std::vector<std::byte> glb = small_glb(form);
        ASSERT_TRUE(decode_level(glb).ok());
        for (std::size_t at = 0; at < glb.size(); ++at)
            for (const int mask : {0x01, 0xff}) {
                std::vector<std::byte> damaged = glb;
                damaged[at] ^= static_cast<std::byte>(mask);
                const Result<Decoded> decoded = decode_level(damaged);
                if (decoded) expect_sound(*decoded);
            }
    }
}

// A GLB of the given JSON and as many zero bytes.
std::vector<std::byte> glb_of(std::string json, std::uint32_t binary_bytes) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> glb;
    const auto word = [&](std::uint32_t value) {
        for (int i = 0; i < 4; ++i) glb.push_back(static_cast<std::byte>(value >> (8 * i)));
    };
    word(0x46546c67);
    word(2);
    word(static_cast<std::uint32_t>(20 + json.size() + (binary_bytes ? 8 + binary_bytes : 0)));
    word(static_cast<std::uint32_t>(json.size()));
    word(0x4e4f534a);
    for (const char c : json) glb.push_back(static_cast<std::byte>(c));
    if (binary_bytes) {
        word(binary_bytes);
        word(0x004e4942);
        glb.resize(glb.size() + binary_bytes);
    }
    return glb;
}

TEST(LevelDecoder, RefusesDeeplyNestedJson) {
    const Result<Decoded> decoded = decode_level(glb_of("{\"asset\":" + std::string(1'000'000, '['), 0));
    ASSERT_FALSE(decoded.ok());
    EXPECT_EQ(decoded.error().code, ErrorCode::limit_exceeded);
}

std::string plain_json(const std::string& position_count, const std::string& index_count, const std::string& offset) {
    return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"materials":[{}],)"
           R"("buffers":[{"byteLength":48}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":)" +
           offset + R"(,"byteLength":12}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)" +
           position_count + R"(},{"bufferView":1,"componentType":5125,"type":"SCALAR","count":)" + index_count +
           R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}]})";
}

TEST(LevelDecoder, ReadsPlainAccessors) {
    const Result<Decoded> decoded = decode_level(glb_of(plain_json("3", "3", "36"), 48));
    ASSERT_TRUE(decoded.ok()) << decoded.error().message;
    EXPECT_EQ(decoded->primitives.size(), 1u);
}

TEST(LevelDecoder, RefusesCountsAndRangesBeyondTheData) {
    for (const char* count : {"4", "4294967299", "18446744073709551615", "-3", "3.0", "null", "\"3\""}) {
        EXPECT_FALSE(decode_level(glb_of(plain_json(count, "3", "36"), 48)).ok()) << count;
        EXPECT_FALSE(decode_level(glb_of(plain_json("3", count, "36"), 48)).ok()) << count;
    }
    for (const char* offset : {"37", "48", "18446744073709551612", "-12"})
        EXPECT_FALSE(decode_level(glb_of(plain_json("3", "3", offset), 48)).ok()) << offset;
}

TEST(LevelDecoder, RefusesToDoTheSameWorkTwice) {
    std::string json = plain_json("3", "3", "36");
    const std::string primitive = R"({"attributes":{"POSITION":0},"indices":1,"material":0})";
    json.insert(json.find(primitive), primitive + ",");
    const Result<Decoded> decoded = decode_level(glb_of(json, 48));
    ASSERT_FALSE(decoded.ok());
    EXPECT_THAT(decoded.error().message, ::testing::HasSubstr("twice"));
}

}  // namespace
}  // namespace lodestream::codec
