#include "common/codec/draco_mesh.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <draco/point_cloud/point_cloud_builder.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "tests/support/meshes.h"

namespace lodestream::codec {
namespace {

constexpr std::uint64_t plenty = 1'000'000;

std::vector<std::byte> bytes_of(const draco::EncoderBuffer& buffer) {
    const auto* first = reinterpret_cast<const std::byte*>(buffer.data());
    return {first, first + buffer.size()};
}

std::vector<std::byte> encoded(const mesh::Mesh& source, int speed) {
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(static_cast<int>(source.triangles.size()));
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    const int color = builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8, true);
    const std::array<std::uint8_t, 4> red{255, 0, 51, 255};
    for (std::uint32_t t = 0; t < source.triangles.size(); ++t) {
        const auto& [a, b, c] = source.triangles[t];
        builder.SetAttributeValuesForFace(position, draco::FaceIndex(t), &source.positions[a], &source.positions[b],
                                          &source.positions[c]);
        builder.SetAttributeValuesForFace(color, draco::FaceIndex(t), &red, &red, &red);
    }
    const auto mesh = builder.Finalize();
    draco::Encoder encoder;
    encoder.SetSpeedOptions(speed, speed);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
    return bytes_of(buffer);
}

std::vector<std::byte> encoded_cloud() {
    draco::PointCloudBuilder builder;
    builder.Start(3);
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    for (std::uint32_t i = 0; i < 3; ++i) {
        const Vec3f p(static_cast<float>(i), 0.0f, 1.0f);
        builder.SetAttributeValueForPoint(position, draco::PointIndex(i), &p);
    }
    const auto cloud = builder.Finalize(false);
    draco::Encoder encoder;
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodePointCloudToBuffer(*cloud, &buffer).ok());
    return bytes_of(buffer);
}

TEST(DracoMesh, ReadsEdgebreakerAndSequentialStreams) {
    for (const int speed : {0, 5, 10}) {
        const Result<DracoMesh> mesh = decode_draco(encoded(testing::sphere(8), speed), plenty, plenty);
        ASSERT_TRUE(mesh.ok()) << mesh.error().message;
        EXPECT_EQ(mesh->triangles.size(), testing::sphere(8).triangles.size());
        ASSERT_EQ(mesh->attributes.size(), 2u);
        EXPECT_EQ(mesh->attributes.at(0).semantic, DracoAttribute::Semantic::position);
        EXPECT_EQ(mesh->attributes.at(0).values.size(), 3 * mesh->points);
    }
}

TEST(DracoMesh, ScalesNormalizedIntegers) {
    const Result<DracoMesh> mesh = decode_draco(encoded(testing::tetrahedron(), 5), plenty, plenty);
    ASSERT_TRUE(mesh.ok());
    const DracoAttribute& color = mesh->attributes.at(1);
    EXPECT_TRUE(color.normalized);
    EXPECT_EQ(color.values[0], 1.0f);
    EXPECT_EQ(color.values[1], 0.0f);
    EXPECT_FLOAT_EQ(color.values[2], 0.2f);
}

TEST(DracoMesh, PointCloudHasNoTriangles) {
    const Result<DracoMesh> cloud = decode_draco(encoded_cloud(), plenty, plenty);
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    EXPECT_EQ(cloud->points, 3u);
    EXPECT_TRUE(cloud->triangles.empty());
}

TEST(DracoMesh, HoldsTheCallersLimits) {
    const std::vector<std::byte> stream = encoded(testing::sphere(8), 3);
    const std::uint64_t triangles = testing::sphere(8).triangles.size();
    EXPECT_TRUE(decode_draco(stream, plenty, triangles).ok());
    EXPECT_EQ(decode_draco(stream, plenty, triangles - 1).error().code, ErrorCode::limit_exceeded);
    EXPECT_EQ(decode_draco(stream, 3, plenty).error().code, ErrorCode::limit_exceeded);
    EXPECT_EQ(decode_draco(encoded_cloud(), 2, plenty).error().code, ErrorCode::limit_exceeded);
}

TEST(DracoMesh, RefusesHeaderThatDeclaresMoreThanTheStreamCanHold) {
    std::vector<std::byte> stream = encoded(testing::tetrahedron(), 3);
    // DRACO, version, type, method, flags (11 bytes), traversal, then the varints of vertices and faces.
    std::vector<std::byte> bomb(stream.begin(), stream.begin() + 12);
    for (const int byte : {0xff, 0xff, 0xff, 0x1f, 0xff, 0xff, 0xff, 0x1f})
        bomb.push_back(static_cast<std::byte>(byte));
    bomb.insert(bomb.end(), stream.begin() + 14, stream.end());
    const Result<DracoMesh> mesh = decode_draco(bomb, 100'000'000, 100'000'000);
    ASSERT_FALSE(mesh.ok());
    EXPECT_THAT(mesh.error().message, ::testing::HasSubstr("declares more"));
}

TEST(DracoMesh, EveryTruncationIsAnError) {
    const std::vector<std::byte> stream = encoded(testing::tetrahedron(), 3);
    for (std::size_t length = 0; length < stream.size(); ++length)
        EXPECT_FALSE(decode_draco(std::span(stream).first(length), plenty, plenty).ok()) << length;
}

TEST(DracoMesh, EveryFlippedByteIsAnErrorOrAMeshWithinItsPoints) {
    for (const int speed : {3, 10}) {
        const std::vector<std::byte> stream = encoded(testing::sphere(4), speed);
        for (std::size_t at = 0; at < stream.size(); ++at)
            for (const int mask : {0x01, 0x80, 0xff}) {
                std::vector<std::byte> damaged = stream;
                damaged[at] ^= static_cast<std::byte>(mask);
                const Result<DracoMesh> mesh = decode_draco(damaged, plenty, plenty);
                if (!mesh) continue;
                for (const mesh::Triangle& t : mesh->triangles)
                    for (const std::uint32_t v : t) ASSERT_LT(v, mesh->points);
                for (const auto& [id, attribute] : mesh->attributes)
                    ASSERT_EQ(attribute.values.size(), std::size_t{mesh->points} * attribute.components);
            }
    }
}

// A sphere with texture coordinates, which Draco predicts from the positions and one orientation flag each.
std::vector<std::byte> encoded_textured(int speed) {
    const mesh::Mesh source = testing::sphere(6);
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(static_cast<int>(source.triangles.size()));
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    const int coordinate = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
    for (std::uint32_t t = 0; t < source.triangles.size(); ++t) {
        const auto& [a, b, c] = source.triangles[t];
        const auto uv = [&](std::uint32_t v) { return Vec2f(source.positions[v].x, source.positions[v].y); };
        const Vec2f uv_a = uv(a), uv_b = uv(b), uv_c = uv(c);
        builder.SetAttributeValuesForFace(position, draco::FaceIndex(t), &source.positions[a], &source.positions[b],
                                          &source.positions[c]);
        builder.SetAttributeValuesForFace(coordinate, draco::FaceIndex(t), &uv_a, &uv_b, &uv_c);
    }
    const auto mesh = builder.Finalize();
    draco::Encoder encoder;
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 10);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 10);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
    return bytes_of(buffer);
}

TEST(DracoMesh, ReadsTextureCoordinatesPredictedByOrientations) {
    const Result<DracoMesh> mesh = decode_draco(encoded_textured(0), plenty, plenty);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    const DracoAttribute& position = mesh->attributes.at(0);
    const DracoAttribute& coordinate = mesh->attributes.at(1);
    ASSERT_EQ(coordinate.semantic, DracoAttribute::Semantic::texture_coordinate);
    for (std::size_t p = 0; p < mesh->points; ++p)
        for (std::size_t axis = 0; axis < 2; ++axis)
            ASSERT_NEAR(coordinate.values[2 * p + axis], position.values[3 * p + axis], 0.01);
}

// Whatever place in the stream a count has: one that was made huge costs next to nothing. Without the bound on texture
// orientations one of these costs ten seconds.
TEST(DracoMesh, NoHugeCountAnywhereInTheStreamCostsTime) {
    const std::vector<std::byte> stream = encoded_textured(0);
    const std::clock_t start = std::clock();
    for (std::size_t at = 0; at + 4 <= stream.size(); ++at) {
        std::vector<std::byte> crafted = stream;
        for (const int byte : {0xff, 0xff, 0xff, 0x7f}) crafted[at++] = static_cast<std::byte>(byte);
        at -= 4;
        (void)decode_draco(crafted, plenty, plenty);
    }
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 4.0) << "CPU seconds";
}

TEST(DracoMesh, RefusesTruncatedCar) {
    LODESTREAM_NEED_SHARED_DATA();
    std::ifstream file(testing::shared_data() / "malformed/derived/car_truncated.drc", std::ios::binary);
    const std::vector<char> text(std::istreambuf_iterator<char>(file), {});
    ASSERT_FALSE(text.empty());
    EXPECT_FALSE(decode_draco(std::as_bytes(std::span(text)), plenty, plenty).ok());
}

}  // namespace
}  // namespace lodestream::codec
