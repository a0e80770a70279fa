// What is reported of any level against an independent measurement of it.
#include <gtest/gtest.h>

#include <random>

#include "common/mesh/instances.h"
#include "server/bake/bake.h"
#include "server/importer/importer.h"
#include "server/store/mapped_file.h"
#include "tests/common/simplify/shapes.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::bake {
namespace {

constexpr int usual_cuts = 50;
constexpr double tolerance = 0.95;  // reported over measured, at least
constexpr double rounding = 1e-9;   // of the diagonal: no error

struct Estimate {
    double rms = 0.0;
    double standard_error = 0.0;  // of the RMS: few samples meet what a soup has lost
};

// The distances from points spread over one surface to the other.
Estimate rms_between(const metric::SurfaceIndex& from, const metric::SurfaceIndex& to) {
    constexpr std::size_t stride = 13;
    const std::vector<Vec3f>& samples = from.samples();
    double sum = 0.0, sum_of_squares = 0.0, count = 0.0;
    for (std::size_t i = samples.size() - std::min(samples.size(), metric::default_samples); i < samples.size();
         i += stride) {
        const double distance = to.distance(Vec3d(samples[i])), squared = distance * distance;
        sum += squared;
        sum_of_squares += squared * squared;
        count += 1.0;
    }
    const double mean = sum / count, variance = std::max(0.0, sum_of_squares / count - mean * mean);
    return {std::sqrt(mean), mean > 0 ? std::sqrt(variance / count) / (2 * std::sqrt(mean)) : 0.0};
}

struct HonestyTest : ::testing::Test {
    lodestream::testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());

    // Bakes, then cuts and measures `cuts` levels at random counts, evenly over their logarithms.
    void expect_honest(const std::string& name, const mesh::Model& model, int cuts = usual_cuts) {
        proto::Asset asset;
        asset.id = asset.name = name;
        const Result<proto::Asset> ready = bake(store, asset, model);
        ASSERT_TRUE(ready.ok()) << ready.error().message;
        const auto file = store::MappedFile::open(store.content(name, baked_key)->file.path, 1ull << 30);
        const Result<BakedView> baked = open_baked_model(file->bytes());
        ASSERT_TRUE(baked.ok()) << baked.error().message;
        const metric::SurfaceIndex original(model.mesh);
        std::mt19937 random(7);
        std::uniform_real_distribution<double> exponent(0.0, std::log(static_cast<double>(ready->triangles)));
        double worst = 1e9;
        for (int i = 0; i < cuts; ++i) {
            const auto budget = static_cast<std::uint64_t>(std::exp(exponent(random)));
            const mesh::Mesh level = simplify::cut(baked->history, budget);
            const metric::SurfaceError told = error_of(baked->errors, level.triangles.size());
            const metric::SurfaceIndex index(level);
            const Estimate there = rms_between(original, index), back = rms_between(index, original);
            const Estimate& estimate = there.rms < back.rms ? back : there;
            const double measured = estimate.rms - 3 * estimate.standard_error;  // is surely not less
            if (measured < rounding * mesh::bounds(model.mesh).diagonal()) continue;
            EXPECT_GE(told.rms, tolerance * measured) << name << " at " << level.triangles.size();
            worst = std::min(worst, told.rms / measured);
        }
        std::printf("%s: the least of reported over measured rms is %.3f\n", name.c_str(), worst);
        metric::SurfaceError before;
        for (std::uint64_t n = ready->triangles; n > 0; n -= 1 + n / 50) {
            const metric::SurfaceError told = error_of(baked->errors, n);
            EXPECT_GE(told.rms, before.rms) << name << " at " << n;
            EXPECT_GE(told.max, before.max) << name << " at " << n;
            before = told;
        }
    }
    void expect_honest(const std::string& name, const mesh::Mesh& mesh, int cuts = usual_cuts) {
        mesh::Model model;
        model.mesh = mesh::compact(mesh.normals.empty() ? mesh::with_normals(mesh, 60.0) : mesh);
        model.materials.resize(1);
        expect_honest(name, model, cuts);
    }
    void expect_honest_file(const std::string& file) {
        LODESTREAM_NEED_SHARED_DATA();
        Result<mesh::Model> model = importer::import_file(lodestream::testing::shared_data() / file);
        ASSERT_TRUE(model.ok()) << model.error().message;
        expect_honest(std::filesystem::path(file).stem().string(), mesh::without_instances(*std::move(model)));
    }
};

TEST_F(HonestyTest, RoundMeshes) {
    expect_honest("sphere", lodestream::testing::sphere(60));
    expect_honest("torus", lodestream::testing::torus(60));
}

TEST_F(HonestyTest, ATerrain) {
    expect_honest("hills", lodestream::testing::grid(70, [](double x, double z) {
                      return 3.0 * std::sin(x / 6.0) * std::cos(z / 9.0) + 0.3 * std::sin(x * 1.7 + z);
                  }));
}

// Flat but for a few spikes: the error stands still and then jumps.
TEST_F(HonestyTest, PlanesWithSpikes) {
    expect_honest("spikes", lodestream::testing::grid(60, [](double x, double z) {
                      return static_cast<int>(x) % 20 == 10 && static_cast<int>(z) % 20 == 10 ? 8.0 : 0.0;
                  }));
    expect_honest("plane", lodestream::testing::flat_grid(50));
}

// Detail of two sizes: the error has a step between the two.
TEST_F(HonestyTest, ASceneOfLargeAndSmall) {
    mesh::Mesh scene = lodestream::testing::sphere(50);
    for (int i = 0; i < 40; ++i) {
        const int row = i / 8;
        lodestream::testing::append(scene, lodestream::testing::sphere(8),
                                    {2.0f + 0.3f * static_cast<float>(i % 8), 0.3f * static_cast<float>(row), 0},
                                    0.05f);
    }
    expect_honest("scene", scene);
}

TEST_F(HonestyTest, Soup) {
    expect_honest("soup", lodestream::testing::soup(800), 15);
}

TEST_F(HonestyTest, SharedScan) {
    expect_honest_file("scan/eros_49k.ply");
}
TEST_F(HonestyTest, SharedMachine) {
    expect_honest_file("hard/truck_50comp.obj");
}
TEST_F(HonestyTest, SharedDuck) {
    expect_honest_file("gltf/Duck.glb");
}

}  // namespace
}  // namespace lodestream::bake
