// Levels of a terrain leave no crack: whatever is below the horizon shows ground.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <random>

#include "client/render/image.h"
#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "common/simplify/history.h"
#include "server/samples/samples.h"
#include "tests/client/render/with_renderer.h"

namespace lodestream::render {
namespace {

constexpr std::uint64_t vertices = 20'000;
constexpr std::size_t views = 1'000;
constexpr std::uint32_t width = 192, height = 128;
constexpr double fov_y_deg = 98.2;  // 120 degrees across
constexpr double border = 0.05;     // of the extent, where a level need not reach as far as the terrain
const Vec3f sky{1.0f, 0.0f, 1.0f};  // hills are never of this colour
constexpr std::uint8_t most_green = 8;

bool is_sky(const Image& image, std::uint32_t x, std::uint32_t y) {
    const std::uint8_t* pixel = &image.rgba[4 * (std::size_t{y} * image.width + x)];
    return pixel[0] > 247 && pixel[1] < most_green && pixel[2] > 247;
}

// From above the ground: heading in +-180, pitch in +-90 degrees.
template <class Random>
shading::View any_view(const Vec3d& ground, Random& random) {
    std::uniform_real_distribution<double> share;
    const double above = std::pow(10.0, 1.0 + 2.0 * share(random));  // m
    const double heading = std::numbers::pi * (2.0 * share(random) - 1.0);
    const double pitch = std::numbers::pi * (share(random) - 0.5);
    shading::View view;
    view.eye = ground + Vec3d(0.0, above, 0.0);
    view.target = view.eye + 100.0 * Vec3d(std::cos(pitch) * std::cos(heading), std::sin(pitch),
                                           std::cos(pitch) * std::sin(heading));
    view.fov_y_deg = fov_y_deg;
    return view;
}

// Pixels of sky through which one looks at the ground: the line of sight comes down to the lowest ground within the
// terrain, so it must have met the surface before.
std::size_t holes(const Image& image, const shading::View& view, const Box& bounds) {
    const Vec3d forward = normalize(view.target - view.eye);
    const Vec3d right = normalize(cross(forward, Vec3d(0.0, 1.0, 0.0))), up = cross(right, forward);
    const double tan_y = std::tan(0.5 * view.fov_y_deg * std::numbers::pi / 180.0), tan_x = tan_y * width / height;
    const Vec3d margin = border * bounds.extent();
    std::size_t count = 0;
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            const Vec3d along = forward + (2.0 * (x + 0.5) / width - 1.0) * tan_x * right +
                                (1.0 - 2.0 * (y + 0.5) / height) * tan_y * up;
            if (!(along.y < 0.0)) continue;
            const Vec3d lowest = view.eye + (bounds.min.y - view.eye.y) / along.y * along;
            const bool is_within = lowest.x > bounds.min.x + margin.x && lowest.x < bounds.max.x - margin.x &&
                                   lowest.z > bounds.min.z + margin.z && lowest.z < bounds.max.z - margin.z;
            count += is_within && is_sky(image, x, y) ? 1 : 0;
        }
    return count;
}

struct Looked {
    std::size_t holes = 0;
    std::size_t views_with_ground = 0;
};

class TerrainTest : public testing::WithRenderer {
  protected:
    void SetUp() override {
        WithRenderer::SetUp();
        model = *samples::terrain(vertices);
        history = *simplify::record_history(mesh::Mesh(model.mesh));
    }

    codec::Decoded coded(const mesh::Mesh& level, bool is_lean) const {
        std::vector<std::uint8_t> gouraud(level.triangles.size());
        for (std::size_t t = 0; t < gouraud.size(); ++t) gouraud[t] = t / 30 % 2;  // many borders between shadings
        codec::EncodeOptions options;
        options.grid = codec::choose_grid(mesh::bounds(model.mesh), 1.0, 50.0);
        options.lean = is_lean;
        const auto encoded = codec::encode_level(model, level, gouraud, options);
        EXPECT_TRUE(encoded) << encoded.error().message;
        return *codec::decode_level(encoded->glb);
    }

    // Into what is uploaded, from above corners of `level`.
    Looked look(const mesh::Mesh& level, std::size_t looks, std::uint32_t seed) {
        std::mt19937 random(seed);
        const Box bounds = mesh::bounds(level);
        DrawOptions options;
        options.width = width;
        options.height = height;
        options.samples = 1;
        options.background = sky;
        Looked looked;
        for (std::size_t i = 0; i < looks; ++i) {
            const Vec3d ground(level.positions[random() % level.positions.size()]);
            const shading::View view = any_view(ground, random);
            const auto frame = renderer->draw(world(view), options);
            EXPECT_TRUE(frame) << frame.error().message;
            if (!frame) break;
            looked.holes += holes(frame->image, view, bounds);
            if (is_sky(frame->image, width / 2, height - 1)) continue;
            if (++looked.views_with_ground == looks / 4) keep_picture(frame->image, seed);
        }
        return looked;
    }

    shading::View world(shading::View view) const {
        view.eye += model.origin;
        view.target += model.origin;
        return view;
    }

    mesh::Model model;
    simplify::History history;

  private:
    // Where LODESTREAM_PICTURES names a folder.
    static void keep_picture(const Image& image, std::uint32_t seed) {
        const char* folder = std::getenv("LODESTREAM_PICTURES");
        if (!folder) return;
        const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
        EXPECT_TRUE(write_png(std::filesystem::path(folder) / (name + "-" + std::to_string(seed) + ".png"), image));
    }
};

TEST_F(TerrainTest, LevelsHaveNoCrackInAThousandRandomViews) {
    const std::vector<double> shares{1.0, 0.5, 0.2, 0.05, 0.01};
    for (std::size_t i = 0; i < shares.size(); ++i) {
        const auto count = static_cast<std::uint64_t>(shares[i] * static_cast<double>(model.mesh.triangles.size()));
        const mesh::Mesh level = simplify::cut(history, count);
        const bool is_lean = i % 2 == 1;
        ASSERT_TRUE(renderer->upload(coded(level, is_lean)));
        const Looked looked = look(level, views / shares.size(), static_cast<std::uint32_t>(i));
        EXPECT_EQ(looked.holes, 0u) << count << " triangles";
        EXPECT_GT(looked.views_with_ground, views / shares.size() / 3) << "most look at ground";
    }
}

// That the views would show a crack: two levels side by side, whose corners along the joint are not the same.
TEST_F(TerrainTest, AJointOfTwoLevelsIsSeen) {
    const Box bounds = mesh::bounds(model.mesh);
    const auto half_of = [&](const mesh::Mesh& level, bool is_left) {
        std::vector<std::uint32_t> triangles;
        for (std::uint32_t t = 0; t < level.triangles.size(); ++t) {
            double x = 0.0;
            for (const std::uint32_t v : level.triangles[t]) x += level.positions[v].x / 3.0;
            if ((x < bounds.center().x) == is_left) triangles.push_back(t);
        }
        return mesh::part(level, triangles);
    };
    const std::uint64_t count = model.mesh.triangles.size();
    mesh::Mesh joint = half_of(simplify::cut(history, count), true);
    mesh::append(joint, half_of(simplify::cut(history, count / 5), false));
    ASSERT_TRUE(renderer->upload(coded(joint, false)));
    EXPECT_GT(look(joint, 50, 0).holes, 0u);
}

}  // namespace
}  // namespace lodestream::render
