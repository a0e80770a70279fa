#include "common/budget/budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace lodestream::budget {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
const AssetCost endless{std::uint64_t{1} << 40, {}, 1.0};
const AssetCost teapot{6400, {}, 1.0};

Request device(double mhz, Gpu gpu = Gpu::none) {
    Request request;
    request.device.cpu_mhz = mhz;
    request.device.gpu = gpu;
    return request;
}

// A device against Table 1's desktop that drew a million polygons.
Request table_1(double mhz, Gpu gpu = Gpu::none) {
    Request request = device(mhz, gpu);
    request.reference.triangles = 1'000'000;
    return request;
}

std::string error_of(const Request& request) {
    const Result<Budget> budget = derive_budget(request, teapot);
    return budget ? "" : budget.error().message;
}

TEST(Budget, Table1IsExact) {
    EXPECT_EQ(derive_budget(table_1(300), endless)->ncp, 88'235u);
    EXPECT_EQ(derive_budget(table_1(70), endless)->ncp, 20'588u);
    EXPECT_EQ(derive_budget(table_1(1760), endless)->ncp, 517'647u);  // the paper rounds to half a million
    const Budget desktop = *derive_budget(table_1(2460, Gpu::discrete), endless);
    EXPECT_NEAR(desktop.dlr, 1.0, 1e-4);
    EXPECT_NEAR(static_cast<double>(desktop.ncp), 1e6, 100.0);
}

TEST(Budget, PhoneTeapotHas179Triangles) {
    Request phone = device(70);
    phone.reference = {2500.0, 6400};
    const Budget budget = *derive_budget(phone, teapot);
    EXPECT_DOUBLE_EQ(budget.dlr, 0.028);
    EXPECT_EQ(budget.ncp, 179u);
}

TEST(Budget, ContractExampleGives564) {
    Request pda = device(300);
    pda.device.memory_mb = 64;
    pda.display = Display{800, 600};
    pda.network = Network{2, 80, 3};
    pda.reference = {3400, 6400};
    const Budget budget = *derive_budget(pda, teapot);
    EXPECT_NEAR(budget.dlr, 0.0882, 5e-5);
    EXPECT_EQ(budget.ncp, 564u);
    EXPECT_EQ(budget.triangles, 564u);
    EXPECT_EQ(budget.limited_by, LimitedBy::device);
    EXPECT_FALSE(budget.rup.has_value());
}

TEST(Budget, WithoutAReferenceItIsAMillionASecondCappedByTheAsset) {
    Request desktop = device(3400);
    desktop.preference.target_fps = 50;
    EXPECT_EQ(derive_budget(desktop, endless)->triangles, 20'000u);
    const Budget capped = *derive_budget(desktop, teapot);
    EXPECT_EQ(capped.triangles, 6400u);
    EXPECT_EQ(capped.limited_by, LimitedBy::asset);
}

TEST(Budget, AMeasuredRateReplacesTheClock) {
    Request measured = table_1(1);
    measured.device.triangles_per_second = 500'000;
    EXPECT_EQ(derive_budget(measured, endless)->ncp, 500'000u);
    measured.device.cpu_mhz = 0;  // need not be told then
    EXPECT_EQ(derive_budget(measured, endless)->ncp, 500'000u);
}

TEST(Budget, UserMayAskForLessNeverForMore) {
    Request request = device(3400);
    request.reference.triangles = 1000;
    request.preference.triangles = 250;
    Budget budget = *derive_budget(request, endless);
    EXPECT_DOUBLE_EQ(*budget.rup, 0.25);
    EXPECT_EQ(budget.triangles, 250u);
    EXPECT_EQ(budget.limited_by, LimitedBy::user);

    request.preference.triangles = 4000;
    budget = *derive_budget(request, endless);
    EXPECT_DOUBLE_EQ(*budget.rup, 4.0);
    EXPECT_EQ(budget.triangles, 1000u);
    EXPECT_EQ(budget.limited_by, LimitedBy::device);

    request.preference.triangles.reset();
    request.preference.quality = 0.5;
    EXPECT_EQ(derive_budget(request, endless)->triangles, 500u);
}

TEST(Budget, QualityAboveOneCountsAsOne) {
    Request request = device(3400);
    request.preference.quality = 7.0;
    EXPECT_EQ(derive_budget(request, teapot)->triangles, 6400u);
    EXPECT_FALSE(derive_budget(request, teapot)->rup.has_value());
}

TEST(Display, Table2AtItsRowsBetweenAndBeyond) {
    EXPECT_DOUBLE_EQ(triangles_for_display(800 * 600), 8'000);
    EXPECT_DOUBLE_EQ(triangles_for_display(1024 * 768), 12'000);
    EXPECT_DOUBLE_EQ(triangles_for_display(1280 * 1024), 26'000);
    EXPECT_DOUBLE_EQ(triangles_for_display((800 * 600 + 1024 * 768) / 2.0), 10'000);
    EXPECT_DOUBLE_EQ(triangles_for_display(400 * 300), 2'000);
    EXPECT_NEAR(triangles_for_display(1280 * 1024 + 52'428.8), 27'400, 1e-6);  // 14,000 more over 524,288 px more
    EXPECT_DOUBLE_EQ(triangles_for_display(0), 0);
}

TEST(Display, NeedGrowsWithThePixels) {
    double last = -1.0;
    for (double pixels = 1; pixels < 1e10; pixels *= 1.3) {
        const double need = triangles_for_display(pixels);
        EXPECT_GT(need, last);
        last = need;
    }
}

TEST(Budget, EachLimitIsNamedWhereItBinds) {
    Request request = table_1(3400);
    request.display = Display{800, 600};
    EXPECT_EQ(derive_budget(request, endless)->limited_by, LimitedBy::display);
    EXPECT_EQ(derive_budget(request, endless)->triangles, 8'000u);

    request.device.memory_mb = 1;
    EXPECT_EQ(derive_budget(request, endless)->limited_by, LimitedBy::memory);
    EXPECT_EQ(derive_budget(request, endless)->triangles, 3'906u);  // 1e6 / 4 / 64

    AssetCost cost = endless;
    cost.sizes = {{1000, 5000}, {500, 3000}};
    request.network = Network{0.008, 1000, 4};  // 1000 bytes/s for 3 s
    EXPECT_EQ(derive_budget(request, cost)->limited_by, LimitedBy::network);
    EXPECT_EQ(derive_budget(request, cost)->triangles, 500u);

    EXPECT_EQ(derive_budget(request, AssetCost{12, cost.sizes, 1.0})->limited_by, LimitedBy::asset);
}

TEST(Network, SizesAreInterpolatedAndContinued) {
    const AssetCost cost{1000, {{1000, 5000}, {500, 3000}, {250, 2500}}, 1.0};
    EXPECT_DOUBLE_EQ(triangles_within_bytes(cost, 4000), 750);
    EXPECT_DOUBLE_EQ(triangles_within_bytes(cost, 9000), 2000);
    EXPECT_DOUBLE_EQ(triangles_within_bytes(cost, 2750), 375);
    EXPECT_DOUBLE_EQ(triangles_within_bytes(cost, 2250), 125);
    EXPECT_LT(triangles_within_bytes(cost, 0), 0);
    EXPECT_EQ(triangles_within_bytes(AssetCost{}, 10), infinity);
}

TEST(Budget, FixedBytesAreTheNetworksAndNotTheTriangles) {
    Request request;
    request.device.cpu_mhz = 1e6;
    request.network = Network{0.08, 0.0, 1.0};  // 10,000 bytes
    AssetCost cost{1'000'000, {{1'000'000, 10'000'000}, {100, 1'000}}, 1.0, 0};
    EXPECT_EQ(derive_budget(request, cost)->triangles, 1'000u);
    cost.fixed_bytes = 5'000;
    EXPECT_EQ(derive_budget(request, cost)->triangles, 500u);
    EXPECT_DOUBLE_EQ(network_excess(request, cost, 10'000), 1.0);
    EXPECT_DOUBLE_EQ(network_excess(request, cost, 15'000), 2.0);
    EXPECT_DOUBLE_EQ(network_bytes(request), 10'000.0);
    cost.fixed_bytes = 20'000;
    EXPECT_EQ(derive_budget(request, cost)->triangles, 1u);
    EXPECT_FALSE(derive_budget(request, cost)->feasible);
    request.network.reset();
    EXPECT_EQ(network_excess(request, cost, 10'000), 0.0);
    EXPECT_EQ(network_bytes(request), infinity);
}

TEST(Network, EqualSizesDoNotDivideByZero) {
    const AssetCost cost{10, {{10, 700}, {5, 700}}, 1.0};
    EXPECT_TRUE(std::isfinite(triangles_within_bytes(cost, 700)));
    EXPECT_TRUE(std::isfinite(triangles_within_bytes(cost, 0)));
}

TEST(Budget, InfeasibleGivesOneTriangleAndSaysSo) {
    AssetCost cost = teapot;
    cost.sizes = {{6400, 50'000}, {100, 2'000}};
    Request request = device(3400);
    request.network = Network{0.001, 5000, 1};  // the round trip alone takes longer
    const Budget budget = *derive_budget(request, cost);
    EXPECT_EQ(budget.triangles, 1u);
    EXPECT_EQ(budget.limited_by, LimitedBy::network);
    EXPECT_FALSE(budget.feasible);

    EXPECT_EQ(derive_budget(device(1e-300), teapot)->triangles, 1u);
    EXPECT_FALSE(derive_budget(device(1e-300), teapot)->feasible);
}

TEST(Budget, OfAnEmptyAssetIsZero) {
    EXPECT_EQ(derive_budget(device(3400), AssetCost{})->triangles, 0u);
}

TEST(Budget, HugeNumbersSaturate) {
    Request request = device(1e308, Gpu::discrete);
    request.reference = {1e-308, std::numeric_limits<std::uint64_t>::max()};
    const Budget budget = *derive_budget(request, endless);
    EXPECT_TRUE(std::isfinite(budget.dlr));
    EXPECT_EQ(budget.ncp, static_cast<std::uint64_t>(max_triangles));
}

TEST(Budget, RefusesWhatIsNotANumberAboveZeroAndNamesIt) {
    for (const double bad : {0.0, -1.0, nan, infinity, -infinity}) {
        EXPECT_NE(error_of(device(bad)).find("device.cpu_mhz"), std::string::npos) << bad;
        const auto with = [&](auto set) {
            Request request = device(100);
            set(request);
            return error_of(request);
        };
        EXPECT_NE(with([&](Request& r) { r.device.memory_mb = bad; }).find("device.memory_mb"), std::string::npos);
        EXPECT_NE(with([&](Request& r) { r.device.triangles_per_second = bad; }).find("device.triangles_per_second"),
                  std::string::npos);
        EXPECT_NE(with([&](Request& r) { r.preference.quality = bad; }).find("preference.quality"), std::string::npos);
        EXPECT_NE(with([&](Request& r) { r.preference.target_fps = bad; }).find("preference.target_fps"),
                  std::string::npos);
        EXPECT_NE(with([&](Request& r) {
                      r.network = Network{bad, 0, 1};
                  }).find("network.downlink_mbps"),
                  std::string::npos);
        EXPECT_NE(with([&](Request& r) {
                      r.network = Network{1, 0, bad};
                  }).find("network.max_wait_s"),
                  std::string::npos);
        EXPECT_NE(with([&](Request& r) { r.reference.capacity_mhz = bad; }).find("reference.capacity_mhz"),
                  std::string::npos);
        if (bad == 0.0) continue;  // no round trip at all is fine
        EXPECT_NE(with([&](Request& r) { r.network = Network{1, bad, 1}; }).find("network.rtt_ms"), std::string::npos);
    }
    Request request = device(100);
    request.display = Display{0, 600};
    EXPECT_NE(error_of(request).find("display.width"), std::string::npos);
    request.display = Display{800, 0};
    EXPECT_NE(error_of(request).find("display.height"), std::string::npos);
    request = device(100);
    request.device.cpu_cores = 0;
    EXPECT_NE(error_of(request).find("device.cpu_cores"), std::string::npos);
    request = device(100);
    request.preference.triangles = 0;
    EXPECT_NE(error_of(request).find("preference.triangles"), std::string::npos);
    request = device(100);
    request.reference.triangles = 0;
    EXPECT_NE(error_of(request).find("reference.triangles"), std::string::npos);
}

TEST(Budget, FrameRatesAreClamped) {
    Request request = device(3400);
    request.preference.target_fps = 1e-9;
    EXPECT_EQ(derive_budget(request, endless)->triangles, 1'000'000u);
    request.preference.target_fps = 1e12;
    EXPECT_EQ(derive_budget(request, endless)->triangles, 1'000u);
}

// Laws over random devices: the budget is never above any of its limits, and a stronger device never gets less.
TEST(Budget, IsBelowEveryLimitAndMonotonicInCapacity) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> exponent(-3, 6);
    const AssetCost cost{250'000, {{250'000, 700'000}, {60'000, 200'000}, {500, 4'000}}, 1.0};
    for (int i = 0; i < 1000; ++i) {
        Request request = device(std::pow(10.0, exponent(random)));
        request.display =
            Display{static_cast<std::uint32_t>(1 + random() % 8000), static_cast<std::uint32_t>(1 + random() % 8000)};
        request.device.memory_mb = std::pow(10.0, exponent(random));
        request.network = Network{std::pow(10.0, exponent(random)), static_cast<double>(random() % 300), 3};
        const Budget budget = *derive_budget(request, cost);
        ASSERT_GE(budget.triangles, 1u);
        ASSERT_LE(budget.triangles, cost.triangles);
        ASSERT_LE(budget.triangles, std::max<std::uint64_t>(budget.ncp, 1));
        request.device.cpu_mhz *= 2;
        ASSERT_GE(derive_budget(request, cost)->triangles, budget.triangles);
    }
}

Request point_request(double mhz) {
    Request request;
    request.device.cpu_mhz = mhz;
    return request;
}

TEST(PointBudget, IsTheDevicesShareOfPointsASecond) {
    const PointCost plenty{1'000'000, 0, 1'000'000, 2048, 16};
    Request request = point_request(340.0);  // a tenth of the reference
    EXPECT_EQ(derive_point_budget(request, plenty)->points, 1666u);
    PointCost small = plenty;
    small.triangles = 6400;  // of which the reference draws no more
    EXPECT_EQ(derive_point_budget(request, small)->points, 320u);
    request.device.points_per_second = 60'000;
    EXPECT_EQ(derive_point_budget(request, plenty)->points, 2000u);
    request.preference.quality = 0.5;
    EXPECT_EQ(derive_point_budget(request, plenty)->points, 1000u);
    EXPECT_EQ(derive_point_budget(request, plenty)->limited_by, LimitedBy::user);
}

TEST(PointBudget, EachLimitIsNamedWhereItBinds) {
    Request request = point_request(3400.0);
    const PointCost plenty{1'000'000, 0, 1'000'000, 2048, 16};
    EXPECT_EQ(derive_point_budget(request, plenty)->limited_by, LimitedBy::device);
    EXPECT_EQ(derive_point_budget(request, {1'000'000, 0, 50, 2048, 16})->limited_by, LimitedBy::display);
    EXPECT_EQ(derive_point_budget(request, {50, 0, 50, 2048, 16})->limited_by, LimitedBy::asset);
    request.network = Network{0.008, 0.0, 3.0};  // 3,000 bytes
    const auto network = derive_point_budget(request, plenty);
    EXPECT_EQ(network->limited_by, LimitedBy::network);
    EXPECT_EQ(network->points, 59u);
    request.network.reset();
    request.device.memory_mb = 0.001;
    EXPECT_EQ(derive_point_budget(request, plenty)->limited_by, LimitedBy::memory);
}

TEST(PointBudget, GivesOnePointWhereNoneIsAllowedAndNoneWhereThereIsNone) {
    Request request = point_request(1e-9);
    const auto one = derive_point_budget(request, {100, 0, 100, 2048, 16});
    EXPECT_EQ(one->points, 1u);
    EXPECT_FALSE(one->feasible);
    const auto none = derive_point_budget(request, {});
    EXPECT_EQ(none->points, 0u);
    EXPECT_TRUE(none->feasible);
    request.device.points_per_second = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(derive_point_budget(request, {}));
    EXPECT_EQ(derive_point_budget(point_request(1e300), {~0ull, 0, ~0ull, 0, 0})->points, 4294967295u);
}

TEST(Operations, ShadingIsOneAFlatAndFourAGouraudPolygon) {
    EXPECT_EQ(with_shading(57'600, 179, 6221).criterion, 57'600u);
    EXPECT_EQ(with_shading(57'600, 179, 6221).total, 64'537u);
    EXPECT_EQ(with_shading(0, 0, 0).total, 0u);
}

}  // namespace
}  // namespace lodestream::budget
