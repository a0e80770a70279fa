#include "server/planner/planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/codec/level_codec.h"
#include "server/bake/bake.h"
#include "server/samples/samples.h"
#include "tests/common/texture/textured.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::planner {
namespace {

// The teapot and a bumpy grid, baked once for all cases.
struct Baked {
    testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());
    Planner planner{store};

    Baked() {
        add("teapot", *samples::teapot());
        mesh::Model hills;
        hills.mesh = testing::grid(40, [](double x, double z) { return 2.0 * std::sin(x / 3.0) * std::cos(z / 4.0); });
        hills.mesh.normals.assign(hills.mesh.positions.size(), {0, 1, 0});
        hills.materials.resize(1);
        add("hills", hills);
        mesh::Model painted = texture::square_with(texture::jpeg_of(texture::noise(512, 512)));
        painted.mesh = hills.mesh;
        for (const Vec3f& p : painted.mesh.positions) painted.mesh.texture_coordinates.emplace_back(p.x / 40, p.z / 40);
        add("painted", painted);
        add("scene", testing::hull_with_cargo(32));
        mesh::Model ball;
        ball.mesh = testing::sphere(80);
        ball.materials.resize(1);
        proto::Asset prepared;
        prepared.id = prepared.name = "prepared";
        EXPECT_TRUE(::lodestream::bake::prepare(store, prepared, ball).ok());
        proto::Asset baking;
        baking.id = baking.name = "baking";
        EXPECT_TRUE(store.put_asset(baking).ok());
    }
    void add(const std::string& name, const mesh::Model& model) {
        proto::Asset asset;
        asset.id = asset.name = name;
        const Result<proto::Asset> baked = ::lodestream::bake::bake(store, asset, model);
        EXPECT_TRUE(baked.ok()) << baked.error().message;
    }
};

Baked& baked() {
    static Baked instance;
    return instance;
}

proto::PlanRequest request_for(const std::string& asset, double mhz) {
    proto::PlanRequest request;
    request.asset = asset;
    request.budget.device.cpu_mhz = mhz;
    return request;
}

proto::PlanRequest contract_example() {
    proto::PlanRequest request = request_for("teapot", 300);
    request.budget.device.memory_mb = 64;
    request.budget.display = budget::Display{800, 600};
    request.budget.network = budget::Network{2, 80, 3};
    request.budget.reference = {3400, 6400};
    request.view = shading::View{{0, 0, 5}, {0, 0, 0}, 45, {0.3, 1, 0.5}};
    return request;
}

// The whole teapot at a distance where a good part of it is flat: large enough for the split to pay.
proto::PlanRequest large_hybrid() {
    proto::PlanRequest request = request_for("teapot", 3400);
    request.view = shading::View{{0, 0, 25}, {0, 0, 0}, 45, {0.3, 1, 0.5}};
    return request;
}

std::vector<std::byte> bytes_of(const proto::PlanResponse& plan) {
    const std::string hash = plan.content.url.substr(plan.content.url.rfind('/') + 1, 64);
    return *store::read_file(baked().store.file(hash, "glb")->path, 1 << 30);
}

TEST(Planner, AnswersTheContractsExample) {
    const Result<proto::PlanResponse> plan = baked().planner.plan(contract_example());
    ASSERT_TRUE(plan.ok()) << plan.error().message;
    EXPECT_EQ(plan->ncp, 564u);
    EXPECT_EQ(plan->budget.limited_by, "device");
    EXPECT_EQ(plan->budget.triangles, 564u);
    EXPECT_GE(plan->level.triangles, 563u);  // inside a surface triangles go in pairs
    EXPECT_LE(plan->level.triangles, 564u);
    EXPECT_DOUBLE_EQ(plan->shading.distance, 0.4);
    EXPECT_EQ(plan->shading.gouraud + plan->shading.flat, plan->level.triangles);
    EXPECT_EQ(plan->shading.operations.criterion, 9 * plan->level.triangles);
    EXPECT_GT(plan->level.rms_error, 0.0);
    EXPECT_GT(plan->level.screen_space_error_px, 0.0);
    EXPECT_EQ(plan->content.bytes, bytes_of(*plan).size());
}

TEST(Planner, ContentDecodesToThePlansCounts) {
    const proto::PlanResponse plan = *baked().planner.plan(large_hybrid());
    EXPECT_EQ(plan.shading.mode, "hybrid");
    EXPECT_EQ(plan.shading.gouraud, static_cast<std::uint64_t>(std::round((1.0 - plan.shading.distance) * 6400.0)));
    const Result<codec::Decoded> level = codec::decode_level(bytes_of(plan));
    ASSERT_TRUE(level.ok()) << level.error().message;
    std::uint64_t gouraud = 0, flat = 0;
    for (const codec::Primitive& p : level->primitives)
        (p.shading == codec::Shading::flat ? flat : gouraud) += p.mesh.triangles.size();
    EXPECT_EQ(gouraud, plan.shading.gouraud);
    EXPECT_EQ(flat, plan.shading.flat);
    EXPECT_NE(level->extras_json.find("\"gouraud\":" + std::to_string(gouraud)), std::string::npos);
}

TEST(Planner, TheSamePlanComesFromTheStore) {
    const proto::PlanResponse first = *baked().planner.plan(contract_example());
    const proto::PlanResponse again = *baked().planner.plan(contract_example());
    EXPECT_EQ(again.content.url, first.content.url);
    EXPECT_EQ(again.timing_ms.encode, 0.0);
    EXPECT_EQ(again.left_out.size(), first.left_out.size());
    EXPECT_DOUBLE_EQ(again.level.rms_error, first.level.rms_error);
}

TEST(Planner, WhereFlatIsNoFasterAllIsGouraudAndThePlanSaysSo) {
    proto::PlanRequest request = large_hybrid();
    request.budget.device.triangles_per_second = 1e9;
    const auto says_so = [](const proto::PlanResponse& plan) {
        return std::any_of(plan.warnings.begin(), plan.warnings.end(),
                           [](const std::string& w) { return w.find("flat triangles hardly faster") != w.npos; });
    };
    for (const double flat : {0.5e9, 1.0e9, 1.09e9}) {
        request.budget.device.flat_triangles_per_second = flat;
        const proto::PlanResponse plan = *baked().planner.plan(request);
        EXPECT_EQ(plan.shading.mode, "gouraud") << flat;
        EXPECT_TRUE(says_so(plan));
    }
    request.budget.device.flat_triangles_per_second = 4e9;
    const proto::PlanResponse dear = *baked().planner.plan(request);
    EXPECT_EQ(dear.shading.mode, "hybrid");
    EXPECT_FALSE(says_so(dear));
    request.budget.device.flat_triangles_per_second = 1e9;
    request.shading = proto::ShadingMode::flat;
    EXPECT_EQ(baked().planner.plan(request)->shading.gouraud, 0u);
}

TEST(Planner, PureModesSendAllOrNoNormals) {
    for (proto::PlanRequest request : {contract_example(), large_hybrid()}) {
        const proto::PlanResponse hybrid = *baked().planner.plan(request);
        request.shading = proto::ShadingMode::gouraud;
        const proto::PlanResponse gouraud = *baked().planner.plan(request);
        request.shading = proto::ShadingMode::flat;
        const proto::PlanResponse flat = *baked().planner.plan(request);
        EXPECT_EQ(gouraud.shading.flat, 0u);
        EXPECT_EQ(flat.shading.gouraud, 0u);
        EXPECT_LT(flat.content.bytes, gouraud.content.bytes);
        EXPECT_LE(hybrid.content.bytes, gouraud.content.bytes);
    }
}

TEST(Planner, NearIsAllGouraudAndFarAllFlat) {
    proto::PlanRequest request = contract_example();
    request.view->eye = {0, 0, 1};
    EXPECT_EQ(baked().planner.plan(request)->shading.flat, 0u);
    request.view->eye = {0, 0, 1e6};
    EXPECT_EQ(baked().planner.plan(request)->shading.gouraud, 0u);
}

// The law of the service: never above the budget, and equal to it wherever the mesh allows.
TEST(Planner, LevelsOfAThousandRandomDevicesHoldTheirBudget) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> exponent(-1.0, 4.0);
    std::size_t equal = 0;
    constexpr int devices = 1000;
    for (int i = 0; i < devices; ++i) {
        proto::PlanRequest request = request_for(i % 2 ? "teapot" : "hills", std::pow(10.0, exponent(random)));
        request.budget.device.gpu = random() % 2 ? budget::Gpu::discrete : budget::Gpu::none;
        if (random() % 2)
            request.budget.display = budget::Display{1 + static_cast<std::uint32_t>(random() % 3000),
                                                     1 + static_cast<std::uint32_t>(random() % 2000)};
        if (random() % 2) request.budget.device.memory_mb = std::pow(10.0, exponent(random) - 2.0);
        if (random() % 2)
            request.budget.network =
                budget::Network{std::pow(10.0, exponent(random) - 3.0), static_cast<double>(random() % 400), 2};
        request.shading = proto::ShadingMode::flat;  // the count does not depend on the split, and flat encodes fastest
        const Result<proto::PlanResponse> plan = baked().planner.plan(request);
        ASSERT_TRUE(plan.ok()) << plan.error().message;
        ASSERT_GE(plan->level.triangles, 1u);
        ASSERT_LE(plan->level.triangles, plan->budget.triangles);
        ASSERT_GE(plan->level.triangles + 2, plan->budget.triangles);
        ASSERT_EQ(plan->shading.gouraud + plan->shading.flat, plan->level.triangles);
        equal += plan->level.triangles == plan->budget.triangles;
    }
    EXPECT_GT(equal, devices / 2u);
    RecordProperty("equal_to_budget", static_cast<int>(equal));
}

TEST(Planner, ContentFitsTheNetwork) {
    for (const double mbps : {0.02, 0.03, 0.05}) {
        proto::PlanRequest request = request_for("hills", 3400);
        request.budget.network = budget::Network{mbps, 100, 1};
        const proto::PlanResponse plan = *baked().planner.plan(request);
        EXPECT_EQ(plan.budget.limited_by, "network");
        EXPECT_LE(static_cast<double>(plan.content.bytes) * 8 / (mbps * 1e6) + 0.1, 1.0 + 1e-9);
    }
}

std::uint64_t left_out(const proto::PlanResponse& plan, const std::string& what) {
    for (const proto::LeftOut& item : plan.left_out)
        if (item.what == what) return item.bytes;
    return 0;
}

TEST(Planner, SendsNoTexelsBelowAPixelOfTheDisplay) {
    proto::PlanRequest request = request_for("painted", 34000);
    const proto::PlanResponse whole = *baked().planner.plan(request);
    EXPECT_EQ(left_out(whole, "texels below a pixel"), 0u);
    request.budget.display = budget::Display{160, 120};
    request.budget.preference.triangles = 1000;
    const proto::PlanResponse small = *baked().planner.plan(request);
    EXPECT_GT(left_out(small, "texels below a pixel"), whole.content.bytes / 2);
    EXPECT_EQ(left_out(small, "texels beyond the network"), 0u);
    const Result<codec::Decoded> level = codec::decode_level(bytes_of(small));
    ASSERT_TRUE(level.ok());
    EXPECT_LT(level->images.at(0).width, 512u);
    EXPECT_GE(level->images.at(0).width, 60u);
    EXPECT_EQ(baked().planner.plan(request)->content.url, small.content.url);
}

// The images get half of the network, so that the triangles are not left with nothing.
TEST(Planner, TexturesLeaveTheTrianglesTheirShareOfTheNetwork) {
    for (const double kilobytes : {4.0, 5.0, 6.0}) {
        proto::PlanRequest request = request_for("painted", 34000);
        request.budget.network = budget::Network{kilobytes * 8 / 1000, 0, 1};
        const proto::PlanResponse plan = *baked().planner.plan(request);
        EXPECT_EQ(plan.budget.limited_by, "network");
        EXPECT_TRUE(plan.budget.feasible);
        EXPECT_GT(plan.level.triangles, 50u) << kilobytes;
        EXPECT_LE(static_cast<double>(plan.content.bytes), 1000 * kilobytes);
        EXPECT_GT(left_out(plan, "texels beyond the network"), 0u);
    }
}

TEST(Planner, ACutHasImagesThatFitItsError) {
    const Result<Planner::Cut> cut = baked().planner.cut("painted", 2);
    ASSERT_TRUE(cut.ok());
    EXPECT_LT(cut->model.images.at(0).width, 512u);
}

TEST(Planner, InfeasibleGetsTheLeastThereIsAndSaysSo) {
    proto::PlanRequest request = request_for("teapot", 3400);
    request.budget.network = budget::Network{0.0001, 0, 0.1};
    const proto::PlanResponse plan = *baked().planner.plan(request);
    EXPECT_EQ(plan.level.triangles, 1u);
    EXPECT_FALSE(plan.budget.feasible);
    ASSERT_FALSE(plan.warnings.empty());
    EXPECT_NE(plan.warnings.back().find("less than one triangle"), std::string::npos);
}

TEST(Planner, LeanIsTheSameLevelInFewerBytes) {
    proto::PlanRequest request = request_for("teapot", 3400);
    const proto::PlanResponse plain = *baked().planner.plan(request);
    request.profile = proto::Profile::lean;
    const proto::PlanResponse lean = *baked().planner.plan(request);
    EXPECT_EQ(lean.content.profile, "lean");
    EXPECT_EQ(plain.content.profile, "plain");
    EXPECT_EQ(lean.level.triangles, plain.level.triangles);
    EXPECT_NE(lean.content.url, plain.content.url);
    EXPECT_LT(lean.content.bytes, plain.content.bytes);
}

TEST(Planner, RefusesWhatItCannotServe) {
    EXPECT_EQ(baked().planner.plan(request_for("nobody", 300)).error().code, ErrorCode::not_found);
    EXPECT_EQ(baked().planner.plan(request_for("baking", 300)).error().code, ErrorCode::unavailable);
    EXPECT_EQ(baked().planner.plan(request_for("teapot", -1)).error().code, ErrorCode::invalid_input);
    EXPECT_EQ(baked().planner.cut("teapot", 0).error().code, ErrorCode::invalid_input);
}

TEST(Planner, ExtremeViewsGiveFiniteAnswers) {
    for (const double far : {1e-30, 1e30, 1e300}) {
        proto::PlanRequest request = request_for("hills", 100);
        request.view = shading::View{{far, far, far}, {0, 0, 0}, 45, {far, 1, 0}};
        const Result<proto::PlanResponse> plan = baked().planner.plan(request);
        ASSERT_TRUE(plan.ok()) << plan.error().message;
        EXPECT_TRUE(std::isfinite(plan->level.screen_space_error_px));
        EXPECT_TRUE(std::isfinite(plan->shading.distance));
    }
}

TEST(Planner, AnAssetThatBakesAnswersWithItsFinestFirstLevelWithinTheBudget) {
    const proto::Asset asset = *baked().store.asset("prepared");
    for (const double mhz : {34000.0, 400.0, 100.0}) {
        const Result<proto::PlanResponse> plan = baked().planner.plan(request_for("prepared", mhz));
        ASSERT_TRUE(plan.ok()) << plan.error().message;
        const auto level = std::find_if(asset.levels.begin(), asset.levels.end(),
                                        [&](const proto::Level& l) { return l.triangles <= plan->budget.triangles; });
        EXPECT_EQ(plan->level.triangles, level->triangles);
        EXPECT_EQ(plan->content.url, level->url);
        EXPECT_EQ(plan->content.bytes, bytes_of(*plan).size());
        EXPECT_EQ(plan->shading.gouraud + plan->shading.flat, plan->level.triangles);
        EXPECT_EQ(plan->shading.mode, "gouraud");
        EXPECT_GT(plan->level.rms_error, 0.0);
        EXPECT_GT(plan->level.screen_space_error_px, 0.0);
        ASSERT_EQ(plan->warnings.size(), 1u);
        EXPECT_NE(plan->warnings[0].find("a first level"), std::string::npos);
    }
}

TEST(Planner, AFirstLevelThatTheNetworkCarriesIsPreferred) {
    proto::PlanRequest request = request_for("prepared", 34000);
    const proto::Asset asset = *baked().store.asset("prepared");
    const auto mbps = [](std::uint64_t bytes) { return static_cast<double>(bytes) * 8e-6 * 1.01; };  // in one second
    request.budget.network = budget::Network{mbps(asset.levels[1].bytes), 0, 1};
    EXPECT_EQ(baked().planner.plan(request)->content.url, asset.levels[1].url);
}

TEST(Planner, WhatIsTooSmallForAnyFirstLevelWaits) {
    const Result<proto::PlanResponse> plan = baked().planner.plan(request_for("prepared", 1));
    ASSERT_FALSE(plan.ok());
    EXPECT_EQ(plan.error().code, ErrorCode::unavailable);
}

TEST(Planner, AFirstLevelIsNotTheAnswerOnceTheBakeIsDone) {
    testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());
    Planner planner(store);
    mesh::Model ball;
    ball.mesh = testing::sphere(60);
    ball.materials.resize(1);
    proto::Asset asset;
    asset.id = asset.name = "ball";
    ASSERT_TRUE(::lodestream::bake::prepare(store, asset, ball).ok());
    const proto::PlanResponse before = *planner.plan(request_for("ball", 500));
    ASSERT_TRUE(::lodestream::bake::bake_prepared(store, "ball").ok());
    const proto::PlanResponse after = *planner.plan(request_for("ball", 500));
    EXPECT_LT(before.level.triangles, 1001u);
    EXPECT_EQ(after.budget.triangles, before.budget.triangles);
    EXPECT_GE(after.level.triangles + 1, after.budget.triangles);
    EXPECT_LT(after.level.rms_error, before.level.rms_error);
    EXPECT_TRUE(after.warnings.empty() || after.warnings[0].find("first level") == std::string::npos);
    const std::string hash = before.content.url.substr(before.content.url.rfind('/') + 1, 64);
    EXPECT_TRUE(store.file(hash, "glb").ok());  // whoever was sent there still finds it
}

TEST(Planner, SceneSeenFromOutsideGetsALevelOfItsOutside) {
    proto::PlanRequest request = request_for("scene", 3400);
    request.budget.preference.triangles = 500;
    const Result<proto::PlanResponse> plan = baked().planner.plan(request);
    ASSERT_TRUE(plan.ok()) << plan.error().message;
    EXPECT_EQ(plan->level.triangles, 500u);
    ASSERT_TRUE(plan->level.outside);
    EXPECT_LT(plan->level.outside->rms_error, plan->level.rms_error);
    EXPECT_LT(plan->level.outside->max_error, plan->level.max_error);
    const Result<codec::Decoded> level = codec::decode_level(bytes_of(*plan));
    ASSERT_TRUE(level.ok()) << level.error().message;
    for (const codec::Primitive& primitive : level->primitives)
        for (const Vec3f& p : primitive.mesh.positions) EXPECT_GT(length(p), 4.0f);
    const proto::PlanResponse again = *baked().planner.plan(request);
    EXPECT_EQ(again.content.url, plan->content.url);
    EXPECT_EQ(again.level.outside->rms_error, plan->level.outside->rms_error);
}

TEST(Planner, EyeInsideASceneGetsItsInside) {
    proto::PlanRequest request = request_for("scene", 3400);
    request.budget.preference.triangles = 500;
    const proto::PlanResponse outside = *baked().planner.plan(request);
    request.view = shading::View{{3, 0, 0}, {0, 0, 0}, 45, {0.3, 1, 0.5}};
    const Result<proto::PlanResponse> plan = baked().planner.plan(request);
    ASSERT_TRUE(plan.ok()) << plan.error().message;
    EXPECT_FALSE(plan->level.outside);
    EXPECT_NE(plan->content.url, outside.content.url);
    EXPECT_EQ(plan->level.triangles, 500u);
}

}  // namespace
}  // namespace lodestream::planner
