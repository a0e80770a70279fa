#include "common/codec/lean_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "tests/support/meshes.h"

namespace lodestream::codec {
namespace {

constexpr std::uint64_t plenty = 1'000'000;

// Positions in thousandths, one point each.
LeanMesh on_grid(const mesh::Mesh& mesh, double steps_a_unit = 1000.0) {
    LeanMesh result;
    result.triangles = mesh.triangles;
    for (const Vec3f& p : mesh.positions) {
        GridPoint point{};
        for (int axis = 0; axis < 3; ++axis)
            point[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(std::lround(p[axis] * steps_a_unit));
        result.positions.push_back(point);
    }
    result.position_of_point.resize(result.positions.size());
    std::iota(result.position_of_point.begin(), result.position_of_point.end(), 0u);
    return result;
}

// Any values, of which those at one position differ where `points_at_each` is above 1.
void add_attribute(LeanMesh& mesh, LeanAttribute::Kind kind, std::mt19937& random) {
    LeanAttribute attribute{kind, {}, {}};
    const std::int32_t range = kind == LeanAttribute::Kind::color ? 256 : 1 << 20;
    for (std::size_t i = 0; i < attribute.components() * mesh.position_of_point.size(); ++i)
        attribute.values.push_back(static_cast<std::int32_t>(random() % static_cast<unsigned>(range)));
    mesh.attributes.push_back(std::move(attribute));
}

// Every corner a point of its own.
void part_corners(LeanMesh& mesh) {
    std::vector<std::uint32_t> positions;
    for (mesh::Triangle& t : mesh.triangles)
        for (std::uint32_t& corner : t) {
            positions.push_back(mesh.position_of_point[corner]);
            corner = static_cast<std::uint32_t>(positions.size() - 1);
        }
    mesh.position_of_point = positions;
}

void expect_comes_back(const LeanMesh& mesh) {
    const EncodedLeanMesh encoded = encode_lean_mesh(mesh);
    const Result<LeanMesh> read = decode_lean_mesh(encoded.bytes, plenty, plenty);
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_EQ(read->triangles.size(), mesh.triangles.size());
    ASSERT_EQ(encoded.source_corners.size(), 3 * mesh.triangles.size());
    std::vector<int> told(mesh.triangles.size(), 0);
    for (std::size_t corner = 0; corner < encoded.source_corners.size(); ++corner) {
        const std::uint32_t from = encoded.source_corners[corner];
        ++told[from / 3];
        const std::uint32_t was = mesh.triangles[from / 3][from % 3], is = read->triangles[corner / 3][corner % 3];
        ASSERT_EQ(read->positions[read->position_of_point[is]], mesh.positions[mesh.position_of_point[was]]);
        for (std::size_t a = 0; a < mesh.attributes.size(); ++a)
            for (std::size_t c = 0, n = mesh.attributes[a].components(); c < n; ++c)
                ASSERT_EQ(read->attributes[a].values[n * is + c], mesh.attributes[a].values[n * was + c]);
        // Corners keep their order, so triangles face the way they did.
        const std::uint32_t next = encoded.source_corners[corner / 3 * 3 + (corner + 1) % 3];
        EXPECT_EQ(next, from / 3 * 3 + (from + 1) % 3);
    }
    EXPECT_TRUE(std::all_of(told.begin(), told.end(), [](int n) { return n == 3; }));
}

mesh::Mesh torus(std::uint32_t n) {
    mesh::Mesh m;
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            const double u = 2 * pi * i / n, v = 2 * pi * j / n, r = 2 + std::cos(v);
            m.positions.emplace_back(r * std::cos(u), std::sin(v), r * std::sin(u));
        }
    const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % n * n + j % n; };
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            m.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            m.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    return m;
}

TEST(LeanMesh, ClosedOpenAndHandledSurfacesComeBack) {
    for (const mesh::Mesh& mesh :
         {testing::single_triangle(), testing::tetrahedron(), testing::sphere(24), testing::flat_grid(17), torus(12)})
        expect_comes_back(on_grid(mesh));
    expect_comes_back({});
}

TEST(LeanMesh, ManyPiecesComeBack) {
    mesh::Mesh pieces;
    for (std::uint32_t piece = 0; piece < 50; ++piece) {
        const auto first = static_cast<std::uint32_t>(pieces.positions.size());
        for (const Vec3f& p : testing::tetrahedron().positions)
            pieces.positions.push_back(p + Vec3f(3.0f * static_cast<float>(piece), 0, 0));
        for (const mesh::Triangle& t : testing::tetrahedron().triangles)
            pieces.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    expect_comes_back(on_grid(pieces));
}

TEST(LeanMesh, EdgesOfManyTrianglesAndTrianglesInsideOutComeBack) {
    mesh::Mesh fan;  // around one edge, half of it turned
    fan.positions = {{0, 0, 0}, {0, 1, 0}};
    for (std::uint32_t i = 0; i < 40; ++i) {
        fan.positions.emplace_back(std::cos(0.1 * i), 0.5, std::sin(0.1 * i));
        fan.triangles.push_back(i % 2 ? mesh::Triangle{0, 1, i + 2} : mesh::Triangle{1, 0, i + 2});
    }
    expect_comes_back(on_grid(fan));
    mesh::Mesh twice = testing::sphere(6);
    const std::vector<mesh::Triangle> once = twice.triangles;
    twice.triangles.insert(twice.triangles.end(), once.begin(), once.end());
    for (const mesh::Triangle& t : once) twice.triangles.push_back({t[1], t[0], t[2]});
    expect_comes_back(on_grid(twice));
}

TEST(LeanMesh, AnySoupComesBack) {
    for (unsigned seed = 0; seed < 200; ++seed) {
        std::mt19937 random(seed);
        LeanMesh soup;
        const std::uint32_t positions = 3 + random() % 40;
        for (std::uint32_t p = 0; p < positions; ++p) {
            const auto coordinate = [&] {
                return random() % 8 == 0 ? (random() % 2 ? 1 : -1) * max_lean_coordinate
                                         : static_cast<std::int32_t>(random() % 100);
            };
            soup.positions.push_back({coordinate(), coordinate(), coordinate()});
            soup.position_of_point.push_back(p);
        }
        for (std::uint32_t t = random() % 200; t > 0; --t) {
            const std::uint32_t a = random() % positions, b = random() % positions, c = random() % positions;
            if (a != b && b != c && c != a) soup.triangles.push_back({a, b, c});
        }
        if (seed % 2) part_corners(soup);
        if (seed % 4 > 0) add_attribute(soup, LeanAttribute::Kind::texture_coordinate, random);
        if (seed % 4 > 1) add_attribute(soup, LeanAttribute::Kind::color, random);
        if (soup.attributes.empty()) continue;
        expect_comes_back(soup);
    }
}

TEST(LeanMesh, PointsThatNoTriangleHasAreLeftOut) {
    LeanMesh mesh = on_grid(testing::tetrahedron());
    mesh.positions.insert(mesh.positions.begin(), {7, 7, 7});
    for (std::uint32_t& position : mesh.position_of_point) ++position;
    const EncodedLeanMesh encoded = encode_lean_mesh(mesh);
    EXPECT_EQ(decode_lean_mesh(encoded.bytes, plenty, plenty)->positions.size(), 4u);
}

// Of n triangles around a point none is looked for among all n.
TEST(LeanMesh, AFanOfManyTrianglesCostsNoMoreThanAGrid) {
    constexpr std::uint32_t count = 200'000;
    mesh::Mesh fan;
    fan.positions.emplace_back(0, 0, 0);
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 2 * pi * i / count;
        fan.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
        fan.triangles.push_back({0, 1 + i, 1 + (i + 1) % count});
    }
    expect_comes_back(on_grid(fan, 1 << 20));
}

TEST(LeanMesh, APlaneAtAnyAngleCostsNoHeights) {
    const auto bytes_of = [](auto height) {
        std::mt19937 random(3);
        mesh::Mesh mesh = testing::flat_grid(60);
        for (Vec3f& p : mesh.positions) {  // an irregular grid, in whole steps
            p.x = 40 * p.x + static_cast<float>(random() % 13);
            p.z = 40 * p.z + static_cast<float>(random() % 13);
            p.y = static_cast<float>(height(p.x, p.z));
        }
        return encode_lean_mesh(on_grid(mesh, 1.0)).bytes.size();
    };
    const std::size_t flat = bytes_of([](float, float) { return 0.0f; });
    EXPECT_LE(bytes_of([](float, float z) { return z; }), flat * 21 / 20);
    std::mt19937 random(5);
    EXPECT_GE(bytes_of([&](float, float) { return static_cast<float>(random() % 13); }), flat * 5 / 4);
}

TEST(LeanMesh, MoreThanTheLimitsIsRefused) {
    const LeanMesh mesh = on_grid(testing::sphere(8));
    const EncodedLeanMesh encoded = encode_lean_mesh(mesh);
    const std::uint64_t points = mesh.positions.size(), triangles = mesh.triangles.size();
    EXPECT_TRUE(decode_lean_mesh(encoded.bytes, points, triangles).ok());
    EXPECT_EQ(decode_lean_mesh(encoded.bytes, points - 1, triangles).error().code, ErrorCode::limit_exceeded);
    EXPECT_EQ(decode_lean_mesh(encoded.bytes, points, triangles - 1).error().code, ErrorCode::limit_exceeded);
}

TEST(LeanMesh, FewBytesCannotAskForManyTriangles) {
    EncodedLeanMesh encoded = encode_lean_mesh(on_grid(testing::single_triangle()));
    ASSERT_EQ(encoded.bytes[1], std::byte{1});
    // 2^28 - 1 triangles as a number of seven bits a byte.
    for (const std::byte byte : {std::byte{0xff}, std::byte{0xff}, std::byte{0xff}})
        encoded.bytes.insert(encoded.bytes.begin() + 1, byte);
    EXPECT_EQ(decode_lean_mesh(encoded.bytes, 1u << 30, 1u << 30).error().code, ErrorCode::invalid_input);
}

// Streams of before began with their triangles' count.
TEST(LeanMesh, AnotherVersionIsRefused) {
    EncodedLeanMesh encoded = encode_lean_mesh(on_grid(testing::sphere(8)));
    ASSERT_EQ(encoded.bytes[0], std::byte{2});
    for (const std::byte version : {std::byte{0}, std::byte{1}, std::byte{3}, std::byte{0xff}}) {
        encoded.bytes[0] = version;
        EXPECT_EQ(decode_lean_mesh(encoded.bytes, plenty, plenty).error().code, ErrorCode::invalid_input);
    }
    encoded.bytes.erase(encoded.bytes.begin());
    EXPECT_FALSE(decode_lean_mesh(encoded.bytes, plenty, plenty).ok());
}

TEST(LeanMesh, OpacityThatIsFullIsNotTold) {
    std::mt19937 random(1);
    LeanMesh mesh = on_grid(testing::sphere(20));
    add_attribute(mesh, LeanAttribute::Kind::color, random);
    const std::size_t any = encode_lean_mesh(mesh).bytes.size();
    for (std::size_t i = 3; i < mesh.attributes[0].values.size(); i += 4) mesh.attributes[0].values[i] = 255;
    EXPECT_LT(encode_lean_mesh(mesh).bytes.size() + mesh.positions.size() * 3 / 4, any);
    expect_comes_back(mesh);
}

TEST(LeanMesh, EveryTruncationIsAnError) {
    std::mt19937 random(1);
    LeanMesh mesh = on_grid(testing::sphere(8));
    add_attribute(mesh, LeanAttribute::Kind::texture_coordinate, random);
    const EncodedLeanMesh encoded = encode_lean_mesh(mesh);
    for (std::size_t size = 0; size < encoded.bytes.size(); ++size)
        EXPECT_FALSE(decode_lean_mesh(std::span(encoded.bytes).first(size), plenty, plenty).ok()) << size;
}

TEST(LeanMesh, EveryFlippedBitIsAnErrorOrAMeshWithinItsPoints) {
    std::mt19937 random(1);
    LeanMesh mesh = on_grid(testing::sphere(5));
    part_corners(mesh);
    add_attribute(mesh, LeanAttribute::Kind::texture_coordinate, random);
    add_attribute(mesh, LeanAttribute::Kind::color, random);
    const EncodedLeanMesh encoded = encode_lean_mesh(mesh);
    for (std::size_t bit = 0; bit < 8 * encoded.bytes.size(); ++bit) {
        std::vector<std::byte> bytes = encoded.bytes;
        bytes[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
        const Result<LeanMesh> read = decode_lean_mesh(bytes, plenty, plenty);
        if (!read) continue;
        for (const std::uint32_t position : read->position_of_point) ASSERT_LT(position, read->positions.size());
        for (const mesh::Triangle& t : read->triangles)
            for (const std::uint32_t point : t) ASSERT_LT(point, read->position_of_point.size());
    }
}

}  // namespace
}  // namespace lodestream::codec
