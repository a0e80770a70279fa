#include "common/codec/lean_shading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/mesh/operations.h"
#include "tests/support/meshes.h"

namespace lodestream::codec {
namespace {

constexpr double packed_degrees = 0.7;  // what normals of two bytes are off by at most

LeanShading all_gouraud(const mesh::Mesh& mesh, std::vector<Vec3f> normals) {
    return {std::vector<std::uint8_t>(mesh.triangles.size(), 1), std::move(normals)};
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

LeanShading round_trip(const mesh::Mesh& mesh, const LeanShading& wanted) {
    const auto bytes = encode_lean_shading(mesh.positions, mesh.triangles, wanted);
    const Result<LeanShading> read = decode_lean_shading(mesh.positions, mesh.triangles, bytes);
    EXPECT_TRUE(read.ok());
    return read.ok() ? *read : LeanShading{};
}

TEST(LeanShading, ASmoothSurfaceNeedsNoNormals) {
    const mesh::Mesh sphere = testing::sphere(24);
    std::vector<Vec3f> normals;
    for (const mesh::Triangle& t : sphere.triangles)
        for (const std::uint32_t v : t) normals.push_back(normalize(sphere.positions[v]));
    EXPECT_LE(encode_lean_shading(sphere.positions, sphere.triangles, all_gouraud(sphere, normals)).size(), 8u);
}

TEST(LeanShading, EdgesSharperThanTheCreaseStaySharp) {
    const mesh::Mesh cube = box();
    const std::vector<Vec3f> derived = derive_normals(cube.positions, cube.triangles);
    for (std::size_t c = 0; c < derived.size(); ++c) {
        const mesh::Triangle& t = cube.triangles[c / 3];
        const Vec3f face(mesh::face_normal(cube.positions[t[0]], cube.positions[t[1]], cube.positions[t[2]]));
        EXPECT_LT(degrees_between(derived[c], face), 0.01);
    }
}

TEST(LeanShading, NormalsAreSmoothAcrossVerticesOfOnePosition) {
    mesh::Mesh seam;  // two triangles that meet along an edge whose ends are there twice
    seam.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0.2f, 0}, {0, 0, 0}, {-1, 0.2f, 0}, {0, 0, 1}};
    seam.triangles = {{0, 1, 2}, {3, 4, 5}};
    const std::vector<Vec3f> derived = derive_normals(seam.positions, seam.triangles);
    EXPECT_EQ(derived[0], derived[3]);
    EXPECT_EQ(derived[1], derived[5]);
}

TEST(LeanShading, WhateverNormalsAreWantedArriveWithinTheTolerance) {
    std::mt19937 random(7);
    std::normal_distribution<float> number;
    const auto direction = [&] { return normalize(Vec3f(number(random), number(random), number(random))); };
    for (const bool one_a_vertex : {true, false}) {
        const mesh::Mesh sphere = testing::sphere(10);
        std::vector<Vec3f> at_vertex;
        for (std::size_t v = 0; v < sphere.positions.size(); ++v) at_vertex.push_back(direction());
        LeanShading wanted = all_gouraud(sphere, {});
        for (const mesh::Triangle& t : sphere.triangles)
            for (const std::uint32_t v : t) wanted.normals.push_back(one_a_vertex ? at_vertex[v] : direction());
        const LeanShading read = round_trip(sphere, wanted);
        for (std::size_t c = 0; c < wanted.normals.size(); ++c)
            EXPECT_LT(degrees_between(read.normals[c], wanted.normals[c]),
                      lean_normal_tolerance_degrees + packed_degrees);
    }
}

TEST(LeanShading, FacetsThatAreMeantToBeFlatStayFlat) {
    constexpr int sides = 24;  // they meet at 15 degrees
    mesh::Mesh prism;
    LeanShading wanted;
    for (int i = 0; i <= sides; ++i)
        for (const float y : {0.0f, 1.0f})
            prism.positions.emplace_back(std::cos(2 * pi * i / sides), y, std::sin(2 * pi * i / sides));
    for (std::uint32_t i = 0; i < sides; ++i) {
        const std::uint32_t a = 2 * i;
        prism.triangles.insert(prism.triangles.end(), {mesh::Triangle{a, a + 1, a + 2}, {a + 1, a + 3, a + 2}});
        const double middle = 2 * pi * (i + 0.5) / sides;
        for (int c = 0; c < 6; ++c) wanted.normals.emplace_back(std::cos(middle), 0, std::sin(middle));
    }
    wanted.gouraud.assign(prism.triangles.size(), 1);
    const LeanShading read = round_trip(prism, wanted);
    for (std::size_t c = 0; c < wanted.normals.size(); ++c)
        EXPECT_LT(degrees_between(read.normals[c], wanted.normals[c]), lean_always_good_degrees + packed_degrees);
}

TEST(LeanShading, AnySplitArrivesAsItIs) {
    std::mt19937 random(3);
    const mesh::Mesh sphere = testing::sphere(10);
    for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        LeanShading wanted = all_gouraud(sphere, derive_normals(sphere.positions, sphere.triangles));
        for (std::uint8_t& g : wanted.gouraud) g = std::bernoulli_distribution(share)(random);
        EXPECT_EQ(round_trip(sphere, wanted).gouraud, wanted.gouraud);
    }
}

TEST(LeanShading, DegenerateAndExtremeTrianglesGetUnitNormals) {
    for (const float scale : {1e-30f, 1e-9f, 1.0f, 1e9f, 1e30f}) {
        mesh::Mesh m;
        m.positions = {{0, 0, 0}, {scale, 0, 0}, {0, scale, 0}, {2 * scale, 0, 0}, {0, 0, 0}};
        m.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 4, 1}, {1, 0, 2}};
        for (const Vec3f& n : derive_normals(m.positions, m.triangles)) EXPECT_NEAR(length(n), 1.0f, 1e-5f) << scale;
    }
    EXPECT_TRUE(derive_normals({}, {}).empty());
}

TEST(LeanShading, DamageIsAnErrorOrGivesUnitNormals) {
    const mesh::Mesh sphere = testing::sphere(6);
    LeanShading wanted = all_gouraud(sphere, {});
    for (std::size_t t = 0; t < sphere.triangles.size(); ++t) wanted.gouraud[t] = t % 5 < 3;
    for (std::size_t c = 0; c < 3 * sphere.triangles.size(); ++c) wanted.normals.emplace_back(c % 2, (c + 1) % 2, 0);
    const auto bytes = encode_lean_shading(sphere.positions, sphere.triangles, wanted);
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
        }
    std::vector<std::byte> longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(read(longer).ok());
}

}  // namespace
}  // namespace lodestream::codec
