// Tiny constructed meshes, and the real ones of ../shared/data where that folder is there.
#pragma once

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "common/mesh/mesh.h"

namespace lodestream::testing {

inline mesh::Mesh single_triangle() {
    mesh::Mesh m;
    m.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    m.triangles = {{0, 1, 2}};
    return m;
}

inline mesh::Mesh tetrahedron() {
    mesh::Mesh m;
    m.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    m.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    return m;
}

// A flat n×n grid of quads in the xz plane with `height(x, z)` as y; 2*n*n triangles, open boundary.
template <class Height>
mesh::Mesh grid(std::uint32_t n, Height height) {
    mesh::Mesh m;
    for (std::uint32_t z = 0; z <= n; ++z)
        for (std::uint32_t x = 0; x <= n; ++x)
            m.positions.push_back({static_cast<float>(x), static_cast<float>(height(x, z)), static_cast<float>(z)});
    for (std::uint32_t z = 0; z < n; ++z)
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t a = z * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
            m.triangles.push_back({a, c, b});
            m.triangles.push_back({b, c, d});
        }
    return m;
}
inline mesh::Mesh flat_grid(std::uint32_t n) {
    return grid(n, [](std::uint32_t, std::uint32_t) { return 0.0; });
}

// A closed unit sphere of 2*n*(n-1) triangles (n >= 2 slices around, n stacks), smooth normals included.
inline mesh::Mesh sphere(std::uint32_t n) {
    mesh::Mesh m;
    const auto vertex = [&](double theta, double phi) {
        const Vec3d p{std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi)};
        m.positions.emplace_back(p);
        m.normals.emplace_back(p);
    };
    vertex(0, 0);
    for (std::uint32_t i = 1; i < n; ++i)
        for (std::uint32_t j = 0; j < n; ++j) vertex(pi * i / n, 2 * pi * j / n);
    vertex(pi, 0);
    const std::uint32_t south = static_cast<std::uint32_t>(m.positions.size()) - 1;
    const auto at = [&](std::uint32_t i, std::uint32_t j) { return 1 + (i - 1) * n + j % n; };
    for (std::uint32_t j = 0; j < n; ++j) {
        m.triangles.push_back({0, at(1, j), at(1, j + 1)});
        for (std::uint32_t i = 1; i + 1 < n; ++i) {
            m.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
            m.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
        }
        m.triangles.push_back({south, at(n - 1, j + 1), at(n - 1, j)});
    }
    return m;
}

// ../shared/data beside the checkout (LODESTREAM_DATA overrides); empty where it is missing, and then cases skip.
inline std::filesystem::path shared_data() {
    if (const char* folder = std::getenv("LODESTREAM_DATA")) return folder;
    const auto beside = std::filesystem::path(LODESTREAM_SOURCE_DIR) / ".." / "shared" / "data";
    return std::filesystem::exists(beside) ? beside : std::filesystem::path{};
}

}  // namespace lodestream::testing

#define LODESTREAM_NEED_SHARED_DATA() \
    if (lodestream::testing::shared_data().empty()) GTEST_SKIP() << "../shared/data is not here"
