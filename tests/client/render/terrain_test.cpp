// Levels of a terrain leave no crack: whatever is below the horizon shows ground.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <random>

#include "client/render/image.h"
#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "common/simplify/history.h"
#include "server/samples/samples.h"
#include "tests/client/render/terrain_views.h"
#include "tests/client/render/with_renderer.h"

namespace lodestream::render {
namespace {

constexpr std::uint64_t vertices = 20'000;
constexpr std::size_t views = 1'000;

struct Looked {
    std::size_t cracks = 0;
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
        const DrawOptions options = terrain_picture();
        Looked looked;
        for (std::size_t i = 0; i < looks; ++i) {
            const Vec3d ground(level.positions[random() % level.positions.size()]);
            const shading::View view = any_terrain_view(ground, random);
            const auto frame = renderer->draw(world(view), options);
            EXPECT_TRUE(frame) << frame.error().message;
            if (!frame) break;
            looked.cracks += cracks(frame->image, view, bounds);
            if (!looks_at_ground(frame->image)) continue;
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
        EXPECT_EQ(looked.cracks, 0u) << count << " triangles";
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
    EXPECT_GT(look(joint, 50, 0).cracks, 0u);
}

}  // namespace
}  // namespace lodestream::render
