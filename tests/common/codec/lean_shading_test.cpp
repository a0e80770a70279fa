#include "common/codec/lean_shading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "common/mesh/operations.h"
#include "tests/support/meshes.h"

namespace lodestream::codec {
namespace {

constexpr double tolerance = 8.0;  // degrees
constexpr double rounding_degrees = 0.01;

WantedShading all_gouraud(const mesh::Mesh& mesh, std::vector<Vec3f> normals,
                          std::vector<std::uint32_t> normal_of_corner) {
    return {std::vector<std::uint8_t>(mesh.triangles.size(), 1), std::move(normals), std::move(normal_of_corner)};
}

// Normal v at all corners of vertex v.
WantedShading one_a_vertex(const mesh::Mesh& mesh, std::vector<Vec3f> normals) {
    WantedShading shading = all_gouraud(mesh, std::move(normals), {});
    for (const mesh::Triangle& t : mesh.triangles)
        shading.normal_of_corner.insert(shading.normal_of_corner.end(), t.begin(), t.end());
    return shading;
}

// Normal c at corner c.
WantedShading one_a_corner(const mesh::Mesh& mesh, std::vector<Vec3f> normals) {
    std::vector<std::uint32_t> numbers(normals.size());
    std::iota(numbers.begin(), numbers.end(), 0u);
    return all_gouraud(mesh, std::move(normals), std::move(numbers));
}

// Those of the triangles' own at all corners.
WantedShading facets(const mesh::Mesh& mesh) {
    WantedShading shading = all_gouraud(mesh, {}, {});
    for (const mesh::Triangle& t : mesh.triangles) {
        shading.normal_of_corner.insert(shading.normal_of_corner.end(), 3,
                                        static_cast<std::uint32_t>(shading.normals.size()));
        shading.normals.emplace_back(
            mesh::face_normal(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]));
    }
    return shading;
}

double degrees_between(const Vec3f& a, const Vec3f& b) {
    return std::acos(std::clamp(dot(Vec3d(a), Vec3d(b)), -1.0, 1.0)) * 180.0 / pi;
}

mesh::Mesh box() {
    mesh::Mesh m;
    for (int corner = 0; corner < 8; ++corner)
        m.positions.emplace_back(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1);
    m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return m;
}

std::vector<std::byte> encode(const mesh::Mesh& mesh, const WantedShading& wanted, double degrees = tolerance) {
    return encode_lean_shading(mesh.positions, mesh.triangles, wanted, degrees);
}

LeanShading round_trip(const mesh::Mesh& mesh, const WantedShading& wanted, double degrees = tolerance) {
    const Result<LeanShading> read = decode_lean_shading(mesh.positions, mesh.triangles, encode(mesh, wanted, degrees));
    EXPECT_TRUE(read.ok());
    return read.ok() ? *read : LeanShading{};
}

double farthest_off(const mesh::Mesh& mesh, const LeanShading& read, const WantedShading& wanted) {
    std::vector<Vec3f> at_corner;
    for (const mesh::Triangle& t : mesh.triangles)
        for (const std::uint32_t p : t) at_corner.push_back(read.normals[p]);
    for (const FurtherNormal& further : read.further) at_corner[further.corner] = read.further_normals[further.normal];
    double farthest = 0.0;
    for (std::size_t c = 0; c < at_corner.size(); ++c)
        farthest = std::max(farthest, degrees_between(at_corner[c], wanted.normals[wanted.normal_of_corner[c]]));
    return farthest;
}

TEST(LeanShading, ASmoothSurfaceNeedsNoNormals) {
    const mesh::Mesh sphere = testing::sphere(24);
    EXPECT_LE(encode(sphere, one_a_vertex(sphere, sphere.positions)).size(), 16u);
}

TEST(LeanShading, ASharpBoxNeedsNoNormals) {
    const mesh::Mesh cube = box();
    const WantedShading wanted = facets(cube);
    EXPECT_LE(encode(cube, wanted).size(), 40u);
    EXPECT_LT(farthest_off(cube, round_trip(cube, wanted), wanted), rounding_degrees);
}

TEST(LeanShading, WhateverNormalsAreWantedArriveWithinTheTolerance) {
    std::mt19937 random(7);
    std::normal_distribution<float> number;
    const auto direction = [&] { return normalize(Vec3f(number(random), number(random), number(random))); };
    const mesh::Mesh sphere = testing::sphere(10);
    std::vector<Vec3f> at_vertex, at_corner;
    for (std::size_t v = 0; v < sphere.positions.size(); ++v) at_vertex.push_back(direction());
    for (std::size_t c = 0; c < 3 * sphere.triangles.size(); ++c) at_corner.push_back(direction());
    for (const double degrees : {0.1, 1.0, 8.0, 24.0})
        for (const WantedShading& wanted : {one_a_vertex(sphere, at_vertex), one_a_corner(sphere, at_corner)})
            EXPECT_LE(farthest_off(sphere, round_trip(sphere, wanted, degrees), wanted),
                      lean_tolerances_where_flat_is_worse * degrees + rounding_degrees);
}

TEST(LeanShading, CornersThatDifferByAboutTheToleranceArrive) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> bend(-0.1f, 0.1f);
    const mesh::Mesh sphere = testing::sphere(16);
    for (const double degrees : {1.0, 2.0, 4.0, 8.0, 16.0}) {
        std::vector<Vec3f> normals;
        for (const mesh::Triangle& t : sphere.triangles)
            for (const std::uint32_t v : t)
                normals.push_back(normalize(sphere.positions[v] + Vec3f(bend(random), bend(random), bend(random))));
        const WantedShading wanted = one_a_corner(sphere, normals);
        EXPECT_LE(farthest_off(sphere, round_trip(sphere, wanted, degrees), wanted),
                  lean_tolerances_where_flat_is_worse * degrees + rounding_degrees);
    }
}

TEST(LeanShading, ASmallerToleranceCostsBytesAndBringsNormalsCloser) {
    const mesh::Mesh sphere = testing::sphere(24);
    std::vector<Vec3f> bent;
    for (const Vec3f& p : sphere.positions) bent.push_back(normalize(p + 0.2f * Vec3f(p.y, p.z * p.z, p.x)));
    const WantedShading wanted = one_a_vertex(sphere, bent);
    std::size_t last_bytes = 0;
    for (const double degrees : {16.0, 4.0, 1.0, 0.25}) {
        const std::size_t bytes = encode(sphere, wanted, degrees).size();
        EXPECT_GT(bytes, last_bytes);
        last_bytes = bytes;
        EXPECT_LE(farthest_off(sphere, round_trip(sphere, wanted, degrees), wanted),
                  lean_tolerances_where_flat_is_worse * degrees);
    }
}

TEST(LeanShading, FacetsThatAreMeantToBeFlatStayFlat) {
    constexpr int sides = 24;  // they meet at 15 degrees
    mesh::Mesh prism;
    for (int i = 0; i < sides; ++i)
        for (const float y : {0.0f, 1.0f})
            prism.positions.emplace_back(std::cos(2 * pi * i / sides), y, std::sin(2 * pi * i / sides));
    for (std::uint32_t i = 0; i < sides; ++i) {
        const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % sides);
        prism.triangles.insert(prism.triangles.end(), {mesh::Triangle{a, a + 1, b}, {a + 1, b + 1, b}});
    }
    const WantedShading wanted = facets(prism);
    EXPECT_LT(farthest_off(prism, round_trip(prism, wanted), wanted), tolerance);
}

TEST(LeanShading, MoreNormalsAtAPositionThanAreComparedArrive) {
    constexpr std::uint32_t blades = 300;
    mesh::Mesh fan;
    fan.positions.emplace_back(0, 0, 0);
    for (std::uint32_t i = 0; i <= blades; ++i)
        fan.positions.emplace_back(std::cos(2 * pi * i / blades), 0.1 * std::sin(50.0 * i),
                                   std::sin(2 * pi * i / blades));
    for (std::uint32_t i = 1; i <= blades; ++i) fan.triangles.push_back({0, i + 1, i});
    const WantedShading wanted = facets(fan);
    EXPECT_LE(farthest_off(fan, round_trip(fan, wanted, 1.0), wanted), lean_tolerances_where_flat_is_worse);
}

TEST(LeanShading, AnySplitArrivesAsItIs) {
    std::mt19937 random(3);
    const mesh::Mesh sphere = testing::sphere(10);
    for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        WantedShading wanted = one_a_vertex(sphere, sphere.positions);
        for (std::uint8_t& g : wanted.gouraud) g = std::bernoulli_distribution(share)(random);
        EXPECT_EQ(round_trip(sphere, wanted).gouraud, wanted.gouraud);
    }
}

TEST(LeanShading, DegenerateAndExtremeTrianglesGetUnitNormals) {
    for (const float scale : {1e-30f, 1e-9f, 1.0f, 1e9f, 1e30f}) {
        mesh::Mesh m;
        m.positions = {{0, 0, 0}, {scale, 0, 0}, {0, scale, 0}, {2 * scale, 0, 0}, {0, 0, 0}};
        m.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 4, 1}, {1, 0, 2}};
        for (const Vec3f& n : round_trip(m, facets(m)).normals) EXPECT_NEAR(length(n), 1.0f, 1e-5f) << scale;
    }
    EXPECT_TRUE(round_trip({}, {}).normals.empty());
}

TEST(LeanShading, DamageIsAnErrorOrGivesUnitNormals) {
    const mesh::Mesh sphere = testing::sphere(6);
    WantedShading wanted = one_a_corner(sphere, {});
    for (std::size_t c = 0; c < 3 * sphere.triangles.size(); ++c) {
        wanted.normals.emplace_back(c % 2, (c + 1) % 2, 0);
        wanted.normal_of_corner.push_back(static_cast<std::uint32_t>(c));
    }
    for (std::size_t t = 0; t < sphere.triangles.size(); ++t) wanted.gouraud[t] = t % 5 < 3;
    const auto bytes = encode(sphere, wanted);
    const auto read = [&](std::span<const std::byte> damaged) {
        return decode_lean_shading(sphere.positions, sphere.triangles, damaged);
    };
    for (std::size_t length = 0; length < bytes.size(); ++length)
        ASSERT_FALSE(read(std::span(bytes).first(length)).ok()) << length;
    for (std::size_t at = 0; at < bytes.size(); ++at)
        for (int mask = 1; mask < 256; mask <<= 1) {
            auto damaged = bytes;
            damaged[at] ^= static_cast<std::byte>(mask);
            const Result<LeanShading> result = read(damaged);
            if (!result.ok()) continue;
            ASSERT_EQ(result->gouraud.size(), sphere.triangles.size());
            for (const Vec3f& n : result->normals) ASSERT_NEAR(length(n), 1.0f, 1e-5f);
            ASSERT_EQ(result->normals.size(), sphere.positions.size());
            for (const FurtherNormal& f : result->further) {
                ASSERT_LT(f.corner, 3 * sphere.triangles.size());
                ASSERT_LT(f.normal, result->further_normals.size());
            }
        }
    std::vector<std::byte> longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(read(longer).ok());
}

}  // namespace
}  // namespace lodestream::codec
