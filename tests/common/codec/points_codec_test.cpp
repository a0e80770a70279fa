#include "common/codec/points_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "common/base/random.h"

namespace lodestream::codec {
namespace {

QuantizationGrid grid_of(const Points& points) {
    Box box;
    for (const Vec3f& p : points.cloud.positions) box.add(Vec3d(p));
    return point_grid(box);
}

Points some_points(std::size_t count, bool normals = true, bool colors = true) {
    Random random(3);
    Points points;
    for (std::size_t i = 0; i < count; ++i) {
        points.cloud.positions.emplace_back(random.uniform(), random.uniform(2, 5), random.uniform());
        const Vec3d n(random.normal(), random.normal(), random.normal());
        if (normals) points.cloud.normals.emplace_back(normalize(n));
        if (colors) points.cloud.colors.emplace_back(i % 256, 7, 9, 255);
    }
    points.levels = {{count, {0.25, 0.5}, 0.125}, {count / 2, {0.5, 1.0}, 0.25}};
    points.base_color = {0.5f, 0.25f, 1.0f, 1.0f};
    points.origin = {1e6, 0, -3};
    points.grid = grid_of(points);
    return points;
}

std::vector<std::byte> encoded(const Points& points) {
    const auto result = encode_points(points);
    EXPECT_TRUE(result.ok()) << (result ? "" : result.error().message);
    return result ? result->glb : std::vector<std::byte>{};
}

TEST(PointsCodec, DecodesWhatItEncoded) {
    for (const bool normals : {false, true})
        for (const bool colors : {false, true}) {
            const Points points = some_points(500, normals, colors);
            const auto decoded = decode_points(encoded(points));
            ASSERT_TRUE(decoded) << decoded.error().message;
            const Points& content = decoded->content;
            EXPECT_EQ(decoded->points, 500u);
            ASSERT_EQ(content.cloud.positions.size(), 500u);
            ASSERT_EQ(content.cloud.normals.size(), normals ? 500u : 0u);
            EXPECT_EQ(content.cloud.colors, points.cloud.colors);
            EXPECT_EQ(content.base_color, points.base_color);
            const double step = points.grid.step();
            for (std::size_t i = 0; i < 500; ++i) {
                const Vec3d moved = content.origin + Vec3d(content.cloud.positions[i]) - points.origin -
                                    Vec3d(points.cloud.positions[i]);
                for (int axis = 0; axis < 3; ++axis) ASSERT_LE(std::abs(moved[axis]), 0.5 * step + 1e-6);
                if (normals) {
                    ASSERT_LT(glm::length(content.cloud.normals[i] - points.cloud.normals[i]), 0.008f);
                }
            }
        }
}

TEST(PointsCodec, DecodedPointsEncodeToTheSameBytes) {
    const std::vector<std::byte> glb = encoded(some_points(300));
    const auto decoded = decode_points(glb);
    ASSERT_TRUE(decoded);
    EXPECT_EQ(encoded(decoded->content), glb);
}

TEST(PointsCodec, LevelsAreCarried) {
    const auto decoded = decode_points(encoded(some_points(100)));
    ASSERT_TRUE(decoded);
    ASSERT_EQ(decoded->content.levels.size(), 2u);
    EXPECT_EQ(decoded->content.levels[1].points, 50u);
    EXPECT_EQ(decoded->content.levels[1].error.max, 1.0);
    EXPECT_EQ(decoded->content.levels[1].radius, 0.25);
}

TEST(PointsCodec, CutAtAnyByteGivesThePointsThatCame) {
    const Points points = some_points(50);
    const auto whole = encode_points(points);
    ASSERT_TRUE(whole);
    ASSERT_EQ(whole->glb.size(), whole->first_point_byte + 50 * whole->bytes_per_point);
    const auto all = decode_points(whole->glb);
    ASSERT_TRUE(all);
    for (std::size_t size = 0; size <= whole->glb.size(); ++size) {
        const auto decoded = decode_points(std::span(whole->glb).first(size));
        if (size + 8 < whole->first_point_byte) {  // before the end of the JSON
            ASSERT_FALSE(decoded) << size;
            continue;
        }
        ASSERT_TRUE(decoded) << size << ": " << decoded.error().message;
        const std::size_t came =
            size <= whole->first_point_byte ? 0 : (size - whole->first_point_byte) / whole->bytes_per_point;
        ASSERT_EQ(decoded->points, 50u);
        ASSERT_EQ(decoded->content.cloud.positions.size(), came) << size;
        for (std::size_t i = 0; i < came; ++i)
            ASSERT_EQ(decoded->content.cloud.positions[i], all->content.cloud.positions[i]);
    }
}

TEST(PointsCodec, DamagedBytesNeverCrash) {
    const std::vector<std::byte> glb = encoded(some_points(20));
    Random random(5);
    for (int k = 0; k < 20'000; ++k) {
        std::vector<std::byte> damaged = glb;
        for (int n = 0; n < 3; ++n)
            damaged[random.next() % damaged.size()] = static_cast<std::byte>(random.next() & 0xffu);
        const auto decoded = decode_points(damaged);
        if (!decoded) continue;
        for (const Vec3f& p : decoded->content.cloud.positions) ASSERT_TRUE(all_finite(p));
        for (const Vec3f& n : decoded->content.cloud.normals) ASSERT_NEAR(glm::length(n), 1.0f, 0.011f);
    }
}

TEST(PointsCodec, RefusesCountsThatTheBytesCannotHold) {
    const std::vector<std::byte> glb = encoded(some_points(20));
    std::string text(reinterpret_cast<const char*>(glb.data()), glb.size());
    for (std::size_t at = text.find("\"count\":20"); at != std::string::npos; at = text.find("\"count\":20"))
        text.replace(at, 10, "\"count\":99");
    EXPECT_FALSE(decode_points(std::as_bytes(std::span(text))));
}

TEST(PointsCodec, NoPoints) {
    Points none;
    none.grid = point_grid({});
    const auto result = encode_points(none);
    ASSERT_TRUE(result) << result.error().message;
    const auto decoded = decode_points(result->glb);
    ASSERT_TRUE(decoded) << decoded.error().message;
    EXPECT_EQ(decoded->points, 0u);
}

TEST(PointsCodec, OnePoint) {
    Points one = some_points(1);
    one.levels = {{1, {}, 1.0}};
    const auto decoded = decode_points(encoded(one));
    ASSERT_TRUE(decoded) << decoded.error().message;
    EXPECT_EQ(decoded->content.cloud.positions.size(), 1u);
}

TEST(PointsCodec, HugeAndTinyClouds) {
    for (const float factor : {1e9f, 1e-9f}) {
        Points points = some_points(100);
        for (Vec3f& p : points.cloud.positions) p *= factor;
        points.origin = Vec3d(0.0);
        points.grid = grid_of(points);
        const auto decoded = decode_points(encoded(points));
        ASSERT_TRUE(decoded) << decoded.error().message;
        const Vec3d moved = decoded->content.origin + Vec3d(decoded->content.cloud.positions[7]);
        EXPECT_LT(glm::length(moved - Vec3d(points.cloud.positions[7])), 1e-4 * factor);
    }
}

TEST(PointsCodec, ConstantColoursBecomeTheBaseColour) {
    Points points = some_points(10, true, false);
    points.cloud.colors.assign(10, Rgba8(255, 0, 255, 255));
    const auto decoded = decode_points(encoded(points));
    ASSERT_TRUE(decoded);
    EXPECT_TRUE(decoded->content.cloud.colors.empty());
    EXPECT_EQ(decoded->content.base_color, Vec4f(0.5f, 0.0f, 1.0f, 1.0f));
}

TEST(PointsCodec, RefusesWhatCannotBeStored) {
    const Points sound = some_points(10);
    Points short_normals = sound;
    short_normals.cloud.normals.pop_back();
    EXPECT_FALSE(encode_points(short_normals));
    Points outside = sound;
    outside.cloud.positions[3].x = 100.0f;
    EXPECT_FALSE(encode_points(outside));
    outside.cloud.positions[3].x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(encode_points(outside));
    Points fine = sound;
    fine.grid.bits = 20;
    EXPECT_FALSE(encode_points(fine));
}

TEST(PointsCodec, NormalsWithoutLengthPointUp) {
    Points points = some_points(10);
    points.cloud.normals[4] = Vec3f(0.0f);
    const auto decoded = decode_points(encoded(points));
    ASSERT_TRUE(decoded) << decoded.error().message;
    EXPECT_EQ(decoded->content.cloud.normals[4], Vec3f(0, 1, 0));
}

std::vector<std::byte> lean(const Points& points) {
    const auto result = encode_lean_points(points);
    EXPECT_TRUE(result.ok()) << (result ? "" : result.error().message);
    return result ? *result : std::vector<std::byte>{};
}

// Each point with the nearest of the others'.
double farthest(const std::vector<Vec3f>& from, const Vec3d& from_origin, const std::vector<Vec3f>& to,
                const Vec3d& to_origin) {
    double most = 0.0;
    for (const Vec3f& p : from) {
        double least = std::numeric_limits<double>::infinity();
        for (const Vec3f& q : to) least = std::min(least, glm::length(from_origin - to_origin + Vec3d(p) - Vec3d(q)));
        most = std::max(most, least);
    }
    return most;
}

TEST(LeanPoints, AreAsNearAsTheirDiscsNeed) {
    for (const bool normals : {false, true})
        for (const bool colors : {false, true}) {
            const Points points = some_points(400, normals, colors);
            const auto decoded = decode_points(lean(points));
            ASSERT_TRUE(decoded) << decoded.error().message;
            const Points& content = decoded->content;
            EXPECT_EQ(decoded->points, 400u);
            ASSERT_EQ(content.cloud.positions.size(), 400u);
            EXPECT_EQ(content.cloud.normals.size(), normals ? 400u : 0u);
            EXPECT_EQ(content.cloud.colors.size(), colors ? 400u : 0u);
            EXPECT_EQ(content.base_color, points.base_color);
            ASSERT_EQ(content.levels.size(), 1u);
            EXPECT_EQ(content.levels[0].radius, points.levels[0].radius);
            const double most = std::sqrt(3.0) * 0.5 * lean_step_share * points.levels[0].radius + 1e-6;
            EXPECT_LT(farthest(points.cloud.positions, points.origin, content.cloud.positions, content.origin), most);
            EXPECT_LT(farthest(content.cloud.positions, content.origin, points.cloud.positions, points.origin), most);
        }
}

TEST(LeanPoints, KeepEachPointsNormalAndColourWithIt) {
    Points points = some_points(300);
    for (std::size_t i = 0; i < 300; ++i) {
        points.cloud.positions[i] = {static_cast<float>(i), 0.0f, 0.0f};
        points.cloud.colors[i] = Rgba8(i % 200, i / 2, 3, 255);
    }
    points.grid = grid_of(points);
    const auto decoded = decode_points(lean(points));
    ASSERT_TRUE(decoded) << decoded.error().message;
    const Points& content = decoded->content;
    for (std::size_t i = 0; i < 300; ++i) {
        const double x = content.cloud.positions[i].x + content.origin.x - points.origin.x;
        const auto source = static_cast<std::size_t>(std::lround(x));
        EXPECT_EQ(content.cloud.colors[i], points.cloud.colors[source]);
        EXPECT_GT(dot(normalize(content.cloud.normals[i]), points.cloud.normals[source]), std::cos(radians(2.0)));
    }
}

TEST(LeanPoints, TakeAboutHalfOfThePlainBytesOfASurface) {
    Points points;
    for (std::size_t i = 0; i < 20'000; ++i) {
        const double height = 1.0 - 2.0 * (static_cast<double>(i) + 0.5) / 20'000.0;
        const double around = std::sqrt(1.0 - height * height), turn = 2.4 * static_cast<double>(i);
        points.cloud.positions.emplace_back(around * std::cos(turn), height, around * std::sin(turn));
    }
    points.cloud.normals = points.cloud.positions;
    points.levels = {{20'000, {}, 0.02}};
    points.grid = grid_of(points);
    EXPECT_LT(static_cast<double>(lean(points).size()), 0.5 * static_cast<double>(encoded(points).size()));
}

TEST(LeanPoints, HugeAndTinyCloudsAreAlike) {
    for (const double scale : {1e9, 1e-9}) {
        Points points = some_points(200, true, false);
        points.origin = Vec3d(0.0);
        for (Vec3f& p : points.cloud.positions) p *= static_cast<float>(scale);
        points.levels = {{200, {0.25 * scale, 0.5 * scale}, 0.125 * scale}};
        points.grid = grid_of(points);
        const auto decoded = decode_points(lean(points));
        ASSERT_TRUE(decoded) << decoded.error().message;
        EXPECT_LT(
            farthest(points.cloud.positions, points.origin, decoded->content.cloud.positions, decoded->content.origin),
            0.125 * lean_step_share * scale);
    }
}

TEST(LeanPoints, OfNoneOneOrNormalsThatAreNoneAreFine) {
    const auto none = decode_points(lean(some_points(0)));
    ASSERT_TRUE(none);
    EXPECT_EQ(none->points, 0u);
    Points one = some_points(1);
    one.cloud.normals[0] = Vec3f(std::nanf(""));
    const auto decoded = decode_points(lean(one));
    ASSERT_TRUE(decoded) << decoded.error().message;
    EXPECT_EQ(decoded->content.cloud.normals[0], Vec3f(0, 1, 0));
}

TEST(LeanPoints, CutOrDamagedAreRefusedOrReadAndNeverCrash) {
    const std::vector<std::byte> whole = lean(some_points(2000));
    Random random(5);
    for (int i = 0; i < 300; ++i) {
        std::vector<std::byte> damaged = whole;
        const auto at = static_cast<std::size_t>(random.uniform() * static_cast<double>(whole.size()));
        if (i % 2 == 0)
            damaged.resize(at);
        else
            damaged[at] ^= std::byte{0x5a};
        const auto decoded = decode_points(damaged);
        if (decoded) {
            EXPECT_EQ(decoded->content.cloud.positions.size(), decoded->points);
        } else {
            EXPECT_EQ(decoded.error().code, ErrorCode::invalid_input);
        }
    }
    EXPECT_FALSE(decode_points(std::span(whole).first(whole.size() - 8)));
}

TEST(LeanPoints, ThatStateFarMoreThanTheirBytesHoldAreRefusedBeforeAnythingIsAllocated) {
    std::vector<std::byte> glb = lean(some_points(100));
    std::string text(reinterpret_cast<const char*>(glb.data()), glb.size());
    for (std::size_t at = text.find("\"count\":100"); at != std::string::npos; at = text.find("\"count\":100", at + 1))
        text.replace(at, 11, "\"count\":999");
    const auto refused = decode_points(std::as_bytes(std::span(text)));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::invalid_input);
}

}  // namespace
}  // namespace lodestream::codec
