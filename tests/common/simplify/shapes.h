// Small meshes with the connectivity and attributes that simplification has to respect.
#pragma once

#include <cmath>
#include <random>

#include "common/mesh/operations.h"
#include "tests/support/meshes.h"

namespace lodestream::testing {

// `pages` squares of two triangles around one common edge.
inline mesh::Mesh book(std::uint32_t pages) {
    mesh::Mesh m;
    m.positions = {{0, 0, 0}, {0, 1, 0}};
    for (std::uint32_t k = 0; k < pages; ++k) {
        const double angle = 2 * pi * k / pages;
        const auto x = static_cast<float>(std::cos(angle)), z = static_cast<float>(std::sin(angle));
        const auto outer = static_cast<std::uint32_t>(m.positions.size());
        m.positions.insert(m.positions.end(), {{x, 0, z}, {x, 1, z}});
        m.triangles.push_back({0, outer, outer + 1});
        m.triangles.push_back({0, outer + 1, 1});
    }
    return m;
}

inline mesh::Mesh soup(std::uint32_t triangles) {
    std::mt19937 random(triangles);
    std::uniform_real_distribution<float> anywhere(0, 1);
    mesh::Mesh m;
    for (std::uint32_t k = 0; k < 3 * triangles; ++k)
        m.positions.push_back({anywhere(random), anywhere(random), anywhere(random)});
    for (std::uint32_t t = 0; t < triangles; ++t) m.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    return m;
}

inline void append(mesh::Mesh& to, const mesh::Mesh& more, const Vec3f& offset, float scale = 1.0f) {
    const auto base = static_cast<std::uint32_t>(to.positions.size());
    for (const Vec3f& p : more.positions) to.positions.push_back(p * scale + offset);
    to.normals.insert(to.normals.end(), more.normals.begin(), more.normals.end());
    for (const mesh::Triangle& t : more.triangles) to.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

// An open tube around y, `around` × `along` quads, textured once around: a seam where the texture's ends meet.
inline mesh::Mesh textured_tube(std::uint32_t around, std::uint32_t along) {
    mesh::Mesh m;
    for (std::uint32_t y = 0; y <= along; ++y)
        for (std::uint32_t k = 0; k <= around; ++k) {
            const double angle = 2 * pi * (k % around) / around;
            m.positions.emplace_back(Vec3d{std::cos(angle), 4.0 * y / along, -std::sin(angle)});
            m.normals.emplace_back(Vec3d{std::cos(angle), 0, -std::sin(angle)});
            m.texture_coordinates.emplace_back(static_cast<float>(k) / static_cast<float>(around),
                                               static_cast<float>(y) / static_cast<float>(along));
        }
    for (std::uint32_t y = 0; y < along; ++y)
        for (std::uint32_t k = 0; k < around; ++k) {
            const std::uint32_t a = y * (around + 1) + k, b = a + 1, c = a + around + 1, d = c + 1;
            m.triangles.push_back({a, b, c});
            m.triangles.push_back({b, d, c});
        }
    return m;
}

// A torus of around × around quads.
inline mesh::Mesh torus(std::uint32_t around) {
    mesh::Mesh m;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const double u = 2 * pi * i / around, v = 2 * pi * j / around, r = 2 + std::cos(v);
            m.positions.emplace_back(Vec3d{r * std::cos(u), std::sin(v), r * std::sin(u)});
        }
    const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % around * around + j % around; };
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            m.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            m.triangles.push_back({at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)});
        }
    return m;
}

inline double area(const mesh::Mesh& m) {
    double sum = 0;
    for (const mesh::Triangle& t : m.triangles)
        sum += mesh::face_area(m.positions[t[0]], m.positions[t[1]], m.positions[t[2]]);
    return sum;
}

}  // namespace lodestream::testing
