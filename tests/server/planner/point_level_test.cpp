#include "server/planner/point_level.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/mesh/operations.h"
#include "server/bake/bake.h"
#include "server/bake/points.h"
#include "server/planner/planner.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::planner {
namespace {

// A sphere, and a thousand small triangles that no simplifier can join.
struct Baked {
    testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());
    Planner planner{store};

    Baked() {
        add("sphere", testing::sphere(60));
        std::mt19937 random(7);
        std::uniform_real_distribution<float> place(-1.0f, 1.0f), size(-0.02f, 0.02f);
        mesh::Mesh leaves;
        for (int i = 0; i < 6000; ++i) {
            const Vec3f at(place(random), place(random), place(random));
            const auto first = static_cast<std::uint32_t>(leaves.positions.size());
            for (int k = 0; k < 3; ++k)
                leaves.positions.push_back(at + Vec3f(size(random), size(random), size(random)));
            leaves.triangles.push_back({first, first + 1, first + 2});
        }
        add("leaves", mesh::with_normals(leaves, 60.0));
        add("cloud", testing::sphere(60), mesh::Kind::points);
    }
    void add(const std::string& name, mesh::Mesh mesh, mesh::Kind kind = mesh::Kind::mesh) {
        if (kind == mesh::Kind::points) mesh.triangles.clear();
        mesh::Model model;
        model.kind = kind;
        model.mesh = std::move(mesh);
        model.materials.resize(1);
        proto::Asset asset;
        asset.id = asset.name = name;
        const auto done = bake::bake(store, asset, std::move(model));
        EXPECT_TRUE(done) << (done ? "" : done.error().message);
    }
};

Baked& baked() {
    static Baked instance;
    return instance;
}

proto::PlanRequest request_for(const std::string& asset, proto::Primitives primitives, double mhz = 300.0) {
    proto::PlanRequest request;
    request.asset = asset;
    request.budget.device.cpu_mhz = mhz;
    request.primitives = primitives;
    return request;
}

codec::Points content_of(const proto::PlanResponse& plan) {
    const std::string hash = plan.content.url.substr(plan.content.url.rfind('/') + 1, 64);
    const auto bytes = store::read_file(baked().store.file(hash, "glb")->path, 1 << 30);
    EXPECT_EQ(bytes->size(), plan.content.bytes);
    auto decoded = codec::decode_points(*bytes);
    EXPECT_TRUE(decoded) << (decoded ? "" : decoded.error().message);
    return decoded->content;
}

TEST(PointPlan, SendsTheDevicesShareAsOneLevel) {
    auto request = request_for("sphere", proto::Primitives::points);
    request.budget.reference.triangles = 6400;
    const auto plan = baked().planner.plan(request);
    ASSERT_TRUE(plan) << plan.error().message;
    EXPECT_EQ(plan->level.points, 282u);  // half of the contract's triangles
    EXPECT_EQ(plan->budget.points, 282u);
    EXPECT_EQ(plan->budget.limited_by, "device");
    EXPECT_EQ(plan->level.triangles, 0u);
    EXPECT_EQ(plan->shading.gouraud + plan->shading.flat, 0u);
    EXPECT_EQ(plan->shading.mode, "points");
    EXPECT_GT(plan->level.rms_error, 0.0);
    EXPECT_NEAR(plan->level.rms_error_percent, 100.0 * plan->level.rms_error / std::sqrt(12.0),
                0.01);  // of a unit sphere
    const codec::Points content = content_of(*plan);
    EXPECT_EQ(content.cloud.positions.size(), 282u);
    ASSERT_FALSE(content.levels.empty());
    EXPECT_GT(content.levels.front().radius, 0.0);
}

TEST(PointPlan, LeanPointsAreTheSameLevelInAboutHalfOfTheBytes) {
    auto request = request_for("sphere", proto::Primitives::points, 1e6);
    const auto plain = baked().planner.plan(request);
    request.profile = proto::Profile::lean;
    const auto lean = baked().planner.plan(request);
    ASSERT_TRUE(plain && lean);
    EXPECT_EQ(lean->content.profile, "lean");
    EXPECT_EQ(plain->content.profile, "plain");
    EXPECT_EQ(lean->level.points, plain->level.points);
    EXPECT_LT(static_cast<double>(lean->content.bytes), 0.55 * static_cast<double>(plain->content.bytes));
    const codec::Points content = content_of(*lean);
    EXPECT_EQ(content.cloud.positions.size(), lean->level.points);
    EXPECT_EQ(content.levels.front().radius, content_of(*plain).levels.front().radius);
}

TEST(PointPlan, AFewLeanPointsAreSentPlainAsThatIsSmaller) {
    auto request = request_for("sphere", proto::Primitives::points);
    request.profile = proto::Profile::lean;
    for (const std::uint64_t points : {1u, 20u, 99u}) {
        request.budget.preference.triangles = points;
        request.budget.device.points_per_second = 1e9;
        const auto plan = baked().planner.plan(request);
        ASSERT_TRUE(plan) << plan.error().message;
        EXPECT_EQ(plan->level.points, points);
        EXPECT_EQ(plan->content.profile, "plain");
    }
}

TEST(PointPlan, LeanPointsOfAShortLinkAreMoreThanPlainOnesAndInTime) {
    for (const char* asset : {"sphere", "leaves"}) {
        auto request = request_for(asset, proto::Primitives::points, 1e6);
        request.budget.network = budget::Network{0.1, 0.0, 1.0};  // 12,500 bytes
        const auto plain = baked().planner.plan(request);
        request.profile = proto::Profile::lean;
        const auto lean = baked().planner.plan(request);
        ASSERT_TRUE(plain && lean);
        EXPECT_EQ(lean->budget.limited_by, "network");
        EXPECT_GT(lean->level.points, plain->level.points) << asset;
        EXPECT_LE(lean->content.bytes, 12'500u) << asset;
    }
}

TEST(PointPlan, TheSamePlanComesFromTheStore) {
    const auto request = request_for("sphere", proto::Primitives::points, 500.0);
    const auto first = baked().planner.plan(request), again = baked().planner.plan(request);
    ASSERT_TRUE(first && again);
    EXPECT_EQ(again->content.url, first->content.url);
    EXPECT_EQ(again->level.points, first->level.points);
    EXPECT_EQ(again->level.max_error, first->level.max_error);
    EXPECT_EQ(again->timing_ms.encode, 0.0);
}

TEST(PointPlan, PointsThatTheViewCannotTellApartAreLeftOut) {
    auto request = request_for("sphere", proto::Primitives::points, 1e6);
    request.view = shading::View{{0, 0, 400}, {0, 0, 0}, 45.0, {0, 0, 1}};
    const auto far = baked().planner.plan(request);
    ASSERT_TRUE(far);
    EXPECT_EQ(far->budget.limited_by, "display");
    EXPECT_LT(far->level.points, 1000u);  // the sphere is 3.6 px wide
    request.view->eye.z = 3.0;
    EXPECT_GT(baked().planner.plan(request)->level.points, 5000u);
}

TEST(PointPlan, NeverMoreThanTheBudgetWhateverTheDevice) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> exponent(-3.0, 9.0);
    for (int i = 0; i < 200; ++i) {
        auto request = request_for("sphere", proto::Primitives::points, std::pow(10.0, exponent(random)));
        if (i % 2) request.budget.device.memory_mb = std::pow(10.0, exponent(random));
        if (i % 3 == 0) request.budget.network = budget::Network{std::pow(10.0, exponent(random) - 3.0), 10.0, 3.0};
        if (i % 5 == 0) request.budget.preference.triangles = 1 + static_cast<std::uint64_t>(random() % 10'000);
        if (i % 7 == 0) request.budget.device.points_per_second = std::pow(10.0, exponent(random));
        const auto plan = baked().planner.plan(request);
        ASSERT_TRUE(plan) << plan.error().message;
        EXPECT_GE(plan->level.points, 1u);
        EXPECT_EQ(plan->level.points, *plan->budget.points);
        if (request.budget.network && plan->budget.feasible) {
            EXPECT_LE(static_cast<double>(plan->content.bytes), budget::network_bytes(request.budget));
        }
    }
}

TEST(PointPlan, ALevelHasNoMoreBytesThanItWasPlannedWith) {
    for (const char* name : {"sphere", "leaves", "cloud"})
        for (const std::uint64_t points : {1u, 70u, 1'000u, 1'000'000u}) {
            proto::PlanRequest request;
            request.budget.device.cpu_mhz = 300;
            request.budget.device.points_per_second = 1e9;
            request.budget.preference.triangles = points;
            const auto level = plan_points(baked().store, *baked().store.asset(name), request, {1e9, 2.0, 1.0});
            ASSERT_TRUE(level) << level.error().message;
            proto::PlanResponse response;
            ASSERT_TRUE(add_points(response, baked().store, name, *level, 1.0));
            EXPECT_LE(response.content.bytes, level->bytes) << name << ", " << points;
        }
}

TEST(PointPlan, AMeasuredRateOfPointsIsTheDevicesOwn) {
    auto request = request_for("sphere", proto::Primitives::points);
    request.budget.device.points_per_second = 30'000;
    EXPECT_EQ(baked().planner.plan(request)->level.points, 1000u);  // at 30 frames a second
}

TEST(AnyPrimitives, ASmoothSurfaceIsSentAsTriangles) {
    const auto plan = baked().planner.plan(request_for("sphere", proto::Primitives::any));
    ASSERT_TRUE(plan);
    EXPECT_GT(plan->level.triangles, 0u);
    EXPECT_EQ(plan->level.points, 0u);
    EXPECT_TRUE(plan->budget.points);
}

// A thousandth of a phone's frame is a triangle or two, or some tens of points where the device is good at those.
TEST(AnyPrimitives, WhatIsSentIsTheNearerOfBothPictures) {
    std::size_t as_points = 0;
    for (const char* asset : {"sphere", "leaves"})
        for (const double rate : {1e4, 1e5, 1e6})
            for (const double distance : {2.5, 10.0, 100.0}) {
                auto request = request_for(asset, proto::Primitives::any);
                request.budget.preference.quality = 0.01;
                request.budget.device.points_per_second = rate;
                request.view = shading::View{{0, 0, distance}, {0, 0, 0}, 45.0, {0, 0, 1}};
                const auto any = baked().planner.plan(request);
                request.primitives = proto::Primitives::triangles;
                const auto triangles = baked().planner.plan(request);
                request.primitives = proto::Primitives::points;
                const auto points = baked().planner.plan(request);
                ASSERT_TRUE(any && triangles && points);
                const bool chose_points = any->level.points > 0;
                EXPECT_EQ(any->content.url, (chose_points ? points : triangles)->content.url);
                EXPECT_EQ(chose_points, any->crossing && points_win(*any->crossing));
                as_points += chose_points;
            }
    EXPECT_GT(as_points, 0u);
    EXPECT_LT(as_points, 18u);
}

TEST(AnyPrimitives, AnAssetOfWhichNothingWasMeasuredKeepsItsTriangles) {
    Baked own;
    auto request = request_for("sphere", proto::Primitives::any);
    request.budget.preference.quality = 0.01;
    request.budget.device.points_per_second = 1e6;
    ASSERT_GT(own.planner.plan(request)->level.points, 0u);
    ASSERT_TRUE(own.store.remove_content("sphere", bake::shown_errors_key));
    const auto plan = own.planner.plan(request);
    ASSERT_TRUE(plan) << plan.error().message;
    EXPECT_GT(plan->level.triangles, 0u);
    EXPECT_FALSE(plan->crossing);
}

TEST(PointPlan, ACloudIsSentAsPointsOrRefusedAsTriangles) {
    for (const auto primitives : {proto::Primitives::points, proto::Primitives::any}) {
        const auto plan = baked().planner.plan(request_for("cloud", primitives));
        ASSERT_TRUE(plan) << plan.error().message;
        EXPECT_GT(plan->level.points, 0u);
        EXPECT_EQ(plan->level.triangles, 0u);
        EXPECT_EQ(content_of(*plan).cloud.positions.size(), plan->level.points);
    }
    const auto refused = baked().planner.plan(request_for("cloud", proto::Primitives::triangles));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::conflict);
    EXPECT_NE(refused.error().message.find("\"points\""), std::string::npos);
    EXPECT_FALSE(baked().planner.cut("cloud", 100));
}

// A cloud whose points err less the more there are, until they err no less than 1 %.
struct Rivals {
    PointLevel level;
    bake::ShownErrors errors{{{1, 0.5}, {1'000, 0.02}}, {{1, 0.5}, {1'000, 0.04}}, {{1, 0.6}, {10'000, 0.01}}};

    explicit Rivals(std::uint64_t points) {
        level.budget.points = points;
        level.points.levels = {{10'000, {}, 0.02}, {100, {}, 0.2}, {1, {}, 2.0}};
    }
    std::optional<proto::Crossing> seen_from(double distance, double triangles_error) const {
        return crossing_of(level, errors, triangles_error, {1000.0 / (distance - 1.0), distance, 1.0});
    }
};

TEST(Rivals, TrianglesErrAsTheirShadingDoes) {
    const bake::ShownErrors errors = Rivals(1).errors;
    EXPECT_EQ(shown_error(errors, 0, 0), 0.0);
    EXPECT_NEAR(shown_error(errors, 1000, 0), 0.02, 1e-12);
    EXPECT_NEAR(shown_error(errors, 0, 1000), 0.04, 1e-12);
    EXPECT_NEAR(shown_error(errors, 500, 500), std::sqrt(0.5 * 0.0004 + 0.5 * 0.0016), 1e-12);
}

TEST(Rivals, PointsThatErrMoreFromCloseByNeverWin) {
    EXPECT_FALSE(Rivals(5000).seen_from(3.0, 0.01));
    ASSERT_TRUE(Rivals(5000).seen_from(3.0, 0.05));
    EXPECT_TRUE(points_win(*Rivals(5000).seen_from(3.0, 0.05)));
}

TEST(Rivals, TheCrossingIsWherePointsCeaseToWin) {
    const Rivals rivals(10'000);
    const auto here = rivals.seen_from(3.0, 0.015);
    ASSERT_TRUE(here && here->distance);
    EXPECT_GT(*here->distance, 3.0);
    EXPECT_TRUE(points_win(*rivals.seen_from(0.97 * *here->distance, 0.015)));
    EXPECT_FALSE(points_win(*rivals.seen_from(1.03 * *here->distance, 0.015)));
    EXPECT_NEAR(*rivals.seen_from(100.0, 0.015)->distance, *here->distance, 1e-6);  // wherever it is asked from
}

TEST(Rivals, PointsThatWinInTheirFewestWinFromAnywhere) {
    const auto crossing = Rivals(10'000).seen_from(3.0, 0.5);
    ASSERT_TRUE(crossing);
    EXPECT_FALSE(crossing->distance);
    EXPECT_TRUE(points_win(*Rivals(10'000).seen_from(1e6, 0.5)));
}

// Their order is lost, so a far picture draws them all.
TEST(Rivals, LeanPointsAreAllDrawn) {
    Rivals lean(10'000);
    lean.level.profile = proto::Profile::lean;
    const auto crossing = lean.seen_from(1e6, 0.02);
    ASSERT_TRUE(crossing);
    EXPECT_FALSE(crossing->distance);
    EXPECT_NEAR(crossing->points_error_percent, 1.0, 1e-9);
}

}  // namespace
}  // namespace lodestream::planner
